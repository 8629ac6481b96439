"""Test plates with a matte that is not blurred: both parts together are the plate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.mattes.cutout import cut_out
from heatlens.media.plate.plate import ReadPixels
from heatlens.media.plate.read import read_plate
from support.mattes import matte_plate

INSIDE = np.s_[8:16, 12:20]
SHAPE = st.tuples(st.integers(1, 9), st.integers(1, 9))
PARTS = st.floats(0, 1, width=32)


def read(path, **options):
    return read_plate(path, PlateOptions(depth_convention=DepthConvention.DISTANCE, **options))


def test_cutout_of_never_blur_extends_background_behind_object(tmp_path):
    plate = read(matte_plate(tmp_path / "p.exr", 3.0), never_blur="cryptomatte:hero")
    cutout = plate.cutout
    assert (cutout.share[INSIDE] == 1).all() and cutout.share.sum() == 64
    assert (cutout.depth[INSIDE] == 3).all() and cutout.surroundings.depth_m.min() == 6
    assert plate.depth_m[INSIDE].max() == 3  # the plate itself stays whole


def test_cutout_of_only_blur_keeps_everything_else(tmp_path):
    plate = read(matte_plate(tmp_path / "p.exr", 3.0), only_blur="objectId:7")
    assert plate.cutout.surroundings.color[INSIDE][..., 3].min() == 1
    assert plate.cutout.surroundings.color[..., 3].sum() == 64
    np.testing.assert_array_equal(plate.cutout.backdrop[:8], plate.color[:8])


def test_cutout_of_frame_without_the_object_is_none_or_all_sharp(tmp_path):
    path = matte_plate(tmp_path / "p.1001.exr", None)
    matte_plate(tmp_path / "p.1002.exr", 3.0)
    assert read(path, never_blur="objectId:7").cutout is None
    only = read(path, only_blur="objectId:7").cutout
    np.testing.assert_array_equal(only.backdrop, read(path).color)
    with pytest.raises(InputError, match="nothing"):
        read(path, never_blur="matte:nothing")


@given(st.data(), SHAPE, st.booleans(), st.booleans())
def test_cut_out_parts_together_are_the_image(data, shape, is_coc, is_only):
    """This holds for any image, depth and matte; pixels mixed with a nearer object extend behind
    it.
    """
    color = data.draw(arrays.arrays(np.float32, (*shape, 4), elements=PARTS))
    color[..., 3] = 1
    depth = data.draw(arrays.arrays(np.float32, shape, elements=st.floats(0.5, 8, width=32)))
    share = data.draw(arrays.arrays(np.float32, shape, elements=PARTS))
    pixels = ReadPixels(color, coc_px=depth) if is_coc else ReadPixels(color, depth)
    cutout = cut_out(pixels, share, is_only)
    clean_color, alpha = cutout.surroundings.color, cutout.share[..., None]
    for part in (clean_color, cutout.light, cutout.depth):
        assert np.isfinite(part).all() and part.min() >= (-8 if is_coc else 0)
    together = cutout.light + (1 - alpha) * clean_color
    is_exact = cutout.share == share
    if is_only:
        together = cutout.light + (1 - alpha) * (
            clean_color + (1 - clean_color[..., 3:]) * cutout.backdrop
        )
        is_exact &= (share == 0) | (share == 1)
    np.testing.assert_allclose(together[is_exact], color[is_exact], atol=2e-5)
