"""Pictures on one grid: windows that agree, windows that overlap, and windows that do not."""

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


def picture(data: Box, display: Box = DISPLAY) -> Picture:
    """Return a picture whose pixels say where they are: red x, green y."""
    y, x = np.mgrid[data.y0 : data.y1, data.x0 : data.x1].astype(np.float32)
    return Picture(Path("a.exr"), np.stack([x, y, 0 * x], axis=-1), data, display)


def boxes(least: int, most: int) -> st.SearchStrategy[Box]:
    edges = st.lists(st.integers(least, most), min_size=2, max_size=2, unique=True).map(sorted)
    return st.tuples(edges, edges).map(lambda e: Box(e[0][0], e[1][0], e[0][1], e[1][1]))


def test_reading_keeps_windows_and_what_is_no_number(tmp_path, rng):
    data, display = Box(-3, 5, 7, 11), Box(0, 0, 20, 20)
    rgb = rng.normal(0, 1, (6, 10, 3)).astype(np.float32)
    rgb[2, 3, 0], rgb[4, 5, 1] = np.nan, np.inf
    path = tmp_path / "a.exr"
    channels = {name: rgb[..., i] for i, name in enumerate("RGB")}
    write_exr(path, channels, data, display, half=False)
    read = read_picture(path)
    np.testing.assert_array_equal(read.rgb, rgb)
    assert (read.path, read.data_window, read.display_window) == (path, data, display)


def test_half_floats_come_as_float32(tmp_path):
    grey = np.full((8, 8), 0.25, np.float32)
    write_exr(tmp_path / "a.exr", dict.fromkeys("RGB", grey), Box(0, 0, 8, 8), Box(0, 0, 8, 8))
    assert read_picture(tmp_path / "a.exr").rgb.dtype == np.float32


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.exr"):
        read_picture(tmp_path / "absent.exr")


def test_the_same_data_window_is_compared_whole_even_outside_the_display():
    overscan = Box(-4, -4, 36, 28)
    assert shared_region(picture(overscan), picture(overscan)) == overscan


@given(boxes(-8, 40), boxes(-8, 40))
def test_the_shared_region_shows_one_frame_in_both(first, second):
    result, truth = picture(first), picture(second)
    if first != second and first.intersection(second).intersection(DISPLAY).is_empty:
        with pytest.raises(InputError, match="no pixel in common"):
            shared_region(result, truth)
        return
    region = shared_region(result, truth)
    assert result.over(region).shape == (*region.shape, 3)
    np.testing.assert_array_equal(result.over(region), truth.over(region))
    np.testing.assert_array_equal(result.over(region)[0, 0, :2], [region.x0, region.y0])


def test_other_display_windows_are_refused_with_both_sizes():
    with pytest.raises(InputError, match=r"32 x 24 pixels at \(0, 0\).*16 x 12 pixels at \(0, 0\)"):
        shared_region(picture(DISPLAY), picture(DISPLAY, Box(0, 0, 16, 12)))
