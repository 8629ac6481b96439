"""Test that rows of a table are matched to the frames of the shot by timecode."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.timecode import Timecode
from heatlens.fronts.commands.main import main
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import match_by_timecode
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.header.timecode import exr_timecode
from support.exr_files import write_file
from support.plates import room
from support.shoot_tables import SHOOT_TABLES

START = Timecode(hours=13, minutes=36, seconds=49, frames=7)


def table(first: Timecode, count: int, rate: float = 24.0) -> CameraSamples:
    """Return a table whose focus distance is 1 m plus the number of its row in meters."""
    timecodes = tuple(first.add_frames(n, rate) for n in range(count))
    focus_m = tuple(1.0 + n for n in range(count))
    frames = tuple(range(count))
    return CameraSamples("take", frames, focus_distance_m=focus_m, timecodes=timecodes)


@given(st.integers(-30, 30), st.integers(1, 40), st.sampled_from([24.0, 25.0, 29.97, 48.0]))
def test_match_by_timecode_places_rows_on_frames_and_drops_the_rest(offset, count, rate):
    frames = FrameRange(1001, 1020)
    camera = table(START.add_frames(offset, rate), count, rate)
    placed = match_by_timecode(camera, (1001, START), rate, frames)
    expected = {1001 + offset + n: 1.0 + n for n in range(count) if 1001 + offset + n in frames}
    if not expected:
        assert placed.frames == camera.frames
        assert "No row of the table" in placed.notes[-1]
        return
    assert dict(zip(placed.frames, placed.focus_distance_m, strict=True)) == expected
    assert f"{len(expected)} of {count} rows matched by timecode" in placed.notes[-1]
    outside_count, missing = count - len(expected), frames.count - len(expected)
    assert (f"{outside_count} rows are outside" in placed.notes[-1]) == (outside_count > 0)
    assert (f"{missing} frames of the shot have no row" in placed.notes[-1]) == (missing > 0)


def test_match_by_timecode_assumes_drop_frame_of_shot_for_table():
    start = Timecode(hours=1, minutes=0, seconds=59, frames=28, drop=True)
    rows = (Timecode(1, 0, 59, 28), Timecode(1, 0, 59, 29), Timecode(1, 1, 0, 2))
    camera = CameraSamples("t", (0, 1, 2), focus_distance_m=(1.0, 2.0, 3.0), timecodes=rows)
    assert match_by_timecode(camera, (10, start), 29.97, None).frames == (10, 11, 12)


def test_match_by_timecode_keeps_table_that_cannot_be_matched():
    camera = table(Timecode(hours=0, minutes=0, seconds=0, frames=47), 2, 48.0)
    assert "do not fit the rate" in match_by_timecode(camera, (1, START), 24.0, None).notes[-1]
    assert match_by_timecode(camera, None, 24.0, None) is camera


def test_shot_new_matches_table_rows_to_plate_timecodes(tmp_path, capsys):
    color, depth = room(16, 12)
    channels = {"R": color[..., 0], "G": color[..., 1], "B": color[..., 2], "Z": depth}
    for frame in (1001, 1002, 1003):
        timecode = exr_timecode(START.add_frames(frame - 1002, 24.0))
        write_file(tmp_path / f"p.{frame}.exr", dict(channels), timeCode=timecode)
    take = tmp_path / "take.csv"
    take.write_text(SHOOT_TABLES["arri"])  # begins with START
    out = tmp_path / "s.heatlens.json"
    options = ("--lens-from", str(take), "--sensor-width", "36", "-o", str(out))
    assert main(["shot", "new", str(tmp_path / "p.####.exr"), *options]) == 0
    shot = read_shot(out)
    assert [shot.lens_at(f).focus_distance_m for f in (1002, 1003)] == pytest.approx([4.812, 4.5])
    stderr = capsys.readouterr().err
    assert "2 of 3 rows matched by timecode: 13:36:49:07 is frame 1002" in stderr
    options = (*options, "--overwrite", "--start-timecode", "13:36:49:07")
    assert main(["shot", "new", str(tmp_path / "p.####.exr"), *options]) == 0
    assert read_shot(out).lens_at(1003).focus_distance_m == pytest.approx(4.1)
