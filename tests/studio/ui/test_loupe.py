"""The loupe: the plate under the pointer, enlarged and without depth of field."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.studio.ui.picture.loupe import MAGNIFICATION
from support.exr_files import write_file
from support.mattes import CARD, HERO, MANIFEST, as_float
from support.session_files import BALL, BALL_M, POST, POST_M, SKY

K = imgui.Key


def window_position(gui, pixel):
    x, y = pixel
    return gui.session.pictures.view.geometry.window_at_picture((x + 0.5, y + 0.5))


def loupe_at(gui, pixel):
    """Move the pointer to a pixel; return the lines of the loupe, none if it is not drawn."""
    gui.move(window_position(gui, pixel))
    return draw_lines(gui)


def draw_lines(gui):
    gui.drawn.clear()
    gui.frame(2)
    return [name.removeprefix("loupe ") for name in gui.drawn if name.startswith("loupe ")]


def test_loupe_shows_the_distance_that_a_click_focuses_on(gui):
    assert loupe_at(gui, POST) == []
    gui.key(K.d, shift=True)  # switches the loupe on
    assert loupe_at(gui, POST) == [f"{POST_M:g} m"]
    gui.click(window_position(gui, POST))
    gui.later()
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(POST_M, rel=1e-3)


def test_loupe_is_centered_on_the_pixel_under_the_pointer(gui):
    """The loupe enlarges the whole picture by `TIMES` about the pixel under the pointer."""
    gui.do("Loupe")
    loupe_at(gui, BALL)
    assert_shows(gui, "loupe", BALL)


def test_loupe_on_the_flag_of_a_mark_shows_the_marked_pixel(gui):
    """The loupe shows only while the pointer rests on the flag, and not during a drag."""
    gui.session.time.marks.set_point(BALL)
    flag = f"{gui.session.facts.shot.marks[-1].name} on the bar"
    gui.frame(2)
    gui.move(gui.middle(flag))
    gui.frame(2)
    assert_shows(gui, "place of the mark", BALL)
    assert gui.drawn["place of the mark"][3] <= gui.drawn["focus bar"][1] + 1
    gui.press(gui.middle(flag))
    gui.drawn.clear()
    gui.frame(2)
    assert flag in gui.drawn and "place of the mark" not in gui.drawn
    gui.release()


def assert_shows(gui, frame, pixel):
    """Assert that a frame shows this pixel in its middle, enlarged, from the whole picture."""
    (x0, y0, x1, y1), view = gui.drawn[frame], gui.session.pictures.view
    drawn_picture = gui.screen.picture.viewport._placed_pictures[-1]
    (left, top), (right, bottom) = drawn_picture.first, drawn_picture.last
    scale = view.viewport.framebuffer_scale
    shape = gui.screen.picture.pictures.shape
    assert right - left == pytest.approx(
        MAGNIFICATION * view.geometry.per_px[0] * shape.width_px * scale
    )
    across = ((x0 + x1) / 2 * scale - left) / (right - left) * shape.width_px
    down = ((y0 + y1) / 2 * scale - top) / (bottom - top) * shape.height_px
    assert (across, down) == pytest.approx(
        (pixel[0] + 0.5, pixel[1] + 0.5), abs=0.2
    )  # whole units of the pointer
    assert drawn_picture.texture.size == (shape.width_px, shape.height_px)


def test_loupe_lies_within_the_viewport_beside_the_pointer(gui):
    gui.do("Loupe")
    view = gui.session.pictures.view
    for pixel in ((1, 1), (94, 1), (1, 62), (94, 62), BALL):
        assert loupe_at(gui, pixel)
        x0, y0, x1, y1 = gui.drawn["loupe"]
        x, y = window_position(gui, pixel)
        assert not (x0 <= x <= x1 and y0 <= y <= y1)
        (left, top), (width, height) = view.viewport.corner, view.viewport.size
        assert left <= x0 and x1 <= left + width and top <= y0 and y1 <= top + height


def test_loupe_is_hidden_while_a_button_is_down_or_off_the_picture(gui):
    gui.do("Loupe")
    assert loupe_at(gui, SKY)
    gui.press(window_position(gui, POST))
    assert not draw_lines(gui)
    gui.release()
    assert draw_lines(gui)
    gui.move((2.0, 2.0))
    assert not draw_lines(gui)


def test_y_key_focuses_on_the_other_surface_under_the_loupe(gui):
    """Where a near blurred surface covers a far one, a click takes the near one, Y the far one."""
    session = gui.session
    session.editing.edit_lens(replace(session.facts.lens, f_stop=0.7, focus_distance_m=POST_M * 4))
    gui.rest()
    gui.do("Loupe")
    for x in range(POST[0], 96):
        lines = loupe_at(gui, (x, POST[1]))
        if len(lines) > 1:
            break
    else:
        pytest.fail("nothing near blurs over anything here")
    other = float(lines[1].removeprefix("Y: ").split()[0])
    gui.key(K.y)
    assert session.facts.lens.focus_distance_m == pytest.approx(other, rel=0.02)


def hold_ctrl(gui, is_down=True):
    """Hold Ctrl for longer than a shortcut takes, or release it."""
    for key in (K.mod_ctrl, K.left_ctrl):
        gui.hold(key, is_down)
    gui.later()


def test_loupe_shows_while_ctrl_alone_is_held(gui):
    gui.move(window_position(gui, BALL))
    hold_ctrl(gui)
    assert [line[-3:] for line in draw_lines(gui)] == [f"{BALL_M:g} m"]  # after the name of a mark
    gui.hold(K.s)
    assert draw_lines(gui) == []
    gui.hold(K.s, down=False)
    hold_ctrl(gui, is_down=False)
    assert draw_lines(gui) == []


def twigs_file(path):
    """Write twigs called hero, 5 pixels wide, before a wall called card, with gaps of 3 pixels."""
    y, x = np.mgrid[:96, :240]
    is_twig = (x >= 120) & (x % 8 >= 3)
    ids = np.where(is_twig, as_float(HERO), as_float(CARD))
    channels = {"R": x / 240, "G": y / 96, "B": x * 0, "Z": np.where(is_twig, 0.9, 3.0)}
    channels |= {"Crypto00.R": ids, "Crypto00.G": np.ones(ids.shape)}
    crypto_header = {"name": "Crypto", "hash": "MurmurHash3_32", "manifest": MANIFEST}
    header = {f"cryptomatte/abc1234/{key}": value for key, value in crypto_header.items()}
    return write_file(path, {name: v.astype("f4") for name, v in channels.items()}, **header)


def test_loupe_names_mattes_and_y_key_works_while_ctrl_is_held(gui, tmp_path):
    gui.open(twigs_file(tmp_path / "twigs.exr"))
    lens = gui.session.facts.lens
    gui.session.editing.edit_lens(replace(lens, f_stop=1.0, focus_distance_m=2.5))
    gui.rest()
    gui.move(window_position(gui, (161, 48)))
    hold_ctrl(gui)
    gui.until(lambda: draw_lines(gui) == ["hero 0.9 m", "Y: card 3 m"], "the names of the mattes")
    gui.key(K.y)
    assert gui.session.facts.lens.focus_distance_m == pytest.approx(3.0)
    hold_ctrl(gui, is_down=False)
