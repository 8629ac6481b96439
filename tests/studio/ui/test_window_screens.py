"""Screens with several pixels per window unit, and windows of other sizes."""

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.view import Compare
from support.gui import gui_of
from support.session_files import BALL, BALL_M, HEIGHT, POST, POST_M, QUICK, WIDTH, room_file
from support.window_plates import display_bytes

K = imgui.Key


@pytest.fixture(params=[1.5, 2.0], ids=["1.5", "2"])
def fine(request, ctx, tmp_path):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), scale=request.param, defocus=QUICK) as gui:
        gui.do("1:1")
        gui.settled()
        yield gui, request.param


def picture_pixels(gui, scale: float) -> np.ndarray:
    """Return (H, W, 3) bytes of the picture at 1:1, in pixels of the screen."""
    x, y = (c * scale for c in gui.session.pictures.view.geometry.origin)
    assert (x, y) == (round(x), round(y))
    return gui.screenshot()[round(y) : round(y) + HEIGHT, round(x) : round(x) + WIDTH]


def test_one_to_one_draws_a_screen_pixel_per_picture_pixel(fine):
    gui, scale = fine
    gui.do("Depth of field")
    expected = display_bytes(gui, gui.session.source.plate.color)
    np.testing.assert_array_equal(picture_pixels(gui, scale), expected)


def test_wipe_splits_a_and_b_at_a_screen_pixel(fine):
    gui, scale = fine
    a = picture_pixels(gui, scale)
    gui.key(K.w)
    gui.frame()
    assert gui.session.facts.view.compare is Compare.WIPE
    pixels = picture_pixels(gui, scale)
    b = display_bytes(gui, gui.session.source.plate.color)
    line, row = WIDTH // 2, 5
    np.testing.assert_array_equal(pixels[row, :line], a[row, :line])
    np.testing.assert_array_equal(pixels[row, line + 1 :], b[row, line + 1 :])


def test_click_hits_the_pixel_under_the_pointer_on_a_scaled_screen(fine):
    gui, _ = fine
    for pixel, distance_m in ((POST, POST_M), (BALL, BALL_M)):
        gui.click(gui.at_picture(pixel[0] + 0.5, pixel[1] + 0.5))
        assert gui.session.facts.lens.focus_distance_m == distance_m


@pytest.mark.parametrize("size", [(640, 400), (401, 301), (120, 90), (3000, 300)])
def test_fitted_picture_is_wholly_visible_in_any_window_size(ctx, tmp_path, size):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), size=size, defocus=QUICK) as gui:
        gui.settled()
        x0, y0, x1, y1 = gui.rect("picture")
        (left, top), (right, bottom) = gui.at_picture(0, 0), gui.at_picture(WIDTH, HEIGHT)
        assert x0 - 1 <= left < right <= x1 + 1 and y0 - 1 <= top < bottom <= y1 + 1
        assert gui.screenshot().shape == (size[1], size[0], 3)
