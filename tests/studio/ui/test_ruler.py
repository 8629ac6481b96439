"""The ruler: the distance between two points of the picture in the world that it shows."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.view_geometry import Intrinsics, PictureShape
from heatlens.media.plate.depth_read import planar_depth_m
from heatlens.studio.ui.picture.pixel_values import _ruler_ends
from support.session_files import BALL, BALL_M, LENS, POST, POST_M, SKY, WIDTH

K = imgui.Key
CAMERA = Intrinsics(
    focal_length_mm=50.0,
    sensor_width_mm=36.0,
    shape=PictureShape(width_px=101, height_px=61, pixel_aspect=1.0),
)


def expected_m(a, b) -> float:
    """Return the distance in meters of two points (x px, y px, depth m) seen by the lens."""
    pitch = LENS.sensor_width_mm / WIDTH / LENS.focal_length_mm
    points = [
        np.array([(x + 0.5 - WIDTH / 2) * pitch, (y + 0.5 - 32) * pitch, 1.0]) * z
        for x, y, z in (a, b)
    ]
    return float(np.linalg.norm(points[0] - points[1]))


@given(
    st.integers(0, 100), st.integers(0, 60), st.floats(0.1, 50.0), st.sampled_from([1.0, 0.5, 2.0])
)
def test_point_m_agrees_with_the_conversion_of_radial_depth(x, y, z, aspect):
    """The distance from camera to point converts back to its planar depth."""
    camera = replace(CAMERA, shape=PictureShape(width_px=101, height_px=61, pixel_aspect=aspect))
    far = math.dist(camera.point_m((x, y), z), (0.0, 0.0, 0.0))
    radial = np.full((61, 101), far, np.float32)
    box = Box(0, 0, 101, 61)
    planar = planar_depth_m(radial, box, box, aspect, 50.0, 36.0)
    assert planar[y, x] == pytest.approx(z, rel=1e-5)


def test_point_m_of_both_edges_spans_the_field_of_view():
    left, right = CAMERA.point_m((0, 30), 2.0), CAMERA.point_m((100, 30), 2.0)
    assert math.dist(left, right) == pytest.approx(2.0 * 36.0 / 50.0 * 100 / 101)


def window_position(gui, pixel):
    return gui.at_picture(pixel[0] + 0.5, pixel[1] + 0.5)


def test_ruler_measures_by_two_clicks_without_focusing_until_escape(gui):
    session, ruler = gui.session, gui.session.pictures.commands.ruler
    focus_m = session.facts.lens.focus_distance_m
    gui.key(K.n)
    assert ruler.is_on
    gui.click(window_position(gui, BALL))
    assert ruler.points == (BALL,)
    gui.move(window_position(gui, POST))
    gui.later()
    assert ruler.measure(POST) is not None  # while the pointer moves
    assert (
        len(_ruler_ends(session.pictures, POST)) == 2
        and len(_ruler_ends(session.pictures, (-9, 5))) == 1
    )
    gui.click(window_position(gui, POST))
    assert ruler.points == (BALL, POST)
    measurement = ruler.measure()
    assert measurement.depths_m == pytest.approx((BALL_M, POST_M), rel=1e-3)
    assert measurement.distance_m == pytest.approx(
        expected_m((*BALL, BALL_M), (*POST, POST_M)), rel=1e-3
    )
    gui.frame()
    assert any(name.startswith("ruler ") for name in gui.drawn)
    session.lens.commands.step_f_stop(3)
    session.editing.edit_lens(replace(session.facts.lens, focal_length_mm=24.0))
    assert ruler.measure() == measurement  # a plate's camera is that of its file
    assert session.facts.lens.focus_distance_m == focus_m
    gui.key(K.escape)
    assert not ruler.is_on and ruler.points == ()
    gui.later()
    gui.click(window_position(gui, POST))
    assert session.facts.lens.focus_distance_m == pytest.approx(POST_M, rel=1e-3)


def test_ruler_drag_measures_and_next_click_starts_over(gui):
    ruler = gui.session.pictures.commands.ruler
    gui.do("Ruler")
    gui.drag(window_position(gui, POST), window_position(gui, BALL))
    assert ruler.points == (POST, BALL)
    gui.later()
    gui.click(window_position(gui, SKY))
    assert ruler.points == (SKY,)
    assert not math.isfinite(ruler.measure(BALL).distance_m)
    gui.frame(2)
    gui.do("Ruler")
    assert not ruler.is_on


def test_ruler_ignores_points_beside_the_picture(gui):
    ruler = gui.session.pictures.commands.ruler
    gui.do("Ruler")
    ruler.press((-3, 5))
    assert ruler.points == ()
    ruler.press(BALL)
    assert ruler.measure((WIDTH + 4, 5)) is None
    gui.frame(2)
    gui.do("Ruler")
