"""FrameRenderer as a function: what the picture depends on, and what it must not depend on."""

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

LENS = Lens(50.0, 1.4, 2.0, 36.0)
SETTINGS = [DefocusSettings(b, q) for b in Bokeh for q in (Quality.DRAFT, Quality.FILM)]


def rendered(
    renderer: FrameRenderer,
    plate: Plate,
    lens: Lens = LENS,
    settings: DefocusSettings | None = None,
) -> Image:
    """Return (H, W, 4) of `plate` through `lens`."""
    renderer.load(plate)
    return renderer.pixels(Shot(lens, settings or DefocusSettings()))


def named(settings: DefocusSettings) -> str:
    return f"{settings.bokeh}-{settings.quality}"


@pytest.mark.parametrize("settings", SETTINGS, ids=named)
def test_the_same_shot_gives_the_same_bytes(ctx, renderer, settings):
    plate = plate_of(*room())
    first = rendered(renderer, plate, settings=settings)
    assert np.array_equal(first, rendered(renderer, plate, settings=settings))


@pytest.mark.parametrize("settings", SETTINGS, ids=named)
def test_what_was_rendered_before_leaves_no_trace(ctx, renderer, settings):
    """Textures and lists are reused from frame to frame, larger and smaller."""
    small, large = plate_of(*room(48, 27)), plate_of(*room(101, 63))
    alone = rendered(renderer, small, settings=settings)
    for other in SETTINGS:
        rendered(renderer, large, lens_blurring(30.0, 101), other)
        assert np.array_equal(rendered(renderer, small, settings=settings), alone)


def test_another_lens_on_the_loaded_plate_is_as_on_a_fresh_one(ctx, renderer):
    plate, other = plate_of(*room()), replace(LENS, focus_distance_m=0.9)
    fresh = rendered(renderer, plate, other)
    rendered(renderer, plate)
    assert np.array_equal(renderer.pixels(Shot(other)), fresh)
    assert not np.array_equal(renderer.pixels(Shot(LENS)), fresh)


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (9, 1), (2, 3), (3, 2), (17, 15), (65, 33)])
@pytest.mark.parametrize("settings", SETTINGS, ids=named)
def test_any_size_renders(ctx, renderer, rng, size, settings):
    width, height = size
    color = rng.random((height, width, 3), np.float32)
    depth = rng.choice(np.array([0.8, 2.0, 5.0, math.inf], np.float32), (height, width))
    picture = rendered(renderer, plate_of(color, depth), lens_blurring(8.0, 64), settings)
    assert picture.shape == (height, width, 4)
    assert np.isfinite(picture).all()
    # A mean of the plate's light, but for the few per cent by which a disc of exponentials ripples.
    assert -0.3 < picture[..., :3].min() and picture[..., :3].max() < 1.3


@pytest.mark.parametrize("size", [(16, 16), (17, 15), (100, 1), (1, 100), (3, 5)])
@pytest.mark.parametrize("proxy", [1 / 16, 0.3, 0.5, 0.999])
def test_a_proxy_has_the_rounded_size_and_at_least_a_pixel(ctx, renderer, size, proxy):
    width, height = size
    plate = plate_of(np.ones((height, width, 3), np.float32), np.full((height, width), 4.0))
    picture = rendered(renderer, plate, settings=DefocusSettings(proxy=proxy))
    assert picture.shape == (max(1, round(height * proxy)), max(1, round(width * proxy)), 4)


def test_the_data_windows_place_does_not_matter(ctx, renderer):
    """Blur is told by the display window's width, where neither window begins by nothing."""
    plate = plate_of(*room())
    width, height = plate.data_window.width, plate.data_window.height
    expected = rendered(renderer, plate)
    for display, x0, y0 in [
        (Box(0, 0, width, height), -7, 11),
        (Box(-20, 30, width - 20, height + 30), 5, 5),
        (Box(0, 0, width, 3 * height), -40, -40),
        (Box(10, 0, width + 10, 8), 0, 0),
    ]:
        data = Box(x0, y0, x0 + width, y0 + height)
        moved = replace(plate, data_window=data, display_window=display)
        assert np.array_equal(rendered(renderer, moved), expected)


def test_a_narrower_display_window_has_proportionally_less_blur(ctx, renderer):
    """The sensor's width falls on the display window: N twice as large is half the window."""
    plate = plate_of(*room())
    half = replace(plate, display_window=Box(0, 0, plate.display_window.width // 2, 54))
    expected = rendered(renderer, plate, replace(LENS, f_stop=2 * LENS.f_stop))
    assert np.array_equal(rendered(renderer, half), expected)


@pytest.mark.parametrize("settings", SETTINGS, ids=named)
def test_a_plate_of_coc_is_the_plate_whose_coc_it_is(ctx, renderer, settings):
    color, depth = room()
    line = coc_line(LENS, depth.shape[1])
    by_lens = rendered(renderer, plate_of(color, depth), settings=settings)
    by_coc = coc_plate_of(color, coc_px(depth, line).astype(np.float32))
    # Rounding to float32 differs by a unit, and half storage between the passes makes 1e-3 of it.
    ours = rendered(renderer, by_coc, settings=settings)
    np.testing.assert_allclose(ours, by_lens, rtol=2e-3, atol=2e-3)


def test_any_lens_does_on_a_plate_of_coc(ctx, renderer):
    color, depth = room()
    plate = coc_plate_of(color, np.where(depth > 2, 5.0, -3.0).astype(np.float32))
    first = rendered(renderer, plate, LENS)
    assert np.array_equal(first, rendered(renderer, plate, replace(LENS, f_stop=22.0)))


@pytest.mark.parametrize("focus_m", [0.051, 2.0, 1e5, math.inf])
@pytest.mark.parametrize("f_stop", [1e-3, 1.0, 1e6])
def test_any_lens_there_is_gives_finite_light(ctx, renderer, focus_m, f_stop):
    for settings in SETTINGS:
        picture = rendered(
            renderer, plate_of(*room(24, 14)), Lens(50.0, f_stop, focus_m, 36.0), settings
        )
        assert np.isfinite(picture).all()


def test_no_plate_no_picture(ctx):
    with pytest.raises(InputError, match="No plate"):
        FrameRenderer(ctx).pixels(Shot(LENS))


def test_a_plate_larger_than_a_texture_is_refused_before_it_is_sent(ctx, renderer):
    limit = ctx.limits.texture_side_px
    plate = plate_of(np.ones((1, 1, 3), np.float32), np.ones((1, 1), np.float32))
    with pytest.raises(GpuError, match=f"{limit + 1}x1.*{limit} pixels a side"):
        renderer.load(replace(plate, data_window=Box(0, 0, limit + 1, 1)))


def test_a_plate_is_reduced_once_for_all_lenses_of_one_proxy(ctx, renderer, monkeypatch):
    run, sizes = ProxyPass.run, []
    monkeypatch.setattr(
        ProxyPass, "run", lambda made, *words: sizes.append(words[3].size) or run(made, *words)
    )
    for number, (proxy, count) in enumerate([(0.5, 1), (0.5, 1), (0.25, 2), (0.25, 2), (0.5, 3)]):
        if not number:
            renderer.load(plate_of(*room()))
        settings = DefocusSettings(Bokeh.HEAT, Quality.DRAFT, proxy=proxy)
        renderer.pixels(Shot(replace(LENS, focus_distance_m=1.0 + number), settings))
        assert len(sizes) == count and sizes[-1] == proxy_size(room()[1].shape[::-1], proxy)
