"""`export --start-timecode`: from the first frame on, for plates, stills and shots."""

import argparse
from fractions import Fraction

import OpenEXR
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.deliver.export.plan import fingerprint_of, planned
from heatlens.fronts.commands.export_options import add_export_options, job_of
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.timecode import rate_at, timecode_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.opened_plates import opened_plates
from support.exports import exported, write_plate, write_plates
from support.session_files import room_file

LENS = ("--f-stop", 2, "--focus-distance", 2, "--method", "pyramid")


def job(source: object, out: object, *words: object):
    """Return the job of a command line, which is not done."""
    parser = argparse.ArgumentParser()
    parser.add_argument("shot")
    parser.add_argument("-o", "--output")
    add_export_options(parser)
    return job_of(parser.parse_args([str(source), "-o", str(out), *map(str, words)]))


def timecodes(made) -> list[str]:
    """Return the timecode of each frame, which no header tells."""
    first = min(made.frames)
    return [str(made.shot.timecode_at(frame, None, first)) for frame in made.frames]


def test_plates_count_from_their_first_file_whatever_is_exported(tmp_path, capsys):
    plates, out = write_plates(tmp_path / "p"), tmp_path / "o" / "o.####.exr"
    words = ("--frames", "1003-1004", "--start-timecode", "10:00:00:00", *LENS)
    exported(capsys, plates, out, *words)
    headers = [read_parts(tmp_path / "o" / f"o.{frame}.exr")[0][0] for frame in (1003, 1004)]
    assert [str(timecode_of(header)) for header in headers] == ["10:00:00:02", "10:00:00:03"]


def test_plates_with_gaps_are_exported_as_without_a_timecode(tmp_path):
    plates, out = write_plates(tmp_path / "p", (1001, 1002, 1005)), tmp_path / "o.mov"
    words = ("--missing", "hold", "--start-timecode", "10:00:00:23", *LENS)
    made = job(plates, out, *words)
    assert made.frames == job(plates, out, "--missing", "hold", *LENS).frames
    assert timecodes(made)[:2] == ["10:00:00:23", "10:00:01:00"]


@pytest.mark.parametrize("name", ["hero.exr", "hero.1001.exr"])
def test_a_still_counts_from_the_first_frame_that_is_asked_for(tmp_path, name):
    still = write_plate(tmp_path / name)
    words = ("--frames", "11-13", "--start-timecode", "10:00:00:00", *LENS)
    made = job(still, tmp_path / "o.mov", *words)
    assert timecodes(made) == ["10:00:00:00", "10:00:00:01", "10:00:00:02"]
    frames = planned(made).frames
    assert len({frame.origin.frame for frame in frames}) == 1  # the same file at every frame
    later = job(still, tmp_path / "o.mov", "--frames", "12-13", *words[2:])
    marks = [fingerprint_of(m, 12, frames[1].lens, frames[1].origin) for m in (made, later)]
    assert marks[0] != marks[1]  # frame 12 has another timecode there, and is rendered again


def test_a_shot_counts_from_its_first_frame_and_drops_numbers_at_its_rate(shot_file, tmp_path):
    words = ("--fps", 29.97, "--start-timecode", "00:00:59;28")
    made = job(shot_file, tmp_path / "o.mov", *words)
    assert timecodes(made)[:3] == ["00:00:59;28", "00:00:59;29", "00:01:00;02"]
    part = job(shot_file, tmp_path / "o.mov", *words, "--frames", "1003-1004")
    assert timecodes(part) == timecodes(made)[2:4]


@pytest.mark.parametrize(("rate", "exact"), [("24", (24, 1)), ("23.976", (24000, 1001))])
def test_frames_tell_their_rate_and_it_is_read_again(capsys, tmp_path, rate, exact):
    """A player that finds a timecode without a rate has to guess."""
    source = str(tmp_path / "plate.####.exr")
    for frame in (1, 2):
        room_file(tmp_path / f"plate.{frame:04}.exr", 16, 12)
    words = ("--fps", rate, "--bokeh", "heat", "--quality", "draft", "--with-depth")
    exported(capsys, source, tmp_path / "out.####.exr", *words)
    header = OpenEXR.File(str(tmp_path / "out.0001.exr")).header()
    assert header["framesPerSecond"] == Fraction(*exact)
    assert rate_at(header) == pytest.approx(exact[0] / exact[1])
    opened = opened_plates(Opening(str(tmp_path / "out.####.exr"), PlateOptions()))
    try:
        shot = opened.shot(opened.lens({}).lens, DefocusSettings())
        assert shot.frames_per_second == pytest.approx(exact[0] / exact[1])
    finally:
        opened.close()
    again = exported(capsys, source, tmp_path / "out.####.exr", *words[2:], "--fps", "30")
    assert "finished before" not in again


@pytest.mark.parametrize("value", [Fraction(0, 1), Fraction(-24, 1), float("nan"), "24", None])
def test_a_rate_that_is_none_is_no_rate(value):
    assert rate_at({"framesPerSecond": value}) is None
