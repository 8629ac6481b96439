"""Test that every image reader applies the orientation of the file, at any bit depth."""

import numpy as np
import OpenImageIO
import pytest
from PIL import Image

from heatlens.media.plate.picture.picture_open import open_picture, picture_info
from support.picture_files import colors

ORIENTATIONS = range(1, 9)


@pytest.mark.parametrize("orientation", ORIENTATIONS)
@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_open_picture_applies_orientation_at_any_bit_depth(tmp_path, suffix, orientation):
    """Pillow reads 8 bits of color, OpenImageIO more."""
    kinds = {"uint8": 1, "uint16": 257} | ({"float": 1 / 255} if suffix == ".tif" else {})
    values_of_kind = {}
    for kind, factor in kinds.items():
        path, values = tmp_path / f"{kind}{suffix}", colors().astype(np.float64) * factor
        spec = OpenImageIO.ImageSpec(values.shape[1], values.shape[0], 3, kind)
        spec.attribute("Orientation", orientation)
        out = OpenImageIO.ImageOutput.create(str(path))
        stored = values.astype(np.float32 if kind == "float" else kind)
        assert out.open(str(path), spec) and out.write_image(stored)
        out.close()
        picture = open_picture(path)
        assert picture_info(path)[0] == picture.values.shape[1::-1]
        values_of_kind[kind] = picture.values.astype(np.float64) / factor
    for values in values_of_kind.values():
        np.testing.assert_allclose(values, values_of_kind["uint8"], atol=1e-4)


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_picture_info_size_is_that_after_orientation(tmp_path, orientation):
    path = tmp_path / "photo.jpg"
    exif = Image.Exif()
    exif[0x0112] = orientation  # tag of the orientation
    Image.fromarray(colors()).save(path, exif=exif)
    assert picture_info(path)[0] == open_picture(path).values.shape[1::-1]
