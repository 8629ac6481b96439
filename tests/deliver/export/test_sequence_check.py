"""Frames that do not go with those before them are told once, or refused before being written."""

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


def keys(*plates) -> list[list[str]]:
    check = SequenceCheck(1.0)
    return [[remark.key for remark in check.remarks(each)] for each in plates]


@given(st.floats(1.1, 19.0), st.booleans())
def test_depths_may_move_but_not_change_their_unit(factor, is_nearer):
    moved = 1 / factor if is_nearer else factor
    word = "near" if is_nearer else "far"
    jumped = plate(1 / 39.37 if is_nearer else 100.0)
    assert keys(plate(), plate(moved)) == [[], []]
    found = keys(plate(), jumped, plate(), jumped)
    assert [f"depths {word}" in each for each in found] == [False, True, False, True]


def test_what_moves_slowly_through_any_range_is_no_jump():
    assert not any(keys(*(plate(1.5**step / 30) for step in range(16))))


def test_another_display_window_is_told_and_another_data_window_is_not():
    wide = replace(plate(), display_window=Box(0, 0, 64, 18))
    cut = replace(plate(), data_window=Box(0, 0, 16, 18))
    found = keys(plate(), cut, wide, wide, plate())
    assert [len(each) for each in found] == [0, 0, 1, 1, 0] and "64x18" in found[2][0]


def test_notes_are_new_where_no_such_note_was_in_the_first_plate():
    of_first = plate(notes=("made.exr: 3 of 576 pixels held NaN.",))
    like_it = plate(notes=("made.exr: 21 of 576 pixels held NaN.",))
    other = plate(notes=("made.exr: depth channel 'Z' is negative.",))
    found = keys(of_first, like_it, other, like_it, other)
    assert found == [[], [], ["depth channel 'Z' is negative."], [], found[2]]


def test_pictures_without_surfaces_or_distances_have_no_depth_to_compare():
    empty = replace(plate(), pixels=ReadPixels(plate().color, np.full_like(DEPTH_M, np.inf)))
    coc = coc_plate_of(COLOR, np.ones_like(DEPTH_M))
    assert median_dioptres(empty) is median_dioptres(coc) is None
    assert keys(plate(), empty, coc, plate()) == [[], [], [], []]


@pytest.fixture
def mixed(tmp_path):
    """A shot whose frames 1003 and 1005 are in centimetres."""
    pattern = write_plates(tmp_path / "plates", **CAMERA)
    color, depth_m = room(32, 18)
    for frame in (1003, 1005):
        named = {n: np.ascontiguousarray(color[..., i]) for i, n in enumerate("RGB")}
        write_file(tmp_path / "plates" / f"plate.{frame}.exr", named | {"Z": 100 * depth_m})

    def write(strict: bool):
        path = tmp_path / f"{strict}.heatlens.json"
        shot = shot_of(pattern)
        write_shot(path, replace(shot, plate_options=PlateOptions(strict=strict)))
        return path

    return write


def test_frames_in_another_unit_are_told_once_at_the_end(mixed, tmp_path, capsys):
    words = ["export", str(mixed(False)), "-o", str(tmp_path / "o" / "n.####.exr")]
    assert main([*words, "--frames", "1002-1005", "--progress", "json"]) == 0
    end = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert end["event"] == "end" and end["written"] == 4
    assert end["told"].count("Frame 1003, and likewise 1005: The depths are about 100 times") == 1


def test_strict_refuses_such_a_frame_also_where_an_export_goes_on(mixed, tmp_path, capsys):
    out = tmp_path / "o" / "n.####.exr"
    words = ["export", str(mixed(True)), "-o", str(out)]
    for part in ([], [], ["--frames", "1003"]):
        assert main([*words, *part]) == 2
        said = capsys.readouterr().err
        assert "plate.1003.exr: The depths are about 100 times as far" in said
        assert sorted(path.name for path in out.parent.iterdir()) == ["n.1001.exr", "n.1002.exr"]
    assert main([*words, "--frames", str(FRAMES[3])]) == 2  # the frame before it is another
