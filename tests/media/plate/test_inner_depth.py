"""Test depth stored inside a photo by phones, in JPEG and HEIC files."""

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.main import main
from heatlens.media.plate.picture.picture_open import picture_info
from heatlens.media.plate.picture.portrait import read_inner_depth
from heatlens.media.plate.read import read_plate
from support.crashing import write_crashing_library
from support.picture_files import (
    HEIGHT,
    WIDTH,
    disparity,
    heic_with_depth,
    jpeg_with_dynamic_depth,
    jpeg_with_gdepth,
    metres,
    whole,
)

NEAR_M, FAR_M = 1.0, 10.0


@pytest.mark.parametrize("form", ["RangeInverse", "RangeLinear"])
def test_read_plate_takes_gdepth_of_jpeg(tmp_path, form):
    z = metres()
    fraction = (z - 1) / 9 if form == "RangeLinear" else (1 / 1 - 1 / z) / (1 / 1 - 1 / 10)
    plate = read_plate(jpeg_with_gdepth(tmp_path / "p.jpg", 1.0, 10.0, fraction, form))
    scale = (
        np.abs(plate.depth_m - z) if form == "RangeLinear" else np.abs(1 / plate.depth_m - 1 / z)
    )
    assert scale.max() <= 9 / 255
    assert plate.depth.convention == "distance" and form in plate.depth.why


def test_read_plate_takes_dynamic_depth_of_jpeg(tmp_path):
    z = metres()
    fraction = (1 - 1 / z) / 0.9
    plate = read_plate(jpeg_with_dynamic_depth(tmp_path / "p.jpg", 1.0, 10.0, fraction))
    inside = (slice(None), slice(0, WIDTH // 2 - 8))  # away from the step, which JPEG rounds off
    np.testing.assert_allclose(1 / plate.depth_m[inside], 1 / z[inside], atol=0.02)


def test_read_plate_rotates_inner_depth_with_photo(tmp_path):
    fraction = (1 - 1 / metres()) / 0.9
    upright_plate = read_plate(jpeg_with_gdepth(tmp_path / "p.jpg", 1.0, 10.0, fraction))
    rotated_plate = read_plate(jpeg_with_gdepth(tmp_path / "t.jpg", 1.0, 10.0, fraction, turn=6))
    np.testing.assert_array_equal(rotated_plate.color, np.rot90(upright_plate.color, -1))
    np.testing.assert_array_equal(rotated_plate.depth_m, np.rot90(upright_plate.depth_m, -1))


def test_read_plate_rejects_inner_depth_with_impossible_ends(tmp_path):
    path = jpeg_with_gdepth(tmp_path / "p.jpg", 10.0, 1.0, np.zeros((HEIGHT, WIDTH)))
    with pytest.raises(InputError, match="which cannot be"):
        read_plate(path)


@pytest.mark.parametrize("digits", [5000, 13])
def test_info_of_photo_with_impossible_item_length_is_no_fault(tmp_path, digits, capsys):
    path = tmp_path / "p.jpg"
    xmp = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="r"><rdf:Description '
        'xmlns:GDepth="g" GDepth:Near="1" GDepth:Far="9" GDepth:Mime="image/png" '
        f'Item:Length="{"9" * digits}"/></rdf:RDF></x:xmpmeta>'
    )
    Image.new("RGB", (WIDTH, HEIGHT)).save(path, xmp=xmp.encode())
    assert main(["info", str(path)]) in (0, 2)
    assert "fault" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("metadata", "convention"),
    [
        ({"representation_type": 1, "d_min": 0.1, "d_max": 1.0}, "inverse"),  # as iPhones write
        ({"representation_type": 0, "z_near": 1.0, "z_far": 10.0}, "inverse"),
        ({"representation_type": 2, "d_min": 0.1, "d_max": 1.0}, "disparity"),
        ({}, "disparity"),
    ],
)
def test_read_inner_depth_of_heic_uses_its_metadata(metadata, convention):
    values = whole(disparity(metres(), 1, 10), "u1")
    depth_found = read_inner_depth("p.heic", {"depth_images": [(values, metadata)]})
    assert depth_found.convention == convention
    if convention == "inverse":
        np.testing.assert_allclose(depth_found.values, 1 / metres(), atol=0.9 / 255)
    else:
        np.testing.assert_array_equal(depth_found.values, values)
        assert depth_found.full_scale == 255


def test_read_plate_takes_depth_of_heic_file(tmp_path):
    pytest.importorskip("pillow_heif").register_heif_opener()
    depths = disparity(np.clip(metres(64, 64), 1, 8), 1, 8)
    plate = read_plate(heic_with_depth(tmp_path / "p.heic", 1, 8, depths, quality=100))
    assert "disparity from 0.125 to 1 dioptres" in plate.depth.why
    np.testing.assert_allclose(1 / plate.depth_m, 0.125 + depths * 0.875, atol=0.02)


def test_heic_library_crash_is_reported_in_one_sentence(tmp_path, monkeypatch):
    pytest.importorskip("pillow_heif").register_heif_opener()
    path = heic_with_depth(tmp_path / "p.heic", 1, 8, disparity(metres(64, 64), 1, 8))
    monkeypatch.setenv("PYTHONPATH", str(write_crashing_library(tmp_path, "pillow_heif")))
    for read in (read_plate, picture_info):
        with pytest.raises(InputError, match=r"p\.heic .* crashes the library that reads it"):
            read(path)


@pytest.mark.parametrize("letter", ["\u00e9", "=", "A"])
def test_read_plate_rejects_inner_depth_with_damaged_text(tmp_path, letter):
    path = jpeg_with_gdepth(tmp_path / "p.jpg", NEAR_M, FAR_M, disparity(metres(), NEAR_M, FAR_M))
    data = path.read_bytes()
    at = data.index(b'GDepth:Data="') + 20
    code = letter.encode()
    path.write_bytes(data[:at] + code * (2 // len(code)) + data[at + 2 :])
    with pytest.raises(InputError, match=r"p\.jpg: its depth map is damaged") as refusal:
        read_plate(path)
    assert len(str(refusal.value).splitlines()) == 1
