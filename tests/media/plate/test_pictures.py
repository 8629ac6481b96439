"""Test images on a common grid: windows that agree, overlap or do not fit."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.lab.measure.compared_pictures import Picture, read_picture, shared_region
from heatlens.media.plate.exr.exr_write import write_exr

DISPLAY = Box(0, 0, 32, 24)


def ramp_picture(data: Box, display: Box = DISPLAY) -> Picture:
    """Return an image whose pixels hold their position: red x, green y."""
    y, x = np.mgrid[data.y0 : data.y1, data.x0 : data.x1].astype(np.float32)
    return Picture(Path("a.exr"), np.stack([x, y, 0 * x], axis=-1), data, display)


def boxes(least: int, most: int) -> st.SearchStrategy[Box]:
    edges = st.lists(st.integers(least, most), min_size=2, max_size=2, unique=True).map(sorted)
    return st.tuples(edges, edges).map(lambda e: Box(e[0][0], e[1][0], e[0][1], e[1][1]))


def test_read_picture_keeps_windows_and_nan(tmp_path, rng):
    data, display = Box(-3, 5, 7, 11), Box(0, 0, 20, 20)
    rgb = rng.normal(0, 1, (6, 10, 3)).astype(np.float32)
    rgb[2, 3, 0], rgb[4, 5, 1] = np.nan, np.inf
    path = tmp_path / "a.exr"
    channels = {name: rgb[..., i] for i, name in enumerate("RGB")}
    write_exr(path, channels, data, display, half=False)
    picture_read = read_picture(path)
    np.testing.assert_array_equal(picture_read.rgb, rgb)
    assert (picture_read.path, picture_read.data_window, picture_read.display_window) == (
        path,
        data,
        display,
    )


def test_read_picture_converts_half_to_float32(tmp_path):
    grey = np.full((8, 8), 0.25, np.float32)
    write_exr(tmp_path / "a.exr", dict.fromkeys("RGB", grey), Box(0, 0, 8, 8), Box(0, 0, 8, 8))
    assert read_picture(tmp_path / "a.exr").rgb.dtype == np.float32


def test_read_picture_names_missing_file(tmp_path):
    with pytest.raises(InputError, match=r"absent\.exr"):
        read_picture(tmp_path / "absent.exr")


def test_shared_region_of_equal_data_windows_includes_overscan():
    overscan = Box(-4, -4, 36, 28)
    assert shared_region(ramp_picture(overscan), ramp_picture(overscan)) == overscan


@given(boxes(-8, 40), boxes(-8, 40))
def test_shared_region_shows_same_pixels_in_both(first, second):
    result, truth = ramp_picture(first), ramp_picture(second)
    if first != second and first.intersection(second).intersection(DISPLAY).is_empty:
        with pytest.raises(InputError, match="no pixel in common"):
            shared_region(result, truth)
        return
    region = shared_region(result, truth)
    assert result.crop(region).shape == (*region.shape, 3)
    np.testing.assert_array_equal(result.crop(region), truth.crop(region))
    np.testing.assert_array_equal(result.crop(region)[0, 0, :2], [region.x0, region.y0])


def test_shared_region_rejects_different_display_windows_with_sizes():
    with pytest.raises(InputError, match=r"32 x 24 pixels at \(0, 0\).*16 x 12 pixels at \(0, 0\)"):
        shared_region(ramp_picture(DISPLAY), ramp_picture(DISPLAY, Box(0, 0, 16, 12)))
