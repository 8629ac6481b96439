"""Test the look of pictures written by `render` and `export`, which equals that of the window."""

import sys

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from heatlens.media.color.color_config import load_color_config
from heatlens.media.color.view_transform import srgb_transform, view_transform
from support.command_line import CAMERA, channels, picture, refused_render_message, render
from support.cube_config import cube_config
from support.exr_files import write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


def codes(path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(float)


def display_codes(
    transform, light: np.ndarray, exposure: float = 0.0, gamma: float = 1.0
) -> np.ndarray:
    return 255 * np.clip(transform.apply_cpu(light, exposure, gamma), 0, 1)


def light_of(capsys, plate, tmp_path) -> np.ndarray:
    render(capsys, plate, tmp_path / "light.exr", "--float")
    return picture(tmp_path / "light.exr")[1]


def test_render_png_uses_default_view_of_config(capsys, plate, tmp_path):
    message = render(capsys, plate, tmp_path / "o.png")
    config = load_color_config(None)
    assert f"seen through {config.default_view} on {config.default_display}" in message
    names = (config.default_display, config.default_view, config.default_input_space)
    expected = display_codes(view_transform(config, *names), light_of(capsys, plate, tmp_path))
    assert np.abs(codes(tmp_path / "o.png") - expected).max() <= 0.51


@pytest.mark.parametrize(
    "look", [(), ("--view", "Raw"), ("--view", "sRGB curve"), ("--exposure=-1", "--gamma=1.5")]
)
def test_render_and_export_apply_same_look(capsys, plate, tmp_path, look):
    assert main(["render", str(plate), "-o", str(tmp_path / "a.png"), *look]) == 0
    assert main(["export", str(plate), "-o", str(tmp_path / "b.png"), *look]) == 0
    look_lines = [line for line in capsys.readouterr().err.splitlines() if "seen through" in line]
    assert len(look_lines) == 2 and look_lines[0] == look_lines[1]
    assert np.abs(codes(tmp_path / "a.png") - codes(tmp_path / "b.png")).max() <= 1


def test_render_applies_own_config_exposure_and_gamma(capsys, plate, tmp_path):
    words = ("--ocio", cube_config(tmp_path).source, "--exposure", "1", "--gamma", "2")
    render(capsys, plate, tmp_path / "o.png", *words)
    config = load_color_config(words[1])
    names = (config.default_display, config.default_view, config.default_input_space)
    light = light_of(capsys, plate, tmp_path)
    expected = display_codes(view_transform(config, *names), light, 1.0, 2.0)
    assert np.abs(codes(tmp_path / "o.png") - expected).max() <= 0.51


def test_render_without_opencolorio_refuses_config_views(capsys, plate, tmp_path, monkeypatch):
    """OpenColorIO belongs to the base install; if it is broken, rendering fails with a message."""
    monkeypatch.setitem(sys.modules, "PyOpenColorIO", None)
    assert "pip install opencolorio" in refused_render_message(capsys, plate, tmp_path / "p.png")
    render(capsys, plate, tmp_path / "o.png", "--view", "sRGB curve")
    expected = display_codes(srgb_transform(), light_of(capsys, plate, tmp_path))
    assert np.abs(codes(tmp_path / "o.png") - expected).max() <= 0.51


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--view", "Nix"), "'Nix' is not known"),
        (("--ocio", "nowhere.ocio"), "nowhere.ocio"),
        (("--exposure", "40"), "within 30 stops, got 40"),
        (("--gamma", "0"), "gamma must be within"),
    ],
)
def test_render_rejects_impossible_look_options(capsys, plate, tmp_path, words, expected):
    assert expected in refused_render_message(capsys, plate, tmp_path / "o.png", *words)


@pytest.mark.parametrize("words", [("--view", "Raw"), ("--exposure", "1"), ("--gamma", "2")])
def test_render_exr_rejects_look_options(capsys, plate, tmp_path, words):
    message = refused_render_message(capsys, plate, tmp_path / "o.exr", *words)
    assert words[0] in message and "scene-linear" in message
