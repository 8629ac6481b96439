"""Window and picture coordinates: round trips, worked positions, and what zoom and pan promise."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.view.view import ViewState
from heatlens.core.model.view.view_geometry import (
    ZOOM_LEAST,
    ZOOM_MOST,
    PictureShape,
    Viewport,
    fit_zoom,
    geometry,
    panned,
    zoomed,
    zoomed_to,
)

SCALES = st.sampled_from([1.0, 1.5, 2.0])
VIEWPORTS = st.builds(
    Viewport,
    st.tuples(st.integers(-2000, 2000), st.integers(-2000, 2000)),
    st.tuples(st.integers(8, 4000), st.integers(8, 3000)),
    SCALES,
)
SHAPES = st.builds(
    PictureShape,
    st.integers(1, 9000),
    st.integers(1, 9000),
    st.sampled_from([0.5, 0.9, 1.0, 1.46, 2.0]),
)
ZOOMS = st.floats(ZOOM_LEAST, ZOOM_MOST)
VIEWS = st.builds(
    ViewState,
    zoom=st.one_of(st.none(), ZOOMS),
    center_px=st.one_of(st.none(), st.tuples(st.floats(-3000, 9000), st.floats(-3000, 9000))),
)
POINTS = st.tuples(st.floats(-5000, 12000), st.floats(-5000, 12000))


def inside(viewport: Viewport, part: tuple[float, float]) -> tuple[float, float]:
    """Return a window position at a part of the viewport's width and height."""
    (x, y), (width, height) = viewport.corner, viewport.size
    return x + part[0] * width, y + part[1] * height


def screen_px_between(a, b, viewport: Viewport) -> float:
    return viewport.framebuffer_scale * max(abs(a[0] - b[0]), abs(a[1] - b[1]))


@given(VIEWS, VIEWPORTS, SHAPES, POINTS)
def test_a_picture_point_comes_back_from_the_window(view, viewport, shape, point):
    there = geometry(view, viewport, shape)
    back = there.picture_at_window(there.window_at_picture(point))
    assert back == pytest.approx(point, rel=1e-9, abs=1e-6)


@given(VIEWS, VIEWPORTS, SHAPES, POINTS)
def test_a_window_position_comes_back_from_the_picture(view, viewport, shape, position):
    there = geometry(view, viewport, shape)
    back = there.window_at_picture(there.picture_at_window(position))
    assert back == pytest.approx(position, rel=1e-9, abs=1e-6)


@given(VIEWS, VIEWPORTS, SHAPES, st.integers(-3000, 9000), st.integers(-3000, 9000))
def test_the_middle_of_a_pixel_is_in_that_pixel(view, viewport, shape, x, y):
    there = geometry(view, viewport, shape)
    assert there.pixel_at_window(there.window_at_picture((x + 0.5, y + 0.5))) == (x, y)


# A 1000 x 600 viewport at (100, 50): its middle is (600, 350).
@pytest.mark.parametrize(
    ("shape", "zoom", "scale", "point", "position"),
    [
        (PictureShape(200, 100), 1.0, 1.0, (0, 0), (500, 300)),
        (PictureShape(200, 100), 4.0, 1.0, (100, 50), (600, 350)),
        (PictureShape(200, 100), 4.0, 2.0, (0, 0), (400, 250)),
        (PictureShape(200, 100), 3.0, 1.5, (-10, 110), (380, 470)),
        (PictureShape(200, 100, 2.0), 1.0, 1.0, (0, 100), (400, 400)),
        (PictureShape(200, 100), None, 1.0, (0, 0), (100, 100)),
        (PictureShape(200, 100, 2.0), None, 1.0, (200, 100), (1100, 475)),
    ],
)
def test_worked_positions(shape, zoom, scale, point, position):
    viewport = Viewport((100.0, 50.0), (1000.0, 600.0), scale)
    there = geometry(ViewState(zoom=zoom), viewport, shape)
    assert there.window_at_picture(point) == pytest.approx(position)


@given(VIEWPORTS, SHAPES, st.tuples(st.floats(-50, 9000), st.floats(-50, 9000)))
def test_one_to_one_lands_on_whole_screen_pixels(viewport, shape, center):
    square = replace(shape, pixel_aspect=1.0)
    there = geometry(ViewState(zoom=1.0, center_px=center), viewport, square)
    for point in ((0, 0), (1, 1), (17, 4)):
        for at in there.window_at_picture(point):
            on_screen = at * viewport.framebuffer_scale
            assert on_screen == pytest.approx(round(on_screen), abs=1e-6)
    step = there.per_px[0] * viewport.framebuffer_scale, there.per_px[1]
    assert step == pytest.approx((1.0, 1.0 / viewport.framebuffer_scale))


