"""The hand in the window: focus by clicks, keys and wheel; undo goes through it."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.marks.marks import PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from support.session_files import BALL, BALL_M, HEIGHT, LENS, POST, POST_M, SKY, WIDTH

K = imgui.Key


def middle_of(pixel: tuple[int, int]) -> tuple[float, float]:
    return pixel[0] + 0.5, pixel[1] + 0.5


def focus_m(gui) -> float:
    return gui.session.facts.lens.focus_distance_m


def steps(gui) -> int:
    """Return how many steps undo could go back once the hand rests."""
    gui.rest()
    return len(gui.session.editing.history.past)


# Clicks in the picture


@pytest.mark.parametrize(("pixel", "distance_m"), [(BALL, BALL_M), (POST, POST_M), (SKY, math.inf)])
def test_a_click_focuses_on_exactly_what_is_there(gui, pixel, distance_m):
    gui.session.editing.edit_lens(replace(LENS, focus_distance_m=7.0))
    gui.rest()
    gui.click(gui.at_picture(*middle_of(pixel)))
    assert focus_m(gui) == distance_m
    assert steps(gui) == 2


def test_a_click_at_one_to_one_and_one_far_in_hit_the_same_pixel(gui):
    for zoom_action in ("1:1", "Zoom in", "Zoom in", "Zoom in"):
        gui.do(zoom_action)
        for pixel, distance_m in ((POST, POST_M), (BALL, BALL_M)):
            at = gui.at_picture(*middle_of(pixel))
            x0, y0, x1, y1 = gui.rect("picture")
            if x0 < at[0] < x1 and y0 < at[1] < y1:
                gui.click(at)
                assert focus_m(gui) == distance_m, zoom_action


def test_a_click_beside_the_picture_changes_nothing(gui):
    gui.do("1:1")
    before = gui.session.facts.shot
    for point in ((-3, 10), (WIDTH + 3, 10), (10, -3), (10, HEIGHT + 3)):
        gui.click(gui.at_picture(*point))
    assert gui.session.facts.shot == before and steps(gui) == 0
    assert gui.session.messages.text == ""


def test_a_drag_over_the_picture_follows_the_pointer_and_is_one_step(gui):
    seen = []
    gui.press(gui.at_picture(*middle_of(POST)))
    for pixel in (POST, BALL, SKY, (-20, 4), POST):
        gui.move(gui.at_picture(*middle_of(pixel)))
        seen.append(focus_m(gui))
    gui.release()
    assert seen == [POST_M, BALL_M, math.inf, math.inf, POST_M]
    assert steps(gui) == 1


def test_a_drag_that_leaves_the_picture_takes_hold_of_nothing_else(gui):
    gui.press(gui.at_picture(*middle_of(POST)))
    gui.move(gui.middle("focus bar"))
    gui.move(gui.middle("exposure"))
    gui.release()
    assert (focus_m(gui), steps(gui)) == (POST_M, 1)
    assert gui.session.facts.view.exposure_stops == 0.0


def test_what_is_nearer_than_the_focal_length_is_refused_in_a_sentence(gui):
    gui.session.editing.edit_lens(replace(LENS, focal_length_mm=950.0, focus_distance_m=5.0))
    gui.rest()
    gui.click(gui.at_picture(*middle_of(POST)))
    assert focus_m(gui) == 5.0
    assert "focal length of 950 mm" in gui.session.messages.text


@pytest.mark.parametrize("button", [1, 2], ids=["right", "middle"])
def test_other_buttons_pan_and_focus_nothing(gui, button):
    gui.do("1:1")
    before, at = gui.session.facts.shot, gui.at_picture(10, 10)
    gui.drag(at, (at[0] + 12, at[1] - 7), button)
    assert gui.session.facts.shot == before
    assert gui.at_picture(10, 10) == pytest.approx((at[0] + 12, at[1] - 7))


def test_the_wheel_zooms_about_the_pointer(gui):
    gui.do("1:1")
    at = gui.at_picture(31.5, 20.5)
    for notches in (1, 2, -1, 3, -5):
        zoom = gui.session.pictures.view.zoom
        gui.wheel(at, notches)
        assert gui.session.pictures.view.zoom == pytest.approx(zoom * 1.25**notches)
        there = gui.session.pictures.view.geometry.window_at_picture((31.5, 20.5))
        assert there == pytest.approx(at, abs=3.0)  # half a pixel for each of the roundings
    assert gui.session.facts.shot.lens == gui.session.lens.commands.start_lens.lens


# Keys and the wheel over the panel


def test_brackets_nudge_focus_along_the_bar(gui):
    def dioptres() -> float:
        return 1 / focus_m(gui)

    start = dioptres()
    gui.key(K.left_bracket)
    nearer = dioptres()
    assert nearer - start == pytest.approx(gui.session.facts.histogram.most_dioptres / 250)
    gui.key(K.right_bracket)
    gui.key(K.right_bracket)
    assert dioptres() == pytest.approx(2 * start - nearer)
    gui.key(K.left_bracket, shift=True)
    assert gui.session.facts.lens.f_stop == 0.9
    gui.key(K.right_bracket, shift=True)
    assert gui.session.facts.lens.f_stop == 1.0


def test_the_wheel_over_the_focus_bar_and_its_field_nudges_focus(gui):
    start = 1 / focus_m(gui)
    gui.wheel(gui.middle("focus bar"), 3)
    step = gui.session.facts.histogram.most_dioptres / 250
    assert 1 / focus_m(gui) == pytest.approx(start + 3 * step)
    gui.move(gui.middle("distance"))
    gui.frame()
    gui.wheel(gui.middle("distance"), -1)
    assert 1 / focus_m(gui) == pytest.approx(start + 2 * step)
    assert steps(gui) == 1
    assert gui.session.facts.view.zoom is None


def test_the_wheel_over_the_rest_of_the_lens_panel_scrolls(gui):
    before, panel = gui.session.facts.shot, imgui.internal.find_window_by_name("Lens")
    assert panel.scroll_max.y > 0
    at = gui.middle("f-stop field")
    gui.wheel(at, -3)
    gui.frame(2)
    assert panel.scroll.y > 0 and gui.session.facts.shot == before
    gui.wheel(at, 30)
    gui.frame(2)
    assert panel.scroll.y == 0


def test_the_focus_bar_lies_across_the_picture_right_under_it(gui):
    bar, place = gui.rect("focus bar"), gui.session.pictures.view.viewport
    (x, y), (width, height) = place.corner, place.size
    em = imgui.get_font_size()
    assert x < bar[0] < x + em and x + width - em < bar[2] < x + width
    assert bar[1] == y + height and 4.0 * em < bar[3] - bar[1] <= 5.5 * em


def test_words_over_the_picture_leave_while_the_focus_is_dragged(gui):
    gui.do("Near, in focus, far")
    gui.session.editing.edit(replace(gui.session.facts.shot, marks=(PointMark("A", *POST),)))
    gui.frame(2)
    words = {"legend", "point A"}
    assert words <= gui.drawn.keys()
    for name in ("focus bar", "picture"):
        x, y = gui.middle(name)
        gui.press((x, y))
        for step in range(1, 4):
            gui.move((x + 9 * step, y))
        gui.drawn.clear()
        gui.frame(2)
        assert not words & gui.drawn.keys()
        gui.release()
        assert words <= gui.drawn.keys()


def test_the_distance_at_the_pointer_stands_beside_that_of_the_focus_and_over_no_number(gui):
    x0, y0, x1, y1 = gui.rect("focus bar")
    em = imgui.get_font_size()
    for part in (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0):
        gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=4.0))
        gui.drawn.clear()
        gui.move((x0 + part * (x1 - x0), y1 - 3))
        gui.frame(30)  # any tooltip would have come
        at, focus = gui.rect("distance at the pointer"), gui.rect("focus on the bar")
        assert at[2] < focus[0] or focus[2] < at[0]
        assert y0 <= at[1] and at[3] <= y0 + 1.6 * em  # the scale lies lower
        assert not any(name.startswith("##Tooltip") for name in open_windows())


def open_windows() -> list[str]:
    return [window.name for window in imgui.get_current_context().windows if window.active]


def test_a_press_on_the_flag_of_a_mark_focuses_exactly_on_it(gui):
    gui.session.editing.edit(replace(gui.session.facts.shot, marks=()))
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=2.345678))
    gui.do("Set mark here")
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=5.0))
    gui.frame(2)
    _, y0, x1, y1 = gui.rect("A on the bar")
    gui.click((x1 - 2, (y0 + y1) / 2))
    assert focus_m(gui) == 2.345678


def test_the_focus_of_the_keys_stays_to_be_seen_while_another_is_tried(gui):
    session = gui.session
    session.editing.edit(session.facts.shot.with_key(3, LensParameter.FOCUS_DISTANCE, 3.0))
    session.editing.auto_key = False
    gui.frame(2)
    assert session.facts.keyed_focus_m is None and "keyed focus" not in gui.drawn
    gui.wheel(gui.middle("focus bar"), 5)
    gui.frame(2)
    assert session.facts.keyed_focus_m == pytest.approx(3.0)
    most = session.facts.histogram.most_dioptres
    x0, _, x1, _ = gui.rect("focus bar")
    assert gui.rect("keyed focus")[0] == pytest.approx(x1 - (x1 - x0) / 3.0 / most, abs=1.0)
    assert gui.middle("focus on the bar")[0] < gui.rect("keyed focus")[0]
    session.editing.auto_key = True


def test_shift_and_the_wheel_over_the_picture_focus_and_zoom_nothing(gui):
    start = 1 / focus_m(gui)
    gui.io.add_key_event(K.mod_shift, True)
    gui.wheel(gui.at_picture(*middle_of(POST)), 2)
    gui.io.add_key_event(K.mod_shift, False)
    gui.frame()
    step = gui.session.facts.histogram.most_dioptres / 250
    assert 1 / focus_m(gui) == pytest.approx(start + 2 * step)
    assert gui.session.facts.view.zoom is None and steps(gui) == 1


def test_undo_and_redo_go_through_every_gesture(gui):
    seen = [gui.session.facts.shot]
    gui.click(gui.at_picture(*middle_of(POST)))
    gui.rest()
    seen.append(gui.session.facts.shot)
    gui.key(K.right_bracket, shift=True)
    gui.rest()
    seen.append(gui.session.facts.shot)
    gui.do("Next bokeh")
    gui.rest()
    seen.append(gui.session.facts.shot)
    assert len({repr(shot) for shot in seen}) == 4
    for shot in reversed(seen[:-1]):
        gui.key(K.z, ctrl=True)
        assert gui.session.facts.shot == shot
    for shot in seen[1:]:
        gui.key(K.z, ctrl=True, shift=True)
        assert gui.session.facts.shot == shot
