"""Plates with premultiplied alpha: alpha is blurred like color, in all bokehs and qualities."""

import numpy as np
import pytest
from PIL import Image as PillowImage

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_read import read_parts
from support.alpha_plates import coverage, covered_room, render_alpha_plate
from support.command_line import CAMERA, HEIGHT, WIDTH, channels
from support.exr_files import write_file
from support.plates import FAR_M, FOCUS_M, NEAR_M, lens_blurring, plate_of, room

KINDS = [(bokeh, quality) for bokeh in Bokeh for quality in Quality]


@pytest.mark.parametrize("layers", [None, 2])
@pytest.mark.parametrize("coc_px", [1.5, 12.0, 60.0])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_blurred_alpha_stays_within_zero_and_one(ctx, renderer, bokeh, quality, coc_px, layers):
    alpha = render_alpha_plate(renderer, *covered_room(), coc_px, bokeh, quality, layers)[..., 3]
    assert alpha.min() >= 0.0 and alpha.max() <= 1.0
    assert alpha.min() < 0.1 and alpha.max() > 0.9


@pytest.mark.parametrize("layers", [None, 1])
@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_opaque_alpha_changes_no_color(ctx, renderer, bokeh, quality, layers):
    color, depth = room()
    opaque = np.concatenate([color, np.ones((*depth.shape, 1), np.float32)], axis=2)
    picture = render_alpha_plate(renderer, opaque, depth, 12.0, bokeh, quality, layers)
    renderer.load(plate_of(color, depth))
    shot = Shot(lens_blurring(12.0, depth.shape[1]), DefocusSettings(bokeh, quality, layers))
    assert np.array_equal(picture[..., :3], renderer.pixels(shot)[..., :3])
    # What leaves a layer covers it again, but for the ripple of a sum of exponentials.
    np.testing.assert_allclose(picture[..., 3], 1.0, atol=0.02)


@pytest.mark.parametrize("bokeh", [Bokeh.HEAT, Bokeh.GAUSSIAN])
def test_alpha_of_white_plate_is_blurred_like_its_light(ctx, renderer, bokeh):
    """Check a premultiplied white plate, whose color equals its alpha before and after the blur."""
    _, depth = room()
    alpha = coverage(*depth.shape)[..., None]
    picture = render_alpha_plate(renderer, np.repeat(alpha, 4, axis=2), depth, 12.0, bokeh)
    np.testing.assert_allclose(picture[..., 0], picture[..., 3], atol=2e-3)


@pytest.mark.parametrize("depth_m", [NEAR_M, FAR_M], ids=["near", "far"])
@pytest.mark.parametrize("bokeh", Bokeh)
def test_blur_keeps_mean_alpha_of_wall(ctx, renderer, bokeh, depth_m):
    alpha = coverage(60, 80)[..., None]
    depth = np.full((60, 80), depth_m, np.float32)
    picture = render_alpha_plate(renderer, np.repeat(alpha, 4, axis=2), depth, 8.0, bokeh)
    # Clipped to 0..1, a disc's ripple along an edge no longer cancels out.
    assert picture[..., 3].mean() == pytest.approx(alpha.mean(), rel=0.01)


@pytest.mark.parametrize(("bokeh", "quality"), KINDS)
def test_plate_with_alpha_in_focus_is_unchanged(ctx, renderer, rng, bokeh, quality):
    alpha = rng.random((33, 47, 1), np.float32)
    rgba = np.concatenate([rng.random((33, 47, 3), np.float32) * alpha, alpha], axis=2)
    depth = np.full((33, 47), FOCUS_M, np.float32)
    assert np.array_equal(render_alpha_plate(renderer, rgba, depth, 20.0, bokeh, quality), rgba)


@pytest.mark.parametrize("proxy", [0.25, 0.5])
def test_proxy_keeps_mean_alpha(ctx, renderer, proxy):
    rgba, depth = covered_room()
    picture = render_alpha_plate(renderer, rgba, depth, 8.0, Bokeh.DISC, Quality.FILM, None, proxy)
    assert picture[..., 3].mean() == pytest.approx(rgba[..., 3].mean(), rel=0.05)


@pytest.fixture
def plate(tmp_path):
    alpha = coverage(HEIGHT, WIDTH).astype(np.float16)
    return write_file(tmp_path / "plate.exr", channels() | {"A": alpha}, **CAMERA)


def test_render_command_writes_alpha_of_plate(plate, tmp_path):
    assert main(["render", str(plate), "-o", str(tmp_path / "out.exr")]) == 0
    assert main(["render", str(plate), "-o", str(tmp_path / "out.png")]) == 0
    _, written_channels = read_parts(tmp_path / "out.exr")[0]
    assert (
        set(written_channels) == set("RGBA")
        and written_channels["A"].min() < 0.1
        and written_channels["A"].max() > 0.9
    )
    with PillowImage.open(tmp_path / "out.png") as image:
        assert image.mode == "RGBA"
