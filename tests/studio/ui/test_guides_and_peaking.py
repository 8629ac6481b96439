"""Mattes and lines over the picture, and the coloured edges of what is in focus."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.view.guides import Canvas, FrameLine, Peaking, PeakingOn
from heatlens.studio.ui.status_bar import zoom_words
from support.session_files import BALL_M, HEIGHT, WIDTH

K = imgui.Key


def picture_pixels(gui) -> np.ndarray:
    """Return the pixels of the screen where the picture lies."""
    (x0, y0), (x1, y1) = gui.at_picture(0, 0), gui.at_picture(WIDTH, HEIGHT)
    return gui.screenshot()[round(y0) : round(y1), round(x0) : round(x1)].astype(int)


def test_matte_darkens_only_what_lies_outside_its_aspect(gui):
    gui.settled()
    before = picture_pixels(gui)
    gui.do("Frame mask 2.39")
    x0, y0, x1, y1 = gui.rect("matte in the picture")
    assert (x1 - x0) / (y1 - y0) == pytest.approx(2.39, rel=1e-3)
    after, top = picture_pixels(gui), round(y0 - gui.at_picture(0, 0)[1])
    height = round(y1 - y0)
    assert top > 10
    inner_rows = slice(top + 2, top + height - 2)
    np.testing.assert_array_equal(after[inner_rows, 3:-3], before[inner_rows, 3:-3])
    assert after[: top - 2].mean() < 0.5 * before[: top - 2].mean()
    gui.do("Frame mask 2.39")
    np.testing.assert_array_equal(picture_pixels(gui), before)


def test_guide_actions_draw_and_remove_their_lines(gui):
    gui.settled()
    before = picture_pixels(gui)
    for name in ("Safe areas", "Thirds", "Centre cross"):
        gui.do(name)
        assert np.any(picture_pixels(gui) != before), name
        gui.do(name)
    np.testing.assert_array_equal(picture_pixels(gui), before)


def test_peaking_colors_only_edges_in_focus(gui):
    gui.session.lens.commands.focus(BALL_M)
    gui.rest()
    gui.key(K.p, shift=True)
    assert gui.session.facts.view.is_peaking
    gui.settled()
    colored = overlay_alpha(gui) > 0
    assert 0 < colored.mean() < 0.5
    gui.session.pictures.commands.change(peaking=Peaking(stops=3.0))
    gui.frame(2)
    assert 0 < (overlay_alpha(gui) > 0).sum() <= colored.sum()  # silhouettes stay
    gui.session.lens.commands.focus(1e6)
    gui.rest()
    gui.frame(3)
    assert not np.any((overlay_alpha(gui) > 0) & colored)


def test_peaking_is_drawn_over_the_picture_without_changing_it(gui):
    gui.settled()
    shown = gui.session.pictures.live.output
    for on in PeakingOn:
        gui.session.pictures.commands.change(is_peaking=True, peaking=Peaking(on))
        gui.frame(3)
        assert overlay_alpha(gui).any()
        assert (
            gui.session.pictures.live.output is shown
        )  # what is saved and exported is rendered without


def test_zones_and_peaking_overlays_combine_and_toggle_separately(gui):
    gui.session.lens.commands.focus(BALL_M)
    gui.rest()
    gui.key(K.p, shift=True)
    gui.settled()
    edges = overlay_alpha(gui)
    gui.key(K.z)
    gui.frame(2)
    view, combined = gui.session.facts.view, overlay_alpha(gui)
    assert view.is_peaking and view.overlay == "zones"
    assert (combined > 0).all() and (combined[edges > 200] >= edges[edges > 200]).all()
    gui.key(K.p, shift=True)
    gui.frame(2)
    assert (
        gui.session.facts.view.overlay == "zones" and (overlay_alpha(gui) == combined.min()).all()
    )
    gui.key(K.z)
    gui.frame(2)
    assert gui.screen.picture.pictures.overlay is None


def overlay_alpha(gui) -> np.ndarray:
    texture = gui.screen.picture.pictures.overlay
    pixels = np.frombuffer(texture.read(), np.uint8)
    return pixels.reshape(texture.height, texture.width, 4)[..., 3]


def test_zoom_words_show_the_zoom_in_percent(gui):
    gui.do("1:1")
    gui.frame()
    assert zoom_words(gui.session.pictures.view.zoom) == "100 %"
    assert (zoom_words(16.0), zoom_words(0.045)) == ("1600 %", "4.5 %")


def show_guides(gui):
    imgui.set_window_focus("Display")
    gui.frame(3)
    gui.unfolded("Frame masks and guides", "frame mask")


def test_guides_panel_sets_mask_lines_and_peaking(gui):
    show_guides(gui)
    gui.click(gui.middle("thirds"))
    gui.click(gui.middle("focus peaking"))
    view = gui.session.facts.view
    assert view.guides.thirds and view.is_peaking
    gui.click(gui.middle("frame mask"))
    gui.frame(2)
    gui.click(gui.middle("frame mask: own"))
    gui.frame(2)
    gui.click(gui.middle("own aspect"))
    gui.key(K.a, ctrl=True)
    gui.type("2,2:1")
    gui.key(K.enter)
    gui.frame(2)
    assert gui.session.facts.view.guides.aspect == 2.2


def test_desqueeze_widens_the_picture_and_maps_the_pointer(gui):
    gui.settled()
    (x0, y0), (x1, y1) = gui.at_picture(0, 0), gui.at_picture(WIDTH, HEIGHT)
    show_guides(gui)
    gui.click(gui.middle("desqueeze"))
    gui.frame(2)
    gui.click(gui.middle("desqueeze: 2"))
    gui.settled()
    (u0, v0), (u1, v1) = gui.at_picture(0, 0), gui.at_picture(WIDTH, HEIGHT)
    assert (u1 - u0) / (v1 - v0) == pytest.approx(2 * (x1 - x0) / (y1 - y0))
    viewport = gui.session.pictures.view.viewport
    assert u1 - u0 <= viewport.size[0] + 1  # the whole picture still fits
    position = gui.at_picture(20.5, 40.5)
    gui.move(position)
    gui.frame()
    assert gui.screen.picture.hovered_px == (20, 40)
    gui.wheel(position, 3)
    assert gui.at_picture(20.5, 40.5) == pytest.approx(position, abs=1.0)


def test_guides_panel_offers_the_squeeze_of_the_lens_as_desqueeze(gui):
    session = gui.session
    session.editing.edit_lens(replace(session.facts.lens, squeeze=1.75))
    gui.rest()
    show_guides(gui)
    gui.click(gui.middle("desqueeze"))
    gui.frame(2)
    gui.click(gui.middle("desqueeze: as the lens: 1.75"))
    assert session.facts.view.guides.desqueeze == 1.75


def test_framing_lines_are_drawn_and_removed(gui):
    view, line = gui.session.pictures.view, FrameLine("239", (0.25, 0.25, 0.75, 0.75))
    canvas = Canvas(10.0 * WIDTH, 10.0 * HEIGHT, (line,))
    view.state = replace(view.state, guides=replace(view.state.guides, canvases=(canvas,)))
    show_guides(gui)
    corners = (
        *gui.at_picture(WIDTH / 4, HEIGHT / 4),
        *gui.at_picture(WIDTH * 3 / 4, HEIGHT * 3 / 4),
    )
    assert gui.drawn["frame 239"] == pytest.approx(corners, abs=0.01)
    gui.click(gui.middle("no framing"))
    assert gui.session.facts.view.guides.canvases == ()
