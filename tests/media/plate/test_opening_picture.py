"""Test opening images: every file format, notes, and rejected files."""

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


def save_image(path: Path, pixels: np.ndarray) -> Path:
    Image.fromarray(pixels).save(path)
    return path


def save_exr(path: Path, luminance: np.ndarray) -> Path:
    pixels = np.repeat(luminance.astype(np.float32)[:, :, None], 3, axis=2)
    with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": pixels}) as file:
        file.write(str(path))
    return path


def test_heart_image_of_program_equals_generated_one() -> None:
    with Image.open(heart_path()) as image:
        np.testing.assert_array_equal(np.asarray(image), heart())
    opening = read_opening_image(heart_path())
    assert opening.light is not None and opening.notes == ()
    assert Path(opening.path).is_absolute() and opening.light.shape == (IMAGE_SIDE, IMAGE_SIDE)
    assert opening.light.mean() == pytest.approx(heart().mean() / 255, abs=5e-3)
    assert HEART_SIDE < IMAGE_SIDE


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.exr"])
def test_read_opening_image_centers_wide_image_of_any_format(tmp_path: Path, name: str) -> None:
    """The image is bright at the top left; a wide image is centered in a square."""
    light = np.zeros((100, 200))
    light[:50, :100] = 1.0
    path = tmp_path / name
    read = (
        save_exr(path, light)
        if name == "a.exr"
        else save_image(path, (255 * light).astype(np.uint8))
    )
    light_read = read_opening_image(read).light
    assert light_read is not None
    expected = ((GRID > 0.25) & (GRID < 0.5))[:, None] & (GRID < 0.5)[None, :]
    assert np.abs(light_read - expected).mean() < 0.01


def test_read_opening_image_shrinks_by_area_mean(tmp_path: Path) -> None:
    """Lines of one pixel become half as bright, and none is lost."""
    lines = np.zeros((1024, 1024), np.uint8)
    lines[:, 512::2] = 255
    lines[:, :256] = 255
    light_read = read_opening_image(save_image(tmp_path / "lines.png", lines)).light
    assert light_read is not None
    np.testing.assert_allclose(light_read[:, 128:], 0.5, atol=1e-3)


def test_opening_image_digest_ignores_exposure_but_not_content(tmp_path: Path) -> None:
    light = np.random.default_rng(1).random((64, 64)) + 0.1
    path, brighter_path = (save_exr(tmp_path / f"{k}.exr", k * light) for k in (1, 8))
    first, second = read_opening_image(path), read_opening_image(brighter_path)
    assert first.digest == second.digest and first != second  # their paths differ
    assert read_opening_image(path) is first
    save_exr(path, light[::-1])
    assert read_opening_image(path).digest != first.digest


def test_read_opening_image_takes_transparent_as_dark(tmp_path: Path) -> None:
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[:, 32:, 3] = 0
    light_read = read_opening_image(save_image(tmp_path / "a.png", pixels)).light
    assert light_read is not None
    assert light_read[:, 140:].max() == 0.0 and light_read[:, :110].min() > 0.99


def test_read_opening_image_takes_luminance_of_colors_with_note(tmp_path: Path) -> None:
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:32, :, 1], pixels[32:, :, 2] = 255, 255
    opening = read_opening_image(save_image(tmp_path / "a.png", pixels))
    assert opening.light is not None
    assert opening.light[200, 128] / opening.light[60, 128] == pytest.approx(
        0.0722 / 0.7152, rel=1e-3
    )
    note, _ = opening.notes
    assert "a.png" in note and "coloured" in note and "luminance" in note


def test_read_opening_image_notes_light_off_axis(tmp_path: Path) -> None:
    light = np.zeros((64, 64), np.uint8)
    light[24:40, 40:56] = 255
    (note,) = read_opening_image(save_image(tmp_path / "a.png", light)).notes
    assert "50 % of the radius off the centre" in note


@pytest.mark.parametrize("bad", ["missing", "folder", "text", "black", "corners", "nan", "cut"])
def test_read_opening_image_rejects_bad_file_in_one_sentence(tmp_path: Path, bad: str) -> None:
    path = tmp_path / ("a.exr" if bad == "nan" else "a.png")
    light = np.zeros((64, 64))
    pattern_of_case = {
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
        save_exr(path, light)
    elif bad in ("black", "corners"):
        light[:3, :3] = bad == "corners"
        save_image(path, (255 * light).astype(np.uint8))
    elif bad == "cut":
        save_image(path, np.random.default_rng(0).integers(0, 255, (64, 64), np.uint8))
        path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(InputError, match=pattern_of_case.get(bad)) as error:
        read_opening_image(path)
    message = str(error.value)
    assert str(path) in message and "\n" not in message and message.endswith(".")
