"""Test sources of the Python interface: single frames, and their size, frames, lens and depth."""

from itertools import pairwise

import numpy as np
import pytest

import heatlens
from heatlens.core.base.errors import HeatlensError
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels
from support.exports import FRAMES, write_plates
from support.exr_files import write_file

LENS = {"f_stop": 1.4, "focus_distance_m": 3.0, "quality": "draft"}
DEPTHS = {1001: (1.0, 9.0), 1002: (2.0, 5.0), 1004: (0.5, 80.0)}


@pytest.fixture
def pattern(tmp_path):
    """Write frames of different depths without 1003. Return their pattern."""
    for frame, (near, far) in DEPTHS.items():
        depth = np.full((10, 16), far, np.float32)
        depth[:, 4:8] = near
        write_file(tmp_path / f"p.{frame}.exr", channels() | {"Z": depth}, **CAMERA)
    return tmp_path / "p.####.exr"


def test_open_of_single_frame_file_renders_that_frame(tmp_path):
    write_plates(tmp_path)
    whole = heatlens.open(tmp_path / "plate.####.exr")
    pictures = []
    for frame in FRAMES:
        single = heatlens.open(tmp_path / f"plate.{frame}.exr")
        assert single.frames == (frame,)
        pictures.append(single.render(**LENS))
        np.testing.assert_array_equal(pictures[-1], whole.render(frame=frame, **LENS))
    assert all(not np.array_equal(a, b) for a, b in pairwise(pictures))


@pytest.mark.parametrize("kept_bytes", [0, 400])
def test_damaged_frame_file_raises_heatlens_error(pattern, kept_bytes):
    path = pattern.with_name("p.1002.exr")
    path.write_bytes(path.read_bytes()[:kept_bytes])
    with pytest.raises(HeatlensError, match=r"p\.1002\.exr"):
        heatlens.open(path).render(**LENS)


def test_sequence_lists_frames_sizes_and_depth_ranges(pattern):
    source = heatlens.open(pattern)
    assert source.frames == tuple(DEPTHS) and len(source) == 3
    assert [frame.number for frame in source] == list(DEPTHS)
    for frame in source:
        assert frame.depth_range_m == pytest.approx(DEPTHS[frame.number], rel=1e-3)
    assert source.depth_range_m == pytest.approx(DEPTHS[1001], rel=1e-3)
    assert source.size == source[1004].size == (16, 10)
    assert source.cameras == () and source.behind == ()
    picture = source[1004].render(**LENS)
    np.testing.assert_array_equal(picture, source.render(frame=1004, **LENS))
    with pytest.raises(HeatlensError, match="no frame 1003: there are 1001-1002,1004"):
        source[1003]
    with pytest.raises(HeatlensError, match=r"or open p\.####\.exr"):
        heatlens.open(pattern.with_name("p.1002.exr")).render(frame=1001)


def test_source_lens_comes_from_header_and_is_used_by_render(pattern):
    source = heatlens.open(pattern)
    assert source.lens["focal_length_mm"] == pytest.approx(50.0)
    lens_values = {**source.lens, **LENS}
    np.testing.assert_array_equal(source.render(**lens_values), source.render(**LENS))


def test_shot_source_gives_lens_of_each_frame(shot_file):
    source = heatlens.open(shot_file)
    assert source.frames == FRAMES
    focus = [frame.lens["focus_distance_m"] for frame in source]
    assert focus == sorted(focus) and focus[0] == pytest.approx(0.9) and focus[-1] == 3.0
    np.testing.assert_array_equal(source[1003].render(), source.render(frame=1003))


def test_arrays_and_single_pictures_have_one_frame(tmp_path):
    path = write_file(tmp_path / "still.exr", channels(), **CAMERA)
    color, depth = np.ones((10, 16, 3), np.float32), np.full((10, 16), 2.0, np.float32)
    for source in (heatlens.open(path), heatlens.open(color, depth)):
        assert source.frames == (1,) and source.size == (16, 10)
        assert [frame.number for frame in source] == [1]
        with pytest.raises(HeatlensError, match="leave frame out"):
            source[2]
    assert heatlens.open(color, depth).depth_range_m == (2.0, 2.0)


def test_source_behind_describes_background_plate(tmp_path, capsys):
    near = {"Z": np.full((10, 16), 1.0, np.float32)}
    path = write_file(tmp_path / "front.exr", channels() | near, **CAMERA)
    far = {"Z": np.full((10, 16), 4.0, np.float32)}
    behind = write_file(tmp_path / "back.exr", channels() | far, **CAMERA)
    source = heatlens.open(path, behind=[str(behind)])
    (sentence,) = source.behind
    assert "back.exr lies behind 100" in sentence
    assert main(["info", str(path), "--behind", str(behind)]) == 0
    assert "lies behind 100" in capsys.readouterr().out


def test_scene_source_has_size_frames_and_depth_range(small_demo):
    source = heatlens.open("demo", size=(40, 24))
    assert source.size == (40, 24) and source.frames == (1,)
    near, far = source.depth_range_m
    assert 0 < near < source.lens["focus_distance_m"] < far


def test_scene_source_lists_cameras_and_frames():
    source = heatlens.open("demo", size=(40, 24))
    assert source.frames == tuple(range(1, 241)) and len(source.cameras) == 1
    assert source[240].lens["focus_distance_m"] != source[1].lens["focus_distance_m"]
    with pytest.raises(HeatlensError, match="1 to 240, got 241"):
        source[241]
