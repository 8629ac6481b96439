"""Test that an image with depth in one half gives the same plate as two files."""

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention, DepthSide
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.parts.header_read import read_color_header
from heatlens.media.plate.read import read_plate
from heatlens.media.plate.windows import read_header_window
from support.exr_files import rgb, write_file
from support.movies import write_movie

SIDES = [side for side in DepthSide if side is not DepthSide.NONE]
NEAR_M, FAR_M = 1.0, 5.0
ENDS = {"near_m": NEAR_M, "far_m": FAR_M, "depth_convention": DepthConvention.NORMALIZED}
PATCH_CODE, MOST_CODE = 50000, 65535  # depth of a patch as a number of 16 bits


def join_halves(side, color, depth):
    first, second = (depth, color) if side in ("left", "top") else (color, depth)
    return np.concatenate([first, second], axis=1 if side in ("left", "right") else 0)


def save(path, pixels):
    Image.fromarray(pixels).save(path)
    return path


@pytest.fixture
def halves(rng):
    grey = rng.integers(0, 256, (6, 8, 1)).astype(np.uint8)
    return rng.integers(0, 256, (6, 8, 3)).astype(np.uint8), np.repeat(grey, 3, axis=2)


@pytest.mark.parametrize("side", SIDES)
def test_depth_side_gives_same_plate_as_two_files(tmp_path, halves, side):
    color, depth = halves
    both = save(tmp_path / "both.png", join_halves(side, color, depth))
    depth_file = save(tmp_path / "depth.png", depth[:, :, 0])
    color_file = save(tmp_path / "color.png", color)
    plate = read_plate(both, PlateOptions(depth_side=side, **ENDS))
    expected = read_plate(color_file, PlateOptions(depth_source=str(depth_file), **ENDS))
    np.testing.assert_array_equal(plate.color, expected.color)
    np.testing.assert_array_equal(plate.depth_m, expected.depth_m)
    assert plate.display_window == expected.display_window
    header = read_color_header(both, PlateOptions(depth_side=side))
    assert read_header_window(header, "displayWindow") == expected.display_window


@pytest.mark.parametrize(("size", "side"), [((5, 8), "right"), ((8, 5), "top"), ((1, 4), "left")])
def test_depth_side_rejects_image_that_cannot_be_halved(tmp_path, size, side):
    path = save(tmp_path / "a.png", np.zeros((size[1], size[0], 3), np.uint8))
    with pytest.raises(InputError, match=r"a\.png is .* cannot be halved"):
        read_plate(path, PlateOptions(depth_side=side, **ENDS))


def test_depth_side_rejects_colored_depth(tmp_path, halves):
    path = save(tmp_path / "a.png", join_halves("right", halves[0], halves[0]))
    with pytest.raises(InputError, match="is coloured, so it is not a depth"):
        read_plate(path, PlateOptions(depth_side="right", **ENDS))


def test_depth_side_rejects_exr(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": np.full((6, 8), 3.0, "f4")})
    with pytest.raises(InputError, match=r"a\.exr is an EXR.*leave --depth-side out"):
        read_plate(path, PlateOptions(depth_side="right"))


@pytest.mark.parametrize(
    "more", [{"depth_source": "z.png"}, {"depth_model": "n.onnx"}, {"depth_channel": "Z"}]
)
def test_depth_side_excludes_other_sources_of_depth(tmp_path, halves, more):
    path = save(tmp_path / "a.png", join_halves("right", *halves))
    with pytest.raises(InputError, match=r"a\.png: .* Give one: "):
        read_plate(path, PlateOptions(depth_side="right", **more))


def side_by_side(side, width, height, tint=None):
    """Return an image of colored patches beside its depth; `tint` colors a depth region."""
    rng = np.random.default_rng(3)
    patches = rng.integers(0, MOST_CODE, (height // 20 + 1, width // 20 + 1, 3)).astype(np.uint16)
    color = patches.repeat(20, 0).repeat(20, 1)[:height, :width]
    ramp = np.linspace(6000, 60000, width, dtype=np.uint16)
    depth = np.broadcast_to(ramp[None, :, None], (height, width, 3)).copy()
    depth[height // 4 : height // 2, : width // 2] = PATCH_CODE
    if tint is not None:
        depth[tint] = 60000, 30000, 5000
    return join_halves(side, color, depth)


@pytest.mark.parametrize("crf", ["12", "23"])
@pytest.mark.parametrize("width", [280, 320, 402])
@pytest.mark.parametrize("side", SIDES)
def test_depth_side_ignores_chroma_at_seam_of_h264_movie(tmp_path, side, width, crf):
    """Color that the codec smears across the seam does not make a depth colored, and so refused.

    The movie has 4:2:0 chroma; half its width is a multiple of the codec's blocks or not.
    """
    pictures = [side_by_side(side, width, 180)] * 3
    movie = write_movie(tmp_path / "a.mp4", pictures, "H.264", options={"crf": crf})
    plate = read_plate(movie / "frame.0002.mp4", PlateOptions(depth_side=side, **ENDS))
    patch_m = NEAR_M + (FAR_M - NEAR_M) * PATCH_CODE / MOST_CODE
    assert plate.depth_m[60, 60] == pytest.approx(patch_m, rel=0.02)


@pytest.mark.parametrize("crf", ["12", "23"])
@pytest.mark.parametrize("tint", [np.s_[:, :], np.s_[100:112, 200:212]])
def test_depth_side_rejects_color_in_small_region_of_movie(tmp_path, tint, crf):
    pictures = [side_by_side("right", 320, 180, tint)] * 3
    movie = write_movie(tmp_path / "a.mp4", pictures, "H.264", options={"crf": crf})
    with pytest.raises(InputError, match="is coloured, so it is not a depth"):
        read_plate(movie / "frame.0001.mp4", PlateOptions(depth_side="right", **ENDS))
