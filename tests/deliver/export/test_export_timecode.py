"""Test `export --start-timecode`, which counts from the first frame of plates, stills and shots."""

import argparse
from fractions import Fraction

import OpenEXR
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.deliver.export.plan import fingerprint_of, plan_export
from heatlens.fronts.commands.export_options import add_export_options, make_export_job
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.timecode import rate_at, timecode_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.opened_plates import open_plates
from support.exports import export_shot, write_plate, write_plates
from support.session_files import room_file

LENS = ("--f-stop", 2, "--focus-distance", 2, "--method", "pyramid")


def job(source: object, out: object, *words: object):
    """Return the export job of a command line without running it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("shot")
    parser.add_argument("-o", "--output")
    add_export_options(parser)
    return make_export_job(parser.parse_args([str(source), "-o", str(out), *map(str, words)]))


def timecodes(export_job) -> list[str]:
    """Return the timecode of each frame of a job whose plates have no timecode themselves."""
    first = min(export_job.frames)
    return [str(export_job.shot.timecode_at(frame, None, first)) for frame in export_job.frames]


def test_timecode_of_plates_counts_from_first_file(tmp_path, capsys):
    plates, out = write_plates(tmp_path / "p"), tmp_path / "o" / "o.####.exr"
    words = ("--frames", "1003-1004", "--start-timecode", "10:00:00:00", *LENS)
    export_shot(capsys, plates, out, *words)
    headers = [read_parts(tmp_path / "o" / f"o.{frame}.exr")[0][0] for frame in (1003, 1004)]
    assert [str(timecode_of(header)) for header in headers] == ["10:00:00:02", "10:00:00:03"]


def test_start_timecode_exports_same_frames_for_plates_with_gaps(tmp_path):
    plates, out = write_plates(tmp_path / "p", (1001, 1002, 1005)), tmp_path / "o.mov"
    words = ("--missing", "hold", "--start-timecode", "10:00:00:23", *LENS)
    export_job = job(plates, out, *words)
    assert export_job.frames == job(plates, out, "--missing", "hold", *LENS).frames
    assert timecodes(export_job)[:2] == ["10:00:00:23", "10:00:01:00"]


@pytest.mark.parametrize("name", ["hero.exr", "hero.1001.exr"])
def test_timecode_of_still_counts_from_first_requested_frame(tmp_path, name):
    still = write_plate(tmp_path / name)
    words = ("--frames", "11-13", "--start-timecode", "10:00:00:00", *LENS)
    export_job = job(still, tmp_path / "o.mov", *words)
    assert timecodes(export_job) == ["10:00:00:00", "10:00:00:01", "10:00:00:02"]
    frames = plan_export(export_job).frames
    assert len({frame.origin.frame for frame in frames}) == 1  # the same file at every frame
    later_job = job(still, tmp_path / "o.mov", "--frames", "12-13", *words[2:])
    fingerprints = [
        fingerprint_of(m, 12, frames[1].lens, frames[1].origin) for m in (export_job, later_job)
    ]
    assert (
        fingerprints[0] != fingerprints[1]
    )  # frame 12 has another timecode there, and is rendered again


def test_timecode_of_shot_counts_from_first_frame_with_drop_frames(shot_file, tmp_path):
    words = ("--fps", 29.97, "--start-timecode", "00:00:59;28")
    export_job = job(shot_file, tmp_path / "o.mov", *words)
    assert timecodes(export_job)[:3] == ["00:00:59;28", "00:00:59;29", "00:01:00;02"]
    part_job = job(shot_file, tmp_path / "o.mov", *words, "--frames", "1003-1004")
    assert timecodes(part_job) == timecodes(export_job)[2:4]


@pytest.mark.parametrize(("rate", "exact"), [("24", (24, 1)), ("23.976", (24000, 1001))])
def test_exported_exr_holds_frame_rate_that_is_read_back(capsys, tmp_path, rate, exact):
    """A player has to guess the frame rate of a timecode if the header has none."""
    source = str(tmp_path / "plate.####.exr")
    for frame in (1, 2):
        room_file(tmp_path / f"plate.{frame:04}.exr", 16, 12)
    words = ("--fps", rate, "--bokeh", "heat", "--quality", "draft", "--with-depth")
    export_shot(capsys, source, tmp_path / "out.####.exr", *words)
    header = OpenEXR.File(str(tmp_path / "out.0001.exr")).header()
    assert header["framesPerSecond"] == Fraction(*exact)
    assert rate_at(header) == pytest.approx(exact[0] / exact[1])
    opened = open_plates(Opening(str(tmp_path / "out.####.exr"), PlateOptions()))
    try:
        shot = opened.shot(opened.lens({}).lens, DefocusSettings())
        assert shot.frames_per_second == pytest.approx(exact[0] / exact[1])
    finally:
        opened.close()
    message = export_shot(capsys, source, tmp_path / "out.####.exr", *words[2:], "--fps", "30")
    assert "finished before" not in message


@pytest.mark.parametrize("value", [Fraction(0, 1), Fraction(-24, 1), float("nan"), "24", None])
def test_rate_at_returns_none_for_invalid_rate(value):
    assert rate_at({"framesPerSecond": value}) is None
