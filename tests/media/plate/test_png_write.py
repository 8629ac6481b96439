"""Test 8-bit image files: the sRGB curve, alpha, and targets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.picture.picture_write import write_png

# IEC 61966-2-1, to six digits: below the knee 12.92 x, above 1.055 x^(1/2.4) - 0.055.
CURVE = [(0.0, 0.0), (0.001, 0.01292), (0.0031308, 0.040450), (0.01, 0.099853), (0.18, 0.461356)]
CURVE += [(0.5, 0.735357), (1.0, 1.0), (7.0, 1.0), (-0.2, 0.0), (np.inf, 1.0), (np.nan, 0.0)]


@pytest.mark.parametrize(("linear", "encoded"), CURVE)
def test_encode_srgb_matches_values_of_the_standard(linear, encoded):
    assert float(encode_srgb(linear)) == pytest.approx(encoded, abs=2e-6)


@given(st.lists(st.floats(-10, 2.0**99, width=32), min_size=2, max_size=20))
def test_encode_srgb_is_monotonic_and_within_0_to_1(values):
    encoded = encode_srgb(sorted(values))
    assert encoded.dtype == np.float32 and encoded.min() >= 0 and encoded.max() <= 1
    assert (np.diff(encoded) >= 0).all()


def test_write_png_of_opaque_color(tmp_path):
    color = np.ones((2, 3, 4), np.float32)
    color[0, 0, :3] = 0.5, 0.0, 4.0
    write_png(tmp_path / "a.png", color)
    image = Image.open(tmp_path / "a.png")
    assert image.mode == "RGB" and image.size == (3, 2)
    assert image.getpixel((0, 0)) == (188, 0, 255)


def test_write_png_un_premultiplies_alpha(tmp_path):
    color = np.zeros((1, 2, 4), np.float32)
    color[0, 0] = 0.25, 0.25, 0.25, 0.5
    write_png(tmp_path / "a.png", color)
    image = Image.open(tmp_path / "a.png")
    assert image.getpixel((0, 0)) == (188, 188, 188, 128)
    assert image.getpixel((1, 0)) == (0, 0, 0, 0)


def test_write_png_writes_jpeg_by_suffix(tmp_path):
    write_png(tmp_path / "a.jpg", np.full((8, 8, 4), 0.5, np.float32))
    image = Image.open(tmp_path / "a.jpg")
    assert image.format == "JPEG" and image.getpixel((4, 4)) == (188, 188, 188)


def test_write_png_rejects_unknown_suffix_and_missing_folder(tmp_path):
    color = np.zeros((1, 1, 3), np.float32)
    with pytest.raises(InputError, match=r"\.png, \.jpg"):
        write_png(tmp_path / "a.gif", color)
    with pytest.raises(InputError, match="does not exist"):
        write_png(tmp_path / "no" / "a.png", color)
    assert not list(tmp_path.iterdir())
