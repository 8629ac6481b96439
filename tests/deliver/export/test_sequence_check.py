"""Test the check of each frame against earlier ones: a warning once, or a refusal if strict."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.deliver.export.sequence_check import SequenceCheck, median_dioptres
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.plate import ReadPixels
from support.exports import CAMERA, FRAMES, shot_of, write_plates
from support.exr_files import write_file
from support.plates import coc_plate_of, plate_of, room

COLOR, DEPTH_M = room(32, 18)


def plate(scale: float = 1.0, **changes: object):
    return plate_of(COLOR, DEPTH_M * np.float32(scale), **changes)


def remark_keys(*plates) -> list[list[str]]:
    check = SequenceCheck(1.0)
    return [[remark.key for remark in check.check(each)] for each in plates]


@given(st.floats(1.1, 19.0), st.booleans())
def test_sequence_check_remarks_jump_of_depth_unit_once(factor, is_nearer):
    scale = 1 / factor if is_nearer else factor
    word = "near" if is_nearer else "far"
    jumped_plate = plate(1 / 39.37 if is_nearer else 100.0)
    assert remark_keys(plate(), plate(scale)) == [[], []]
    keys_per_frame = remark_keys(plate(), jumped_plate, plate(), jumped_plate)
    assert [f"depths {word}" in each for each in keys_per_frame] == [False, True, False, True]


def test_sequence_check_ignores_slow_change_of_depth():
    assert not any(remark_keys(*(plate(1.5**step / 30) for step in range(16))))


def test_sequence_check_remarks_display_window_but_not_data_window():
    wide = replace(plate(), display_window=Box(0, 0, 64, 18))
    cut = replace(plate(), data_window=Box(0, 0, 16, 18))
    keys_per_frame = remark_keys(plate(), cut, wide, wide, plate())
    assert [len(each) for each in keys_per_frame] == [0, 0, 1, 1, 0] and "64x18" in keys_per_frame[
        2
    ][0]


def test_sequence_check_remarks_kinds_of_notes_missing_in_first_plate():
    of_first = plate(notes=("made.exr: 3 of 576 pixels held NaN.",))
    similar_note = plate(notes=("made.exr: 21 of 576 pixels held NaN.",))
    other_note = plate(notes=("made.exr: depth channel 'Z' is negative.",))
    keys_per_frame = remark_keys(of_first, similar_note, other_note, similar_note, other_note)
    assert keys_per_frame == [[], [], ["depth channel 'Z' is negative."], [], keys_per_frame[2]]


def test_sequence_check_skips_plates_without_depths():
    empty = replace(plate(), pixels=ReadPixels(plate().color, np.full_like(DEPTH_M, np.inf)))
    coc = coc_plate_of(COLOR, np.ones_like(DEPTH_M))
    assert median_dioptres(empty) is median_dioptres(coc) is None
    assert remark_keys(plate(), empty, coc, plate()) == [[], [], [], []]


@pytest.fixture
def write_mixed_shot(tmp_path):
    """Return a writer of a shot file whose frames 1003 and 1005 are in centimetres."""
    pattern = write_plates(tmp_path / "plates", **CAMERA)
    color, depth_m = room(32, 18)
    for frame in (1003, 1005):
        channels = {n: np.ascontiguousarray(color[..., i]) for i, n in enumerate("RGB")}
        write_file(tmp_path / "plates" / f"plate.{frame}.exr", channels | {"Z": 100 * depth_m})

    def write(strict: bool):
        path = tmp_path / f"{strict}.heatlens.json"
        shot = shot_of(pattern)
        write_shot(path, replace(shot, plate_options=PlateOptions(strict=strict)))
        return path

    return write


def test_export_warns_once_of_frames_in_other_unit(write_mixed_shot, tmp_path, capsys):
    words = ["export", str(write_mixed_shot(False)), "-o", str(tmp_path / "o" / "n.####.exr")]
    assert main([*words, "--frames", "1002-1005", "--progress", "json"]) == 0
    end = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert end["event"] == "end" and end["written"] == 4
    assert end["told"].count("Frame 1003, and likewise 1005: The depths are about 100 times") == 1


def test_strict_export_refuses_frame_in_other_unit_also_when_resumed(
    write_mixed_shot, tmp_path, capsys
):
    out = tmp_path / "o" / "n.####.exr"
    words = ["export", str(write_mixed_shot(True)), "-o", str(out)]
    for frame_options in ([], [], ["--frames", "1003"]):
        assert main([*words, *frame_options]) == 2
        message = capsys.readouterr().err
        assert "plate.1003.exr: The depths are about 100 times as far" in message
        assert sorted(path.name for path in out.parent.iterdir()) == ["n.1001.exr", "n.1002.exr"]
    assert main([*words, "--frames", str(FRAMES[3])]) == 2  # the frame before it is another
