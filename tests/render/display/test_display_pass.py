"""The display pass against the CPU path of the same transform, and the laws of the difference."""

import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import ShaderError
from heatlens.core.base.paths import data_dir
from heatlens.media.color.color_config import ColorConfig, load_color_config
from heatlens.media.color.view_transform import (
    LIGHT_MAX,
    ViewTransform,
    srgb_transform,
    view_transform,
)
from heatlens.render.display import display_pass
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.shader_source import assemble
from heatlens.render.gpu.textures import download, new_texture, upload
from support.cube_config import cube_config
from support.rounding import tolerance_for
from support.watched_calls import watch_calls

TOLERANCE = 1e-3
# PQ is endlessly steep at 0, where two CPU paths of the library itself lie 1.2e-3 apart.
BLACK = 1 / 255
LEVELS = np.exp2(np.linspace(-10, 6, 15)).astype(np.float32)
BRANCHES = np.array([-4, -0.25, -(2.0**-8), 0, 0.18, 1], np.float32)


def ramp() -> np.ndarray:
    """Return every mixture of 21 levels, shadows to lamps and some below black: (147, 63, 3)."""
    levels = np.concatenate([BRANCHES, LEVELS])
    return np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(147, 63, 3)


RAMP = ramp()


@pytest.fixture(scope="module")
def config() -> ColorConfig:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("OCIO", raising=False)
        return load_color_config(None)


@pytest.fixture(scope="module")
def film(config: ColorConfig) -> ViewTransform:
    return view_transform(
        config, config.default_display, config.default_view, config.default_input_space
    )


@pytest.fixture(scope="module")
def shared_screen(session_context: Device) -> Iterator[DisplayPass]:
    screen = DisplayPass(session_context)
    yield screen
    screen.release()


@pytest.fixture
def screen(ctx: Device, shared_screen: DisplayPass) -> DisplayPass:
    """Return one screen for all tests, as programs compile slowly; reset its curve."""
    shared_screen.set_transform(srgb_transform())
    return shared_screen


def texture_of(ctx: Device, rgb: np.ndarray) -> Texture:
    """Return a half transparent picture; its alpha must not matter."""
    texture = new_texture(ctx, (rgb.shape[1], rgb.shape[0]), 4)
    upload(texture, np.concatenate([rgb, np.full_like(rgb[..., :1], 0.5)], axis=2))
    return texture


def display_values(ctx: Device, screen: DisplayPass, rgb: np.ndarray, **view: float) -> np.ndarray:
    """Return display values (H, W, 3), not rounded."""
    out = new_texture(ctx, (rgb.shape[1], rgb.shape[0]), 4)
    screen.run(texture_of(ctx, rgb), out, **view)
    rgba = download(out)
    np.testing.assert_array_equal(rgba[..., 3], 1)
    return rgba[..., :3]


def difference(
    ctx: Device, screen: DisplayPass, first: np.ndarray, second: np.ndarray, **view: float
) -> np.ndarray:
    out = new_texture(ctx, (first.shape[1], first.shape[0]), 4)
    screen.run_difference(texture_of(ctx, first), texture_of(ctx, second), out, **view)
    return download(out)[..., :3]


def test_gpu_matches_cpu_for_every_view_of_built_in_config(ctx, screen, config):
    transform_keys = set()
    for display in config.displays():
        for view in config.views(display):
            transform = view_transform(config, display, view, config.default_input_space)
            screen.set_transform(transform)
            displayed, expected = display_values(ctx, screen, RAMP), transform.apply_cpu(RAMP)
            deviation = np.abs(displayed - expected)
            visible_deviation = deviation[np.maximum(displayed, expected) > BLACK]
            assert visible_deviation.max() < TOLERANCE, (display, view)
            assert deviation.mean() < 0.01 * TOLERANCE, (display, view)
            transform_keys.add(transform.key)
    assert len(transform_keys) > 15


@pytest.mark.parametrize("space", ["ACEScg", "Linear Rec.2020"])
def test_gpu_matches_cpu_for_other_input_spaces(ctx, screen, config, space):
    transform = view_transform(config, config.default_display, config.default_view, space)
    screen.set_transform(transform)
    np.testing.assert_allclose(
        display_values(ctx, screen, RAMP), transform.apply_cpu(RAMP), rtol=0, atol=TOLERANCE
    )


@pytest.mark.parametrize("view", ["linear", "tetrahedral", "curve"])
def test_gpu_matches_cpu_for_luts_from_files(ctx, screen, tmp_path, view):
    transform = view_transform(cube_config(tmp_path), "Screen", view, "plain")
    assert [lut.values.ndim for lut in transform.luts] == [3 if view == "curve" else 4]
    screen.set_transform(transform)
    atol = tolerance_for(ctx, TOLERANCE, 4e-3)
    np.testing.assert_allclose(
        display_values(ctx, screen, RAMP), transform.apply_cpu(RAMP), rtol=0, atol=atol
    )


