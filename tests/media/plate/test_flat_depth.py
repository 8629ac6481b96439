"""Test flat depth: wrong depth inside a matte becomes its median or a plane; the rest stays."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.read import read_plate
from support.exr_files import write_file
from support.mattes import HEIGHT, WIDTH, matte_plate

INSIDE = np.s_[8:16, 12:20]


def write_plate_with_ids(path, depth):
    ids = np.zeros((HEIGHT, WIDTH), "u4")
    ids[INSIDE] = 7
    color = dict.fromkeys("RGB", np.full((HEIGHT, WIDTH), 0.5, "f4"))
    return write_file(path, color | {"Z": depth.astype("f4"), "objectId": ids})


def read_flat_depth(path, flat):
    options = PlateOptions(flat_depth=flat, depth_convention=DepthConvention.DISTANCE)
    return read_plate(path, options).depth_m


def test_flat_depth_of_object_is_its_median(tmp_path, rng):
    depth = np.full((HEIGHT, WIDTH), 9.0)
    depth[INSIDE] = 3.0
    depth[8:10, 12:20] = rng.uniform(1, 80, (2, 8))  # wrong in a quarter of it
    path = write_plate_with_ids(tmp_path / "p.exr", depth)
    mended = read_flat_depth(path, "objectId:7")
    assert mended[INSIDE] == pytest.approx(3.0)
    depth[INSIDE] = 3.0
    assert mended == pytest.approx(depth)


def test_flat_depth_of_frame_without_the_object_is_unchanged(tmp_path):
    path = matte_plate(tmp_path / "p.1001.exr", None)
    matte_plate(tmp_path / "p.1002.exr", 3.0)
    assert read_flat_depth(path, "objectId:7") == pytest.approx(read_flat_depth(path, None))


def test_flat_depth_plane_follows_tilt_of_object(tmp_path, rng):
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    plane = 1.0 / (0.3 + 0.004 * x - 0.002 * y)
    depth = np.where(rng.random((HEIGHT, WIDTH)) < 0.2, 40.0, plane)
    mended = read_flat_depth(write_plate_with_ids(tmp_path / "p.exr", depth), "plane:objectId:7")
    assert mended[INSIDE] == pytest.approx(plane[INSIDE], rel=1e-4)
    outside = np.ones((HEIGHT, WIDTH), bool)
    outside[INSIDE] = False
    assert mended[outside] == pytest.approx(depth[outside].astype("f4"))


def test_flat_depth_accepts_cryptomatte_and_rejects_missing_channel(tmp_path):
    path = matte_plate(tmp_path / "p.exr", 3.0)
    assert read_flat_depth(path, "cryptomatte:hero")[INSIDE] == pytest.approx(3.0)
    with pytest.raises(InputError, match="nothing"):
        read_flat_depth(path, "matte:nothing")
