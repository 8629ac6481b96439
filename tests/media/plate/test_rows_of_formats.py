"""Test that every image reader returns the top row first."""

import numpy as np
import OpenImageIO
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.picture.picture_open import open_picture
from heatlens.media.plate.read import read_plate

HEIGHT, WIDTH = 6, 8
# Ending, kinds of values, channels: all that the program can be given, by whichever library.
FORMATS = [
    *((".png", kind, count) for kind in ("uint8", "uint16") for count in (1, 2, 3, 4)),
    *((".tif", kind, count) for kind in ("uint8", "uint16", "float") for count in (1, 3, 4)),
    *((".jpg", "uint8", count) for count in (1, 3)),
    *((".webp", "uint8", count) for count in (3, 4)),
    *((".bmp", "uint8", count) for count in (1, 3)),
    *((".tga", "uint8", count) for count in (1, 3, 4)),
    *((".dpx", kind, count) for kind in ("uint8", "uint16", "float") for count in (1, 3, 4)),
]


def ramp_image(count: int) -> np.ndarray:
    """Return values of 0 to 1 that grow from top to bottom, and slightly from left to right."""
    rows = np.linspace(0.1, 0.9, HEIGHT)[:, None, None] + np.linspace(0, 0.05, WIDTH)[None, :, None]
    values = np.repeat(rows, count, axis=2).astype(np.float32)
    if count in (2, 4):
        values[..., -1] = 1.0
    return values


def row_means(path) -> np.ndarray:
    values = open_picture(path).values.astype(np.float64)
    return values[..., 0].mean(axis=1)


@pytest.mark.parametrize(("suffix", "kind", "count"), FORMATS)
def test_open_picture_returns_top_row_first_in_every_format(tmp_path, suffix, kind, count):
    path = tmp_path / f"p{suffix}"
    out = OpenImageIO.ImageOutput.create(str(path))
    assert out.open(str(path), OpenImageIO.ImageSpec(WIDTH, HEIGHT, count, kind)), out.geterror()
    assert out.write_image(ramp_image(count)), out.geterror()
    out.close()
    rows = row_means(path)
    assert (np.diff(rows) > 0).all(), rows


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("order", ["<", ">"])
def test_open_picture_of_pfm_is_upright(tmp_path, count, order):
    """The file is written byte by byte from the bottom up, as the format requires."""
    path, values = tmp_path / "p.pfm", ramp_image(count)
    head = f"{'PF' if count == 3 else 'Pf'}\n{WIDTH} {HEIGHT}\n{-1.0 if order == '<' else 1.0}\n"
    path.write_bytes(head.encode() + values[::-1].astype(f"{order}f4").tobytes())
    np.testing.assert_array_equal(open_picture(path).values, values)
    color = tmp_path / "c.png"
    Image.new("RGB", (WIDTH, HEIGHT)).save(color)
    plate = read_plate(color, PlateOptions(depth_source=str(path), depth_convention="distance"))
    assert plate.depth_m is not None
    np.testing.assert_array_equal(plate.depth_m, values[..., 0])


@pytest.mark.parametrize(
    ("data", "message_part"),
    [
        (b"", "not a PFM"),
        (b"P6\n2 2\n255\n" + bytes(12), "not a PFM"),
        (b"PF\n2 2\n-1\n" + bytes(47), "cut short: 47 of 48"),
        (b"PF\n0 2\n-1\n", "0 x 2"),
        (b"PF\n999999 9\n-1\n" + bytes(9), "cut short"),
        (b"PF\n" + b"9" * 5000, "not a PFM"),
    ],
)
def test_open_picture_rejects_damaged_pfm(tmp_path, data, message_part):
    path = tmp_path / "p.pfm"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message_part):
        open_picture(path)
