"""FrameRenderer: the inputs on which its picture depends, and those on which it must not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError, InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.plate_passes import ProxyPass, proxy_size
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import Image, coc_plate_of, lens_blurring, plate_of, room
from support.watched_calls import watch_calls

LENS = Lens(50.0, 1.4, 2.0, 36.0)
SETTINGS = [DefocusSettings(b, q) for b in Bokeh for q in (Quality.DRAFT, Quality.FILM)]


def render_plate(
    renderer: FrameRenderer,
    plate: Plate,
    lens: Lens = LENS,
    settings: DefocusSettings | None = None,
) -> Image:
    """Return (H, W, 4) of `plate` through `lens`."""
    renderer.load(plate)
    return renderer.pixels(Shot(lens, settings or DefocusSettings()))


def settings_id(settings: DefocusSettings) -> str:
    return f"{settings.bokeh}-{settings.quality}"


@pytest.mark.parametrize("settings", SETTINGS, ids=settings_id)
def test_render_is_deterministic(ctx, renderer, settings):
    plate = plate_of(*room())
    first = render_plate(renderer, plate, settings=settings)
    assert np.array_equal(first, render_plate(renderer, plate, settings=settings))


@pytest.mark.parametrize("settings", SETTINGS, ids=settings_id)
def test_render_does_not_depend_on_earlier_plates(ctx, renderer, settings):
    """Alternate plates of two sizes, which reuse textures and lists, and compare the pictures."""
    small, large = plate_of(*room(48, 27)), plate_of(*room(101, 63))
    alone = render_plate(renderer, small, settings=settings)
    for other in SETTINGS:
        render_plate(renderer, large, lens_blurring(30.0, 101), other)
        assert np.array_equal(render_plate(renderer, small, settings=settings), alone)


def test_render_with_changed_lens_equals_fresh_load(ctx, renderer):
    plate, other = plate_of(*room()), replace(LENS, focus_distance_m=0.9)
    fresh = render_plate(renderer, plate, other)
    render_plate(renderer, plate)
    assert np.array_equal(renderer.pixels(Shot(other)), fresh)
    assert not np.array_equal(renderer.pixels(Shot(LENS)), fresh)


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (9, 1), (2, 3), (3, 2), (17, 15), (65, 33)])
@pytest.mark.parametrize("settings", SETTINGS, ids=settings_id)
def test_render_of_any_size_is_finite(ctx, renderer, rng, size, settings):
    width, height = size
    color = rng.random((height, width, 3), np.float32)
    depth = rng.choice(np.array([0.8, 2.0, 5.0, math.inf], np.float32), (height, width))
    picture = render_plate(renderer, plate_of(color, depth), lens_blurring(8.0, 64), settings)
    assert picture.shape == (height, width, 4)
    assert np.isfinite(picture).all()
    # A mean of the plate's light, but for the few per cent by which a disc of exponentials ripples.
    assert -0.3 < picture[..., :3].min() and picture[..., :3].max() < 1.3


@pytest.mark.parametrize("size", [(16, 16), (17, 15), (100, 1), (1, 100), (3, 5)])
@pytest.mark.parametrize("proxy", [1 / 16, 0.3, 0.5, 0.999])
def test_proxy_has_rounded_size_of_at_least_one_pixel(ctx, renderer, size, proxy):
    width, height = size
    plate = plate_of(np.ones((height, width, 3), np.float32), np.full((height, width), 4.0))
    picture = render_plate(renderer, plate, settings=DefocusSettings(proxy=proxy))
    assert picture.shape == (max(1, round(height * proxy)), max(1, round(width * proxy)), 4)


def test_render_does_not_depend_on_window_positions(ctx, renderer):
    """Move both windows: the blur depends on the display window's width alone."""
    plate = plate_of(*room())
    width, height = plate.data_window.width, plate.data_window.height
    expected = render_plate(renderer, plate)
    for display, x0, y0 in [
        (Box(0, 0, width, height), -7, 11),
        (Box(-20, 30, width - 20, height + 30), 5, 5),
        (Box(0, 0, width, 3 * height), -40, -40),
        (Box(10, 0, width + 10, 8), 0, 0),
    ]:
        data = Box(x0, y0, x0 + width, y0 + height)
        moved = replace(plate, data_window=data, display_window=display)
        assert np.array_equal(render_plate(renderer, moved), expected)


def test_coc_is_proportional_to_display_window_width(ctx, renderer):
    """Compare half a display window, which the sensor's width covers, with twice the f-number."""
    plate = plate_of(*room())
    half = replace(plate, display_window=Box(0, 0, plate.display_window.width // 2, 54))
    expected = render_plate(renderer, plate, replace(LENS, f_stop=2 * LENS.f_stop))
    assert np.array_equal(render_plate(renderer, half), expected)


@pytest.mark.parametrize("settings", SETTINGS, ids=settings_id)
def test_coc_plate_renders_like_depth_plate(ctx, renderer, settings):
    color, depth = room()
    line = coc_line(LENS, depth.shape[1])
    by_lens = render_plate(renderer, plate_of(color, depth), settings=settings)
    by_coc = coc_plate_of(color, coc_px(depth, line).astype(np.float32))
    # Rounding to float32 differs by a unit, and half storage between the passes makes 1e-3 of it.
    coc_picture = render_plate(renderer, by_coc, settings=settings)
    np.testing.assert_allclose(coc_picture, by_lens, rtol=2e-3, atol=2e-3)


def test_coc_plate_ignores_lens(ctx, renderer):
    color, depth = room()
    plate = coc_plate_of(color, np.where(depth > 2, 5.0, -3.0).astype(np.float32))
    first = render_plate(renderer, plate, LENS)
    assert np.array_equal(first, render_plate(renderer, plate, replace(LENS, f_stop=22.0)))


@pytest.mark.parametrize("focus_m", [0.051, 2.0, 1e5, math.inf])
@pytest.mark.parametrize("f_stop", [1e-3, 1.0, 1e6])
def test_extreme_lenses_give_finite_pictures(ctx, renderer, focus_m, f_stop):
    for settings in SETTINGS:
        picture = render_plate(
            renderer, plate_of(*room(24, 14)), Lens(50.0, f_stop, focus_m, 36.0), settings
        )
        assert np.isfinite(picture).all()


def test_pixels_without_plate_raises_input_error(ctx):
    with pytest.raises(InputError, match="No plate"):
        FrameRenderer(ctx).pixels(Shot(LENS))


def test_load_refuses_plate_larger_than_a_texture(ctx, renderer):
    limit = ctx.limits.texture_side_px
    plate = plate_of(np.ones((1, 1, 3), np.float32), np.ones((1, 1), np.float32))
    with pytest.raises(GpuError, match=f"{limit + 1}x1.*{limit} pixels a side"):
        renderer.load(replace(plate, data_window=Box(0, 0, limit + 1, 1)))


def test_proxy_plate_is_reused_until_proxy_changes(ctx, renderer, monkeypatch):
    calls = watch_calls(monkeypatch, ProxyPass, "run")
    for number, (proxy, count) in enumerate([(0.5, 1), (0.5, 1), (0.25, 2), (0.25, 2), (0.5, 3)]):
        if not number:
            renderer.load(plate_of(*room()))
        settings = DefocusSettings(Bokeh.HEAT, Quality.DRAFT, proxy=proxy)
        renderer.pixels(Shot(replace(LENS, focus_distance_m=1.0 + number), settings))
        assert len(calls) == count
        _, _, _, _, out_color, *_ = calls[-1]
        assert out_color.size == proxy_size(room()[1].shape[::-1], proxy)
