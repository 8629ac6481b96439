"""The picture alone: without panels in the window, and in a second window for the client."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.view import Compare
from heatlens.studio.ui.picture.picture_alone import PictureAlone
from support.session_files import HEIGHT, WIDTH

K = imgui.Key


@pytest.fixture
def gui(gui):
    yield gui
    gui.ui.leave_bare()
    gui.frame(3)


def test_tab_hides_all_but_the_picture_and_shows_it_again(gui):
    gui.frame(3)
    before = gui.rect("focus bar")
    gui.key(K.tab)
    gui.drawn.clear()
    gui.frame(3)
    assert not {"focus bar", "menu File", "sides"} & set(gui.drawn)
    viewport = gui.session.pictures.view.viewport
    assert (viewport.corner, viewport.size) == ((0.0, 0.0), gui.size)
    gui.key(K.tab)
    gui.frame(4)
    assert gui.rect("focus bar") == before


def test_escape_leaves_picture_alone_and_full_screen(gui):
    gui.key(K.tab)
    gui.key(K.f11)
    assert gui.ui.is_bare and gui.ui.is_full_screen
    gui.key(K.escape)
    assert not gui.ui.is_bare and not gui.ui.is_full_screen


def test_tab_moves_between_fields_while_one_is_edited(gui):
    gui.click(gui.middle("distance"))
    gui.key(K.tab)
    assert not gui.ui.is_bare
    gui.key(K.escape)
    gui.frame(2)


def test_click_focuses_while_the_picture_is_alone(gui):
    gui.key(K.tab)
    gui.frame(2)
    before = gui.session.facts.lens
    gui.click(gui.at_picture(10.5, HEIGHT - 3.5))
    assert gui.session.facts.lens != before


def test_second_window_shows_the_picture_without_overlay_or_zoom(gui):
    gui.settled()
    gui.session.pictures.commands.change(overlay="zones", compare=Compare.OFF)
    gui.do("1:1")
    alone, size = PictureAlone(gui.ctx), (2 * WIDTH + 40, 2 * HEIGHT)
    alone.draw(gui.screen.picture.pictures, gui.session.facts.view, size)
    pixels = np.frombuffer(alone.texture.read(), np.uint8).reshape(size[1], size[0], 4)[::-1]
    display = np.frombuffer(gui.screen.picture.pictures.a.read(), np.uint8)
    display = display.reshape(HEIGHT, WIDTH, 4)
    inside = pixels[::2, 20:-20:2, :3].astype(int)
    surround = pixels[:, :19, :3]
    assert (surround == surround[0, 0]).all()
    differences = [np.abs(inside - flipped[..., :3]).mean() for flipped in (display, display[::-1])]
    assert min(differences) < 3.0
    alone.release()


def draw_second_window(gui, alone: PictureAlone, has_labels: bool) -> np.ndarray:
    """Draw the second window; return its pixels (540, 960, 3), the top row first."""
    size = (960, 540)
    alone.draw(gui.screen.picture.pictures, gui.session.facts.view, size, has_labels)
    pixels = np.frombuffer(alone.texture.read(), np.uint8).reshape(size[1], size[0], 4)
    return pixels[::-1, :, :3].astype(int)


def test_second_window_names_looks_of_the_grid_if_switched_on(gui):
    session, alone = gui.session, PictureAlone(gui.ctx)
    for stop in (1.4, 8.0):
        session.editing.edit_lens(replace(session.facts.lens, f_stop=stop))
        gui.rest()
        session.pictures.looks.keep()
    gui.settled()
    np.testing.assert_array_equal(
        *(draw_second_window(gui, alone, named) for named in (True, False))
    )
    session.pictures.looks.toggle_grid()
    gui.settled()
    named, unnamed = (draw_second_window(gui, alone, has_labels) for has_labels in (True, False))
    cells = np.any(named != unnamed, axis=2)
    for down, across in ((0, 0), (0, 1), (1, 0)):  # A, B, and the lens as it is
        cell = cells[down * 270 : (down + 1) * 270, across * 480 : (across + 1) * 480]
        ys, xs = np.nonzero(cell)
        assert 5 < xs.min() < 20 < 100 < xs.max() and 220 < ys.min() < ys.max() < 268
    assert not cells[270:, 480:].any()
    session.pictures.looks.toggle_grid()
    assert gui.ui.has_feed_labels
    gui.do("Names of looks in the second window")
    assert not gui.ui.has_feed_labels
    gui.do("Names of looks in the second window")
    alone.release()
