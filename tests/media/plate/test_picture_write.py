"""Test how an image is written to its file: visible region, overscan and folder."""

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.picture.picture_write import check_output, write_picture
from heatlens.media.plate.read import read_plate
from support.exr_files import distances, rgb, window, write_file

LENS = Lens(50.0, 2.0, 3.0, 36.0)
WHITE = np.ones((6, 8, 4), np.float32)


def read_plate_with_display(tmp_path, display_window, **header):
    """Read a plate of 8x6 pixels at (0, 0) with the display window `shown`."""
    channels = rgb(6, 8) | {"Z": distances()}
    windows = {"dataWindow": window(0, 0, 8, 6), "displayWindow": window(*display_window)}
    return read_plate(write_file(tmp_path / "p.exr", channels, **windows, **header))


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
@pytest.mark.parametrize("display_window", [(2, 1, 6, 5), (-2, -3, 10, 8), (4, 2, 12, 4)])
def test_write_picture_to_8_bit_file_shows_display_window(tmp_path, suffix, display_window):
    """Overscan is cut off, and regions that the renderer left out are black."""
    path = tmp_path / f"o{suffix}"
    write_picture(path, WHITE, read_plate_with_display(tmp_path, display_window), LENS, 1.0)
    x0, y0, x1, y1 = display_window
    y, x = np.mgrid[y0:y1, x0:x1]
    expected = 255.0 * ((x >= 0) & (x < 8) & (y >= 0) & (y < 6))
    with Image.open(path) as picture:
        pixels = np.asarray(picture).astype(float)
    assert pixels.shape == (y1 - y0, x1 - x0, 3)
    tolerance = 60 if suffix == ".jpg" else 0  # a JPEG rings at edges
    assert np.abs(pixels - expected[..., None]).max() <= tolerance


def test_write_picture_of_smaller_size_shows_same_region(tmp_path):
    plate = read_plate_with_display(tmp_path, (2, 2, 6, 6))
    write_picture(tmp_path / "o.png", WHITE[::2, ::2], plate, LENS, 0.5)
    with Image.open(tmp_path / "o.png") as picture:
        assert picture.size == (2, 2)


def test_write_picture_to_exr_keeps_overscan(tmp_path):
    write_picture(
        tmp_path / "o.exr", WHITE, read_plate_with_display(tmp_path, (2, 1, 6, 5)), LENS, 1.0
    )
    ((header, channels),) = read_parts(tmp_path / "o.exr")
    assert channels["R"].shape == (6, 8)
    assert np.array_equal(header["displayWindow"], window(2, 1, 6, 5))


@pytest.mark.parametrize("suffix", [".exr", ".png"])
def test_write_picture_makes_one_missing_folder_but_not_two(tmp_path, suffix):
    plate = read_plate_with_display(tmp_path, (0, 0, 8, 6))
    path = tmp_path / "new" / f"o{suffix}"
    check_output(path, plate.path)
    assert not path.parent.exists()  # it is made when there is a picture to write
    write_picture(path, WHITE, plate, LENS, 1.0)
    assert path.is_file()
    nested_path = tmp_path / "newer" / "still" / path.name
    with pytest.raises(InputError, match="one missing folder, not several"):
        check_output(nested_path, plate.path)