@given(VIEWPORTS, SHAPES)
def test_fit_shows_all_and_fills_one_side(viewport, shape):
    zoom = fit_zoom(viewport, shape)
    there = geometry(ViewState(), viewport, shape)
    first = there.window_at_picture((0, 0))
    last = there.window_at_picture((shape.width_px, shape.height_px))
    near = 1.0 / viewport.framebuffer_scale  # the corner is put on a whole screen pixel
    room = [viewport.size[i] - (last[i] - first[i]) for i in (0, 1)]
    if zoom > ZOOM_LEAST:
        assert min(room) >= -1e-6
        for i in (0, 1):
            assert first[i] >= viewport.corner[i] - near
            assert last[i] <= viewport.corner[i] + viewport.size[i] + near
    if ZOOM_LEAST < zoom < ZOOM_MOST:
        assert min(room) == pytest.approx(0, abs=1e-6)


@given(VIEWS, VIEWPORTS, SHAPES, st.floats(0.05, 20), st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_zoom_keeps_what_is_under_the_pointer(view, viewport, shape, factor, part):
    """To half a screen pixel, as the picture's corner is put on a whole one."""
    at = inside(viewport, part)
    held = geometry(view, viewport, shape).picture_at_window(at)
    after = zoomed(view, viewport, shape, factor, at)
    now = geometry(after, viewport, shape).window_at_picture(held)
    assert screen_px_between(now, at, viewport) <= 0.5 + 1e-4


@given(VIEWS, VIEWPORTS, SHAPES, st.floats(1e-4, 1e4))
def test_zoom_is_what_was_asked_for_within_its_limits(view, viewport, shape, zoom):
    after = zoomed_to(view, viewport, shape, zoom, viewport.middle)
    assert after.zoom == min(max(zoom, ZOOM_LEAST), ZOOM_MOST)
    before = view.zoom or fit_zoom(viewport, shape)
    twice = zoomed(view, viewport, shape, 2.0, viewport.middle).zoom
    assert twice == min(max(before * 2.0, ZOOM_LEAST), ZOOM_MOST)


@given(VIEWS, VIEWPORTS, SHAPES)
def test_zoom_in_and_out_again_about_one_point_moves_nothing_far(view, viewport, shape):
    at = inside(viewport, (0.3, 0.8))
    start = zoomed_to(view, viewport, shape, 1.0, at)
    held = geometry(start, viewport, shape).picture_at_window(at)
    again = start
    for factor in (1.25,) * 6 + (0.8,) * 6:
        again = zoomed(again, viewport, shape, factor, at)
    assert again.zoom == pytest.approx(1.0)
    now = geometry(again, viewport, shape).window_at_picture(held)
    assert screen_px_between(now, at, viewport) <= 12 * 0.5  # half a pixel a step at most


@given(VIEWPORTS, SHAPES, ZOOMS, st.tuples(st.integers(-300, 300), st.integers(-300, 300)))
def test_pan_moves_the_picture_as_the_hand_until_its_edge_is_in_the_middle(
    viewport, shape, zoom, by
):
    before = ViewState(zoom=zoom)
    after = panned(before, viewport, shape, by)
    x, y = after.center_px
    assert 0 <= x <= shape.width_px and 0 <= y <= shape.height_px
    a, b = (geometry(v, viewport, shape).window_at_picture((0, 0)) for v in (before, after))
    moved = b[0] - a[0], b[1] - a[1]
    whole = 1.0 / viewport.framebuffer_scale
    for axis in (0, 1):
        if 0 < after.center_px[axis] < (shape.width_px, shape.height_px)[axis]:
            assert moved[axis] == pytest.approx(by[axis], abs=whole + 1e-6)
        assert abs(moved[axis]) <= abs(by[axis]) + whole + 1e-6


@given(VIEWS, VIEWPORTS, SHAPES, st.tuples(st.integers(-9, 9), st.integers(-9, 9)))
def test_pan_never_jumps_wherever_the_picture_was_zoomed_to(view, viewport, shape, by):
    after = panned(view, viewport, shape, by)
    a, b = (geometry(v, viewport, shape).window_at_picture((0, 0)) for v in (view, after))
    whole = 1.0 / viewport.framebuffer_scale
    for axis in (0, 1):
        assert abs(b[axis] - a[axis]) <= abs(by[axis]) + whole + 1e-6


@given(VIEWPORTS, SHAPES)
def test_a_fitting_picture_keeps_its_size_when_it_is_panned(viewport, shape):
    after = panned(ViewState(), viewport, shape, (5, 5))
    assert after.zoom == fit_zoom(viewport, shape)


def test_zoom_knows_nothing_that_is_not_finite():
    viewport, shape = Viewport((0.0, 0.0), (8.0, 8.0)), PictureShape(1, 16384)
    for factor in (1e300, 1e-300):
        after = zoomed(ViewState(), viewport, shape, factor, (1e6, -1e6))
        assert all(math.isfinite(value) for value in after.center_px)
