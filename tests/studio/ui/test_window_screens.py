"""Screens whose pixels are finer than the window's units, and windows of other sizes."""

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.view import Compare
from support.gui import gui_of
from support.session_files import BALL, BALL_M, HEIGHT, POST, POST_M, QUICK, WIDTH, room_file
from support.window_plates import displayed

K = imgui.Key


@pytest.fixture(params=[1.5, 2.0], ids=["1.5", "2"])
def fine(request, ctx, tmp_path):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), scale=request.param, defocus=QUICK) as gui:
        gui.do("1:1")
        gui.settled()
        yield gui, request.param


def on_screen(gui, scale: float) -> np.ndarray:
    """Return (H, W, 3) bytes of the picture at 1:1, in pixels of the screen."""
    x, y = (c * scale for c in gui.session.pictures.view.geometry.origin)
    assert (x, y) == (round(x), round(y))
    return gui.screenshot()[round(y) : round(y) + HEIGHT, round(x) : round(x) + WIDTH]


def test_one_to_one_is_a_pixel_of_the_screen_for_one_of_the_picture(fine):
    gui, scale = fine
    gui.do("Depth of field")
    expected = displayed(gui, gui.session.source.plate.color)
    np.testing.assert_array_equal(on_screen(gui, scale), expected)


def test_the_wipe_parts_them_on_a_pixel_of_the_screen(fine):
    gui, scale = fine
    a = on_screen(gui, scale)
    gui.key(K.w)
    gui.frame()
    assert gui.session.facts.view.compare is Compare.WIPE
    found = on_screen(gui, scale)
    b = displayed(gui, gui.session.source.plate.color)
    line, row = WIDTH // 2, 5
    np.testing.assert_array_equal(found[row, :line], a[row, :line])
    np.testing.assert_array_equal(found[row, line + 1 :], b[row, line + 1 :])


def test_clicks_hit_the_pixel_under_the_pointer(fine):
    gui, _ = fine
    for pixel, distance_m in ((POST, POST_M), (BALL, BALL_M)):
        gui.click(gui.at_picture(pixel[0] + 0.5, pixel[1] + 0.5))
        assert gui.session.facts.lens.focus_distance_m == distance_m


@pytest.mark.parametrize("size", [(640, 400), (401, 301), (120, 90), (3000, 300)])
def test_a_window_of_any_size_shows_all_of_a_fitting_picture(ctx, tmp_path, size):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), size=size, defocus=QUICK) as gui:
        gui.settled()
        x0, y0, x1, y1 = gui.rect("picture")
        (left, top), (right, bottom) = gui.at_picture(0, 0), gui.at_picture(WIDTH, HEIGHT)
        assert x0 - 1 <= left < right <= x1 + 1 and y0 - 1 <= top < bottom <= y1 + 1
        assert gui.screenshot().shape == (size[1], size[0], 3)