def test_set_transform_replaces_lut_of_same_name(ctx, screen, tmp_path):
    folders = [tmp_path / name for name in ("first", "second")]
    for folder in folders:
        folder.mkdir()
    first = view_transform(cube_config(folders[0]), "Screen", "curve", "plain")
    cube_config(folders[1])
    (folders[1] / "curve.cube").write_text("LUT_1D_SIZE 2\n0 0 0\n0.5 0.5 0.5\n")
    studio = load_color_config(str(folders[1] / "studio.ocio"))
    second = view_transform(studio, "Screen", "curve", "plain")
    screen.set_transform(first)
    screen.set_transform(second)
    light = np.full((1, 1, 3), 0.5, np.float32)
    np.testing.assert_allclose(display_values(ctx, screen, light), 0.25, atol=1e-4)


def test_display_pass_applies_srgb_transform(ctx, screen):
    expected = srgb_transform().apply_cpu(RAMP)
    np.testing.assert_allclose(display_values(ctx, screen, RAMP), expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("exposure_stops", "gamma"), [(-2.0, 1.0), (1.5, 1.0), (0.0, 1.8), (1, 0.7)]
)
def test_gpu_matches_cpu_for_exposure_and_gamma(ctx, screen, film, exposure_stops, gamma):
    screen.set_transform(film)
    view = {"exposure_stops": exposure_stops, "gamma": gamma}
    light = RAMP[np.abs(RAMP).min(axis=2) > 0.01].reshape(1, -1, 3)  # 1/gamma is steep at black
    np.testing.assert_allclose(
        display_values(ctx, screen, light, **view),
        film.apply_cpu(light, **view),
        rtol=0,
        atol=TOLERANCE,
    )


def test_gamma_keeps_sign_of_negative_values(ctx, screen, config):
    raw = view_transform(config, "sRGB - Display", "Raw", config.default_input_space)
    screen.set_transform(raw)
    light = np.array([[[-0.25, 0.0, 4.0]]], np.float32)
    np.testing.assert_allclose(
        display_values(ctx, screen, light, gamma=2.0), [[[-0.5, 0, 2]]], rtol=0, atol=1e-4
    )


WILD = np.array([[[np.nan] * 3, [np.inf] * 3, [0, 0, 0], [6e4, 6e4, 6e4]]], np.float32)


def test_bounded_view_shows_nan_black_and_infinity_white(ctx, screen, film):
    for transform in (srgb_transform(), film):
        screen.set_transform(transform)
        pixels = display_values(ctx, screen, WILD, exposure_stops=3.0)
        np.testing.assert_array_equal(pixels[0, 0], pixels[0, 2])
        np.testing.assert_allclose(pixels[0, 1], pixels[0, 3], atol=1e-4)


def test_unbounded_view_shows_nan_as_zero_and_infinity_finite(ctx, screen, config):
    raw = view_transform(config, "sRGB - Display", "Raw", config.default_input_space)
    screen.set_transform(raw)
    pixels = display_values(ctx, screen, WILD, exposure_stops=1.0)
    np.testing.assert_allclose(pixels[0, :, 0], [0, 2 * LIGHT_MAX, 0, 1.2e5], rtol=1e-5)
    np.testing.assert_allclose(raw.apply_cpu(WILD, 1.0), pixels, rtol=1e-5)


def test_display_pass_rounds_to_nearest_8_bit_value(ctx, screen):
    light = np.geomspace(1e-4, 2, 30 * 41 * 3).astype(np.float32).reshape(30, 41, 3)
    out = ctx.texture((41, 30), 4)
    screen.run(texture_of(ctx, light), out)
    pixels = np.frombuffer(out.read(), np.uint8).reshape(30, 41, 4)
    exact = 255 * srgb_transform().apply_cpu(light)
    assert np.abs(pixels[..., :3] - exact).max() < 0.5 + tolerance_for(ctx, 0.01, 0.07)
    np.testing.assert_array_equal(pixels[..., 3], 255)


def test_set_transform_reuses_compiled_program(ctx, film, config, monkeypatch):
    builds = watch_calls(monkeypatch, display_pass, "ComputeProgram")
    screen = DisplayPass(ctx)
    screen.set_transform(film)
    first = display_values(ctx, screen, RAMP[:2])
    screen.set_transform(srgb_transform())
    screen.set_transform(film)
    assert len(builds) == 2
    np.testing.assert_array_equal(display_values(ctx, screen, RAMP[:2]), first)
    screen.release()


