"""`export --start-timecode`: from the first frame on, for plates, stills and shots."""

import argparse

import pytest

from heatlens.base.errors import InputError
from heatlens.commands.export_options import add_export_options, job_of
from heatlens.export.fingerprint import fingerprint_of
from heatlens.export.plan import planned
from heatlens.plate.exr.exr_read import read_parts
from heatlens.plate.header.timecode import timecode_of
from support.exports import exported, write_plate, write_plates

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


def test_a_still_for_a_farm_is_refused(tmp_path):
    still = write_plate(tmp_path / "hero.exr")
    words = ("--frames", "1-48", "--start-timecode", "10:00:00:00", "--submit", "openjd")
    with pytest.raises(InputError, match="shot new"):
        job(still, tmp_path / "o.####.exr", *words, *LENS)
