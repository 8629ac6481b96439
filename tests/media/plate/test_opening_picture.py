"""Pictures as openings: every kind of file, what is said of it, and what is refused."""

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.opening_image import IMAGE_SIDE
from heatlens.media.plate.opening_picture import read_opening_image
from support.opening_images import HEART_SIDE, heart, heart_path

GRID = (np.arange(IMAGE_SIDE) + 0.5) / IMAGE_SIDE


def saved(path: Path, pixels: np.ndarray) -> Path:
    Image.fromarray(pixels).save(path)
    return path


def exr(path: Path, luminance: np.ndarray) -> Path:
    pixels = np.repeat(luminance.astype(np.float32)[:, :, None], 3, axis=2)
    with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": pixels}) as file:
        file.write(str(path))
    return path


def test_the_heart_that_comes_with_the_program_is_the_one_that_is_made_here() -> None:
    with Image.open(heart_path()) as image:
        np.testing.assert_array_equal(np.asarray(image), heart())
    read = read_opening_image(heart_path())
    assert read.light is not None and read.notes == ()
    assert Path(read.path).is_absolute() and read.light.shape == (IMAGE_SIDE, IMAGE_SIDE)
    assert read.light.mean() == pytest.approx(heart().mean() / 255, abs=5e-3)
    assert HEART_SIDE < IMAGE_SIDE


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.exr"])
def test_a_picture_of_every_kind_keeps_its_shape(tmp_path: Path, name: str) -> None:
    """Bright on top and on the left: a wide picture is put in the middle of a square."""
    light = np.zeros((100, 200))
    light[:50, :100] = 1.0
    path = tmp_path / name
    read = exr(path, light) if name == "a.exr" else saved(path, (255 * light).astype(np.uint8))
    found = read_opening_image(read).light
    assert found is not None
    expected = ((GRID > 0.25) & (GRID < 0.5))[:, None] & (GRID < 0.5)[None, :]
    assert np.abs(found - expected).mean() < 0.01


def test_a_large_picture_is_shrunk_by_the_mean_of_areas(tmp_path: Path) -> None:
    """Lines of one pixel are half as bright, and none of them is lost."""
    lines = np.zeros((1024, 1024), np.uint8)
    lines[:, 512::2] = 255
    lines[:, :256] = 255
    found = read_opening_image(saved(tmp_path / "lines.png", lines)).light
    assert found is not None
    np.testing.assert_allclose(found[:, 128:], 0.5, atol=1e-3)


def test_exposure_does_not_count_and_the_same_light_has_the_same_digest(tmp_path: Path) -> None:
    light = np.random.default_rng(1).random((64, 64)) + 0.1
    one, brighter = (exr(tmp_path / f"{k}.exr", k * light) for k in (1, 8))
    first, second = read_opening_image(one), read_opening_image(brighter)
    assert first.digest == second.digest and first != second  # their paths differ
    assert read_opening_image(one) is first
    exr(one, light[::-1])
    assert read_opening_image(one).digest != first.digest


def test_what_is_transparent_is_dark(tmp_path: Path) -> None:
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[:, 32:, 3] = 0
    found = read_opening_image(saved(tmp_path / "a.png", pixels)).light
    assert found is not None
    assert found[:, 140:].max() == 0.0 and found[:, :110].min() > 0.99


def test_of_colours_the_luminance_passes_and_that_is_said(tmp_path: Path) -> None:
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:32, :, 1], pixels[32:, :, 2] = 255, 255
    read = read_opening_image(saved(tmp_path / "a.png", pixels))
    assert read.light is not None
    assert read.light[200, 128] / read.light[60, 128] == pytest.approx(0.0722 / 0.7152, rel=1e-3)
    note, _ = read.notes
    assert "a.png" in note and "coloured" in note and "luminance" in note


def test_light_beside_the_axis_is_told(tmp_path: Path) -> None:
    light = np.zeros((64, 64), np.uint8)
    light[24:40, 40:56] = 255
    (note,) = read_opening_image(saved(tmp_path / "a.png", light)).notes
    assert "50 % of the radius off the centre" in note


@pytest.mark.parametrize("bad", ["missing", "folder", "text", "black", "corners", "nan", "cut"])
def test_what_is_no_opening_is_refused_in_one_sentence(tmp_path: Path, bad: str) -> None:
    path = tmp_path / ("a.exr" if bad == "nan" else "a.png")
    light = np.zeros((64, 64))
    told = {
        "missing": "not there",
        "folder": "folder",
        "black": "black",
        "corners": "black",
        "nan": "NaN",
    }
    if bad == "folder":
        path.mkdir()
    elif bad == "text":
        path.write_text("a heart")
    elif bad == "nan":
        light[10, 10] = np.nan
        exr(path, light)
    elif bad in ("black", "corners"):
        light[:3, :3] = bad == "corners"
        saved(path, (255 * light).astype(np.uint8))
    elif bad == "cut":
        saved(path, np.random.default_rng(0).integers(0, 255, (64, 64), np.uint8))
        path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(InputError, match=told.get(bad)) as error:
        read_opening_image(path)
    said = str(error.value)
    assert str(path) in said and "\n" not in said and said.endswith(".")
