"""Test which frames an export has, and what replaces plates that are missing or damaged."""

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
    export_and_list_new_frames,
    export_shot,
    exr,
    files_in,
    names_of,
    refused_export_message,
    render_frame_of_shot,
    same_frames,
    shot_of,
    write_plate,
)


@pytest.mark.parametrize(
    ("words", "frames"),
    [
        ((), (1002, 1003, 1004)),
        (("--frames", "1001-1006x2"), (1001, 1003, 1005)),
        (("--frames", "1006,1001"), (1001, 1006)),
    ],
)
def test_export_uses_in_out_range_or_requested_frames(
    capsys, tmp_path, shot_file, out, words, frames
):
    write_shot(shot_file, replace(read_shot(shot_file), in_out=FrameRange(1002, 1004)))
    message = export_shot(capsys, shot_file, out, *words)
    assert list(files_in(out.parent)) == names_of(".exr", frames)
    assert f"{len(frames)} frames written." in message


def test_export_of_still_covers_all_key_frames(capsys, tmp_path, out):
    still = write_plate(tmp_path / "still.exr")
    shot = replace(shot_of(str(still)), frames=None)
    write_shot(tmp_path / "s.heatlens.json", shot)
    export_shot(capsys, tmp_path / "s.heatlens.json", out)
    assert list(files_in(out.parent)) == names_of(".exr")
    assert not same_frames(out.parent / "n.1001.exr", out.parent / "n.1006.exr")


def test_export_of_plates_without_shot_uses_one_lens(capsys, shot_file, out, tmp_path):
    pattern = tmp_path / "plates" / "plate.####.exr"
    words = ("--bokeh", "heat", "--quality", "draft", "--f-stop", "1.4")
    message = export_shot(capsys, pattern, out, *words, "--frames", "1002-1003", "-v")
    assert "f/1.4 (--f-stop)" in message and "focus 2.24 m (header, focus)" in message
    lens = replace(read_shot(shot_file).lens, focus_distance_m=float(np.float32(2.24)))
    shot = Shot(lens, defocus=QUICK, source=str(pattern))
    for frame in (1002, 1003):
        alone = render_frame_of_shot(capsys, shot, frame, tmp_path / "alone.exr")
        assert same_frames(out.parent / f"n.{frame}.exr", alone)


def test_plate_option_replaces_missing_plates_of_shot(capsys, shot_file, out, tmp_path):
    (tmp_path / "plates").rename(tmp_path / "moved")
    assert "plates" in refused_export_message(capsys, shot_file, out)
    export_shot(capsys, shot_file, out, "--plate", tmp_path / "moved" / "plate.####.exr")
    assert list(files_in(out.parent)) == names_of(".exr")


def test_export_handles_frames_of_different_size(capsys, shot_file, out, tmp_path):
    write_plate(tmp_path / "plates" / "plate.1003.exr", size=(20, 30))
    export_shot(capsys, shot_file, out)
    shapes = [exr(out.parent / name)[1]["R"].shape for name in names_of(".exr")]
    assert shapes == [(HEIGHT, WIDTH)] * 2 + [(30, 20)] + [(HEIGHT, WIDTH)] * 3


@pytest.fixture
def shot_with_gaps(shot_file, tmp_path):
    """Return a sequence in which 1003 and 1006 have no plate."""
    for frame in (1003, 1006):
        (tmp_path / "plates" / f"plate.{frame}.exr").unlink()
    return shot_file


def test_export_refuses_missing_plates_before_writing(capsys, shot_with_gaps, out):
    message = refused_export_message(capsys, shot_with_gaps, out)
    assert "2 of 6 frames: 1003,1006" in message and "--missing hold" in message
    assert not out.parent.exists()


def test_missing_hold_renders_previous_plate_with_lens_of_frame(
    capsys, shot_with_gaps, out, tmp_path
):
    export_shot(capsys, shot_with_gaps, out, "--missing", "hold")
    assert list(files_in(out.parent)) == names_of(".exr")
    shot = replace(read_shot(shot_with_gaps), source=str(tmp_path / "plates" / "plate.1002.exr"))
    alone = render_frame_of_shot(capsys, shot, 1003, tmp_path / "alone.exr")
    assert same_frames(out.parent / "n.1003.exr", alone)
    assert not same_frames(out.parent / "n.1003.exr", out.parent / "n.1002.exr")


def test_missing_black_writes_black_frame_of_plate_size(capsys, shot_with_gaps, out):
    export_shot(capsys, shot_with_gaps, out, "--missing", "black", "--with-depth")
    _, channels = exr(out.parent / "n.1003.exr")
    assert all((channels[name] == 0).all() for name in "RGB")
    assert channels["R"].shape == (HEIGHT, WIDTH) and np.isinf(channels["Z"]).all()
    assert exr(out.parent / "n.1004.exr")[1]["R"].any()


def test_export_stops_at_damaged_plate_and_keeps_finished_frames(capsys, shot_file, out, tmp_path):
    plate = tmp_path / "plates" / "plate.1004.exr"
    whole = plate.read_bytes()
    half = len(whole) // 2
    plate.write_bytes(whole[:half] + bytes(64) + whole[half + 64 :])  # of its full length
    message = refused_export_message(capsys, shot_file, out)
    assert "plate.1004.exr" in message and "damaged or cut short" in message
    assert list(files_in(out.parent)) == names_of(".exr", (1001, 1002, 1003))
    plate.write_bytes(whole)
    assert "3 frames written, 3" in export_shot(capsys, shot_file, out)


def test_keep_channels_copies_channels_bit_for_bit(capsys, shot_file, out, tmp_path):
    """A black frame of `--missing black` has no plate, so no channel is copied into it."""
    export_shot(capsys, shot_file, out)
    (tmp_path / "plates" / "plate.1003.exr").unlink()
    words = ("--keep-channels", "all")
    export_shot(capsys, shot_file, out, *words, "--missing", "black")
    for frame in FRAMES:
        channels = exr(out.parent / f"n.{frame}.exr")[1]
        if frame == 1003:
            assert set(channels) == set("RGB")
        else:
            plate = exr(tmp_path / "plates" / f"plate.{frame}.exr")[1]
            assert channels["Z"].tobytes() == plate["Z"].tobytes()
    assert export_and_list_new_frames(capsys, shot_file, out, *words, "--missing", "black") == []
    assert export_and_list_new_frames(capsys, shot_file, out, "--missing", "black") == list(FRAMES)
