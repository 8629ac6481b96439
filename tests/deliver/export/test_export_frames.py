"""Which frames an export has, and what stands in for plates that are missing or damaged."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.exports import (
    FRAMES,
    HEIGHT,
    QUICK,
    WIDTH,
    exported,
    exr,
    files_in,
    names_of,
    refused,
    rendered,
    same_frames,
    shot_of,
    write_plate,
    written,
)


@pytest.mark.parametrize(
    ("words", "frames"),
    [
        ((), (1002, 1003, 1004)),
        (("--frames", "1001-1006x2"), (1001, 1003, 1005)),
        (("--frames", "1006,1001"), (1001, 1006)),
    ],
)
def test_frames_from_in_to_out_or_those_that_are_asked_for(
    capsys, tmp_path, shot_file, out, words, frames
):
    write_shot(shot_file, replace(read_shot(shot_file), in_out=FrameRange(1002, 1004)))
    said = exported(capsys, shot_file, out, *words)
    assert list(files_in(out.parent)) == names_of(".exr", frames)
    assert f"{len(frames)} frames written." in said


def test_a_still_is_there_at_every_key_of_its_shot(capsys, tmp_path, out):
    still = write_plate(tmp_path / "still.exr")
    shot = replace(shot_of(str(still)), frames=None)
    write_shot(tmp_path / "s.heatlens.json", shot)
    exported(capsys, tmp_path / "s.heatlens.json", out)
    assert list(files_in(out.parent)) == names_of(".exr")
    assert not same_frames(out.parent / "n.1001.exr", out.parent / "n.1006.exr")


def test_plates_in_the_place_of_a_shot_have_one_lens(capsys, shot_file, out, tmp_path):
    pattern = tmp_path / "plates" / "plate.####.exr"
    words = ("--bokeh", "heat", "--quality", "draft", "--f-stop", "1.4")
    said = exported(capsys, pattern, out, *words, "--frames", "1002-1003")
    assert "f/1.4 (--f-stop)" in said and "focus 2.24 m (header, focus)" in said
    still = replace(read_shot(shot_file).lens, focus_distance_m=float(np.float32(2.24)))
    shot = Shot(still, QUICK, str(pattern))
    for frame in (1002, 1003):
        alone = rendered(capsys, shot, frame, tmp_path / "alone.exr")
        assert same_frames(out.parent / f"n.{frame}.exr", alone)


def test_other_plates_than_the_shots(capsys, shot_file, out, tmp_path):
    (tmp_path / "plates").rename(tmp_path / "moved")
    assert "plates" in refused(capsys, shot_file, out)
    exported(capsys, shot_file, out, "--plate", tmp_path / "moved" / "plate.####.exr")
    assert list(files_in(out.parent)) == names_of(".exr")


def test_frames_may_differ_in_size(capsys, shot_file, out, tmp_path):
    write_plate(tmp_path / "plates" / "plate.1003.exr", size=(20, 30))
    exported(capsys, shot_file, out)
    shapes = [exr(out.parent / name)[1]["R"].shape for name in names_of(".exr")]
    assert shapes == [(HEIGHT, WIDTH)] * 2 + [(30, 20)] + [(HEIGHT, WIDTH)] * 3


@pytest.fixture
def gappy(shot_file, tmp_path):
    """Return a sequence in which 1003 and 1006 have no plate."""
    for frame in (1003, 1006):
        (tmp_path / "plates" / f"plate.{frame}.exr").unlink()
    return shot_file


def test_missing_plates_stop_an_export_before_it_begins(capsys, gappy, out):
    said = refused(capsys, gappy, out)
    assert "2 of 6 frames: 1003,1006" in said and "--missing hold" in said
    assert not out.parent.exists()


def test_hold_renders_the_plate_before_through_the_lens_of_the_frame(capsys, gappy, out, tmp_path):
    exported(capsys, gappy, out, "--missing", "hold")
    assert list(files_in(out.parent)) == names_of(".exr")
    shot = replace(read_shot(gappy), source=str(tmp_path / "plates" / "plate.1002.exr"))
    alone = rendered(capsys, shot, 1003, tmp_path / "alone.exr")
    assert same_frames(out.parent / "n.1003.exr", alone)
    assert not same_frames(out.parent / "n.1003.exr", out.parent / "n.1002.exr")


def test_black_is_black_in_the_size_of_the_plates(capsys, gappy, out):
    exported(capsys, gappy, out, "--missing", "black", "--with-depth")
    _, channels = exr(out.parent / "n.1003.exr")
    assert all((channels[name] == 0).all() for name in "RGB")
    assert channels["R"].shape == (HEIGHT, WIDTH) and np.isinf(channels["Z"]).all()
    assert exr(out.parent / "n.1004.exr")[1]["R"].any()


def test_a_damaged_plate_stops_there_and_what_is_done_stays(capsys, shot_file, out, tmp_path):
    plate = tmp_path / "plates" / "plate.1004.exr"
    whole = plate.read_bytes()
    half = len(whole) // 2
    plate.write_bytes(whole[:half] + bytes(64) + whole[half + 64 :])  # of its full length
    said = refused(capsys, shot_file, out)
    assert "plate.1004.exr" in said and "damaged or cut short" in said
    assert list(files_in(out.parent)) == names_of(".exr", (1001, 1002, 1003))
    plate.write_bytes(whole)
    assert "3 frames written, 3" in exported(capsys, shot_file, out)


def test_other_channels_of_the_plates_are_kept_bit_for_bit(capsys, shot_file, out, tmp_path):
    """A black frame keeps nothing, for its plate is another's."""
    exported(capsys, shot_file, out)
    (tmp_path / "plates" / "plate.1003.exr").unlink()
    words = ("--keep-channels", "all")
    exported(capsys, shot_file, out, *words, "--missing", "black")
    for frame in FRAMES:
        kept = exr(out.parent / f"n.{frame}.exr")[1]
        if frame == 1003:
            assert set(kept) == set("RGB")
        else:
            plate = exr(tmp_path / "plates" / f"plate.{frame}.exr")[1]
            assert kept["Z"].tobytes() == plate["Z"].tobytes()
    assert written(capsys, shot_file, out, *words, "--missing", "black") == []
    assert written(capsys, shot_file, out, "--missing", "black") == list(FRAMES)
