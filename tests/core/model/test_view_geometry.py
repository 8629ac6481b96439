"""Test window and picture coordinates: round trips, worked positions, zoom and pan."""

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
    pan_view,
    zoom_view,
    zoom_view_to,
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


def window_position(viewport: Viewport, part: tuple[float, float]) -> tuple[float, float]:
    """Return a window position at a part of the viewport's width and height."""
    (x, y), (width, height) = viewport.corner, viewport.size
    return x + part[0] * width, y + part[1] * height


def screen_px_between(a, b, viewport: Viewport) -> float:
    return viewport.framebuffer_scale * max(abs(a[0] - b[0]), abs(a[1] - b[1]))


@given(VIEWS, VIEWPORTS, SHAPES, POINTS)
def test_picture_to_window_and_back_returns_the_point(view, viewport, shape, point):
    view_geometry = geometry(view, viewport, shape)
    returned_point = view_geometry.picture_at_window(view_geometry.window_at_picture(point))
    assert returned_point == pytest.approx(point, rel=1e-9, abs=1e-6)


@given(VIEWS, VIEWPORTS, SHAPES, POINTS)
def test_window_to_picture_and_back_returns_the_position(view, viewport, shape, position):
    view_geometry = geometry(view, viewport, shape)
    returned_position = view_geometry.window_at_picture(view_geometry.picture_at_window(position))
    assert returned_position == pytest.approx(position, rel=1e-9, abs=1e-6)


@given(VIEWS, VIEWPORTS, SHAPES, st.integers(-3000, 9000), st.integers(-3000, 9000))
def test_pixel_at_window_of_pixel_center_is_that_pixel(view, viewport, shape, x, y):
    view_geometry = geometry(view, viewport, shape)
    assert view_geometry.pixel_at_window(view_geometry.window_at_picture((x + 0.5, y + 0.5))) == (
        x,
        y,
    )


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
def test_window_at_picture_matches_worked_positions(shape, zoom, scale, point, position):
    viewport = Viewport(corner=(100.0, 50.0), size=(1000.0, 600.0), framebuffer_scale=scale)
    view_geometry = geometry(ViewState(zoom=zoom), viewport, shape)
    assert view_geometry.window_at_picture(point) == pytest.approx(position)


@given(VIEWPORTS, SHAPES, st.tuples(st.floats(-50, 9000), st.floats(-50, 9000)))
def test_zoom_1_aligns_picture_pixels_with_screen_pixels(viewport, shape, center):
    square = replace(shape, pixel_aspect=1.0)
    view_geometry = geometry(ViewState(zoom=1.0, center_px=center), viewport, square)
    for point in ((0, 0), (1, 1), (17, 4)):
        for window_coordinate in view_geometry.window_at_picture(point):
            on_screen = window_coordinate * viewport.framebuffer_scale
            assert on_screen == pytest.approx(round(on_screen), abs=1e-6)
    step = view_geometry.per_px[0] * viewport.framebuffer_scale, view_geometry.per_px[1]
    assert step == pytest.approx((1.0, 1.0 / viewport.framebuffer_scale))


@given(VIEWPORTS, SHAPES)
def test_fit_zoom_shows_whole_picture_and_fills_one_side(viewport, shape):
    zoom = fit_zoom(viewport, shape)
    view_geometry = geometry(ViewState(), viewport, shape)
    first = view_geometry.window_at_picture((0, 0))
    last = view_geometry.window_at_picture((shape.width_px, shape.height_px))
    tolerance = 1.0 / viewport.framebuffer_scale  # the corner is put on a whole screen pixel
    margins = [viewport.size[i] - (last[i] - first[i]) for i in (0, 1)]
    if zoom > ZOOM_LEAST:
        assert min(margins) >= -1e-6
        for i in (0, 1):
            assert first[i] >= viewport.corner[i] - tolerance
            assert last[i] <= viewport.corner[i] + viewport.size[i] + tolerance
    if ZOOM_LEAST < zoom < ZOOM_MOST:
        assert min(margins) == pytest.approx(0, abs=1e-6)


@given(VIEWS, VIEWPORTS, SHAPES, st.floats(0.05, 20), st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_zoom_view_keeps_picture_point_under_pointer(view, viewport, shape, factor, pointer_part):
    """The tolerance is half a screen pixel, as the picture's corner is put on a whole one."""
    pointer = window_position(viewport, pointer_part)
    picture_point = geometry(view, viewport, shape).picture_at_window(pointer)
    after = zoom_view(view, viewport, shape, factor, pointer)
    position_after = geometry(after, viewport, shape).window_at_picture(picture_point)
    assert screen_px_between(position_after, pointer, viewport) <= 0.5 + 1e-4


@given(VIEWS, VIEWPORTS, SHAPES, st.floats(1e-4, 1e4))
def test_zoom_view_to_clamps_zoom_to_its_limits(view, viewport, shape, zoom):
    after = zoom_view_to(view, viewport, shape, zoom, viewport.middle)
    assert after.zoom == min(max(zoom, ZOOM_LEAST), ZOOM_MOST)
    before = view.zoom or fit_zoom(viewport, shape)
    twice = zoom_view(view, viewport, shape, 2.0, viewport.middle).zoom
    assert twice == min(max(before * 2.0, ZOOM_LEAST), ZOOM_MOST)


@given(VIEWS, VIEWPORTS, SHAPES)
def test_zooming_in_and_out_at_one_point_keeps_position(view, viewport, shape):
    pointer = window_position(viewport, (0.3, 0.8))
    start = zoom_view_to(view, viewport, shape, 1.0, pointer)
    picture_point = geometry(start, viewport, shape).picture_at_window(pointer)
    zoomed_view = start
    for factor in (1.25,) * 6 + (0.8,) * 6:
        zoomed_view = zoom_view(zoomed_view, viewport, shape, factor, pointer)
    assert zoomed_view.zoom == pytest.approx(1.0)
    position_after = geometry(zoomed_view, viewport, shape).window_at_picture(picture_point)
    assert (
        screen_px_between(position_after, pointer, viewport) <= 12 * 0.5
    )  # half a pixel a step at most


@given(VIEWPORTS, SHAPES, ZOOMS, st.tuples(st.integers(-300, 300), st.integers(-300, 300)))
def test_pan_view_follows_pointer_until_edge_is_at_middle(viewport, shape, zoom, by):
    before = ViewState(zoom=zoom)
    after = pan_view(before, viewport, shape, by)
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
def test_pan_view_never_moves_more_than_pointer(view, viewport, shape, by):
    after = pan_view(view, viewport, shape, by)
    a, b = (geometry(v, viewport, shape).window_at_picture((0, 0)) for v in (view, after))
    whole = 1.0 / viewport.framebuffer_scale
    for axis in (0, 1):
        assert abs(b[axis] - a[axis]) <= abs(by[axis]) + whole + 1e-6


@given(VIEWPORTS, SHAPES)
def test_pan_view_from_fit_keeps_fit_zoom(viewport, shape):
    after = pan_view(ViewState(), viewport, shape, (5, 5))
    assert after.zoom == fit_zoom(viewport, shape)


def test_zoom_view_by_extreme_factor_stays_finite():
    viewport, shape = Viewport((0.0, 0.0), (8.0, 8.0)), PictureShape(1, 16384)
    for factor in (1e300, 1e-300):
        after = zoom_view(ViewState(), viewport, shape, factor, (1e6, -1e6))
        assert all(math.isfinite(value) for value in after.center_px)