def test_set_transform_draws_again_after_many_other_views(ctx, screen, config):
    light = RAMP[:2]
    views = [(d, "Un-tone-mapped") for d in config.displays()]
    transforms = [view_transform(config, *v, config.default_input_space) for v in views]
    for transform in [*transforms, transforms[0]]:
        screen.set_transform(transform)
        np.testing.assert_allclose(
            display_values(ctx, screen, light), transform.apply_cpu(light), rtol=0, atol=TOLERANCE
        )


def test_set_transform_with_bad_glsl_raises_and_keeps_view(ctx, screen):
    before = display_values(ctx, screen, RAMP)
    broken = replace(srgb_transform(), key="broken", glsl="vec4 view_transform(vec4 a) {\nb;\n}")
    with pytest.raises(ShaderError, match="generated GLSL:2"):
        screen.set_transform(broken)
    np.testing.assert_array_equal(display_values(ctx, screen, RAMP), before)


def test_difference_of_equal_pictures_is_black(ctx, screen, film):
    black = np.zeros((1, 1, 3), np.float32)
    for transform in (srgb_transform(), film):
        screen.set_transform(transform)
        pixels = difference(ctx, screen, RAMP, RAMP, gain=1000.0)
        np.testing.assert_array_equal(
            pixels, np.broadcast_to(display_values(ctx, screen, black), RAMP.shape)
        )


def test_difference_shows_absolute_difference_times_gain(ctx, screen, rng):
    a, b = rng.uniform(0, 1, (2, 37, 21, 3)).astype(np.float32)
    view = {"exposure_stops": 0.5, "gamma": 1.2}
    expected = display_values(ctx, screen, 3 * np.abs(a - b), **view)
    pixels = difference(ctx, screen, a, b, gain=3.0, **view)
    np.testing.assert_allclose(pixels, expected, rtol=0, atol=tolerance_for(ctx, 1e-5, 1e-4))
    np.testing.assert_array_equal(pixels, difference(ctx, screen, b, a, gain=3.0, **view))


def test_difference_accepts_uniform_pictures_of_two_sizes(ctx, screen):
    a = np.full((40, 30, 3), 0.7, np.float32)
    for size in ((1, 1), (7, 13), (80, 61)):
        pixels = difference(ctx, screen, a, np.full((*size, 3), 0.2, np.float32), gain=2.0)
        expected = srgb_transform().apply_cpu(np.ones((1, 1, 3), np.float32))
        np.testing.assert_allclose(pixels, np.broadcast_to(expected, a.shape), atol=1e-4)


def slope(width: int, height: int) -> np.ndarray:
    """Return 0..1 rightwards in red and downwards in green, at the pixels' centres."""
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return np.stack([x, y, 0 * x], axis=-1).astype(np.float32)


@pytest.mark.parametrize("size", [(20, 15), (60, 45), (33, 90)])
def test_difference_aligns_pictures_of_two_sizes(ctx, screen, size):
    pixels = difference(ctx, screen, slope(40, 30), slope(*size))
    inside = pixels[3:-3, 3:-3]  # half a pixel of the coarser one from the edge it is flat
    np.testing.assert_allclose(inside, 0, atol=1e-4)


def test_reference_compiler_accepts_display_shaders(film, tmp_path):
    assert shutil.which("glslangValidator"), "apt-get install glslang-tools"
    transforms = [srgb_transform(), film, *cube_views(tmp_path)]
    files = []
    for number, transform in enumerate(transforms):
        for name in ("display/display.comp.glsl", "display/display_difference.comp.glsl"):
            source = assemble(data_dir("shaders"), name).append_functions(transform.glsl)
            files.append(tmp_path / f"{number}{Path(name).name.removesuffix('.comp.glsl')}.comp")
            files[-1].write_text(source.text)
    for file in files:  # -l links: the transform that a shader declares must be there
        run = subprocess.run(["glslangValidator", "-l", file], capture_output=True, text=True)
        assert run.returncode == 0, run.stdout


def cube_views(folder: Path) -> list[ViewTransform]:
    config = cube_config(folder)
    return [view_transform(config, "Screen", v, "plain") for v in config.views("Screen")]


def test_preview_table_is_close_to_its_view(ctx, screen, film):
    screen.set_transform(film)
    out, light = new_texture(ctx, (63, 147), 4), np.abs(RAMP)
    screen.run(texture_of(ctx, light), out, is_preview=True)
    deviation = np.abs(download(out)[..., :3] - film.apply_cpu(light))
    assert deviation.max() < 0.04
    assert deviation.mean() < 0.001
