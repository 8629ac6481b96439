"""Focus in the window by clicks, keys and wheel, and its undo steps."""

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


# Clicks in the picture


@pytest.mark.parametrize(("pixel", "distance_m"), [(BALL, BALL_M), (POST, POST_M), (SKY, math.inf)])
def test_click_focuses_at_the_depth_of_the_pixel(gui, pixel, distance_m):
    gui.session.editing.edit_lens(replace(LENS, focus_distance_m=7.0))
    gui.rest()
    gui.click(gui.at_picture(*middle_of(pixel)))
    assert focus_m(gui) == distance_m
    assert gui.undo_count() == 2


def test_click_hits_the_same_pixel_at_every_zoom(gui):
    for zoom_action in ("1:1", "Zoom in", "Zoom in", "Zoom in"):
        gui.do(zoom_action)
        for pixel, distance_m in ((POST, POST_M), (BALL, BALL_M)):
            position = gui.at_picture(*middle_of(pixel))
            x0, y0, x1, y1 = gui.rect("picture")
            if x0 < position[0] < x1 and y0 < position[1] < y1:
                gui.click(position)
                assert focus_m(gui) == distance_m, zoom_action


def test_click_beside_the_picture_changes_nothing(gui):
    gui.do("1:1")
    before = gui.session.facts.shot
    for point in ((-3, 10), (WIDTH + 3, 10), (10, -3), (10, HEIGHT + 3)):
        gui.click(gui.at_picture(*point))
    assert gui.session.facts.shot == before and gui.undo_count() == 0
    assert gui.session.messages.text == ""


def test_picture_drag_focuses_under_the_pointer_in_one_undo_step(gui):
    distances_m = []
    gui.press(gui.at_picture(*middle_of(POST)))
    for pixel in (POST, BALL, SKY, (-20, 4), POST):
        gui.move(gui.at_picture(*middle_of(pixel)))
        distances_m.append(focus_m(gui))
    gui.release()
    assert distances_m == [POST_M, BALL_M, math.inf, math.inf, POST_M]
    assert gui.undo_count() == 1


def test_drag_that_leaves_the_picture_changes_no_other_control(gui):
    imgui.set_window_focus("Display")
    gui.frame(2)
    gui.press(gui.at_picture(*middle_of(POST)))
    gui.move(gui.middle("focus bar"))
    gui.move(gui.middle("exposure"))
    gui.release()
    assert (focus_m(gui), gui.undo_count()) == (POST_M, 1)
    assert gui.session.facts.view.exposure_stops == 0.0


def test_click_nearer_than_the_focal_length_is_refused_and_reported(gui):
    gui.session.editing.edit_lens(replace(LENS, focal_length_mm=950.0, focus_distance_m=5.0))
    gui.rest()
    gui.click(gui.at_picture(*middle_of(POST)))
    assert focus_m(gui) == 5.0
    assert "focal length of 950 mm" in gui.session.messages.text


@pytest.mark.parametrize("button", [1, 2], ids=["right", "middle"])
def test_right_and_middle_drag_pan_without_focusing(gui, button):
    gui.do("1:1")
    before, position = gui.session.facts.shot, gui.at_picture(10, 10)
    gui.drag(position, (position[0] + 12, position[1] - 7), button)
    assert gui.session.facts.shot == before
    assert gui.at_picture(10, 10) == pytest.approx((position[0] + 12, position[1] - 7))


def test_wheel_zooms_about_the_pointer(gui):
    gui.do("1:1")
    position = gui.at_picture(31.5, 20.5)
    for notches in (1, 2, -1, 3, -5):
        zoom = gui.session.pictures.view.zoom
        gui.wheel(position, notches)
        assert gui.session.pictures.view.zoom == pytest.approx(zoom * 1.25**notches)
        position_after = gui.session.pictures.view.geometry.window_at_picture((31.5, 20.5))
        assert position_after == pytest.approx(
            position, abs=3.0
        )  # half a pixel for each of the roundings
    assert gui.session.facts.shot.lens == gui.session.lens.commands.start_lens.lens


# Keys and the wheel over the panel


def test_bracket_keys_nudge_focus_and_with_shift_the_f_stop(gui):
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


def test_wheel_over_the_focus_bar_or_its_field_nudges_focus(gui):
    start = 1 / focus_m(gui)
    gui.wheel(gui.middle("focus bar"), 3)
    step = gui.session.facts.histogram.most_dioptres / 250
    assert 1 / focus_m(gui) == pytest.approx(start + 3 * step)
    gui.move(gui.middle("distance"))
    gui.frame()
    gui.wheel(gui.middle("distance"), -1)
    assert 1 / focus_m(gui) == pytest.approx(start + 2 * step)
    assert gui.undo_count() == 1
    assert gui.session.facts.view.zoom is None


def test_wheel_over_the_lens_panel_scrolls_it(gui):
    before, panel = gui.session.facts.shot, imgui.internal.find_window_by_name("Lens")
    gui.unfolded("Rendering", "method")
    gui.unfolded("opening", "blades")
    assert panel.scroll_max.y > 0
    position = gui.middle("f-stop field")
    gui.wheel(position, -3)
    gui.frame(2)
    assert panel.scroll.y > 0 and gui.session.facts.shot == before
    gui.wheel(position, 30)
    gui.frame(2)
    assert panel.scroll.y == 0


def test_focus_bar_lies_directly_under_the_picture(gui):
    bar, viewport = gui.rect("focus bar"), gui.session.pictures.view.viewport
    (x, y), (width, height) = viewport.corner, viewport.size
    em = imgui.get_font_size()
    assert x < bar[0] < x + em and x + width - em < bar[2] < x + width
    assert bar[1] == y + height and 4.0 * em < bar[3] - bar[1] <= 5.5 * em


def test_words_over_the_picture_are_hidden_during_a_focus_drag(gui):
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


def test_pointer_distance_on_the_focus_bar_covers_no_other_number(gui):
    x0, y0, x1, y1 = gui.rect("focus bar")
    em = imgui.get_font_size()
    for fraction in (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0):
        gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=4.0))
        gui.drawn.clear()
        gui.move((x0 + fraction * (x1 - x0), y1 - 3))
        gui.frame(30)  # any tooltip would have come
        pointer_label = gui.rect("distance at the pointer")
        focus_label = gui.rect("focus on the bar")
        assert pointer_label[2] < focus_label[0] or focus_label[2] < pointer_label[0]
        assert y0 <= pointer_label[1] and pointer_label[3] <= y0 + 1.6 * em  # the scale lies lower
        assert not any(name.startswith("##Tooltip") for name in open_windows())


def open_windows() -> list[str]:
    return [window.name for window in imgui.get_current_context().windows if window.active]


def test_click_on_the_flag_of_a_mark_focuses_exactly_on_it(gui):
    gui.session.editing.edit(replace(gui.session.facts.shot, marks=()))
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=2.345678))
    gui.do("Set mark here")
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=5.0))
    gui.frame(2)
    _, y0, x1, y1 = gui.rect("A on the bar")
    gui.click((x1 - 2, (y0 + y1) / 2))
    assert focus_m(gui) == 2.345678


def test_keyed_focus_stays_visible_while_another_is_tried(gui):
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


def test_shift_wheel_over_the_picture_focuses_without_zooming(gui):
    start = 1 / focus_m(gui)
    gui.io.add_key_event(K.mod_shift, True)
    gui.wheel(gui.at_picture(*middle_of(POST)), 2)
    gui.io.add_key_event(K.mod_shift, False)
    gui.frame()
    step = gui.session.facts.histogram.most_dioptres / 250
    assert 1 / focus_m(gui) == pytest.approx(start + 2 * step)
    assert gui.session.facts.view.zoom is None and gui.undo_count() == 1


def test_undo_and_redo_step_through_every_gesture(gui):
    shots = [gui.session.facts.shot]
    gui.click(gui.at_picture(*middle_of(POST)))
    gui.rest()
    shots.append(gui.session.facts.shot)
    gui.key(K.right_bracket, shift=True)
    gui.rest()
    shots.append(gui.session.facts.shot)
    gui.do("Next bokeh")
    gui.rest()
    shots.append(gui.session.facts.shot)
    assert len({repr(shot) for shot in shots}) == 4
    for shot in reversed(shots[:-1]):
        gui.key(K.z, ctrl=True)
        assert gui.session.facts.shot == shot
    for shot in shots[1:]:
        gui.key(K.z, ctrl=True, shift=True)
        assert gui.session.facts.shot == shot


# The focus bar and the readout


@pytest.mark.parametrize("distance_m", [0.3, 0.9, 2.0, 50.0, math.inf])
def test_focus_bar_shows_both_limits_wherever_the_needle_is(gui, distance_m):
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=distance_m))
    gui.frame(2)
    x0, _, x1, _ = gui.rect("focus bar")
    left, _, right, _ = gui.rect("sharp range on the bar")
    figure_left, _, figure_right, _ = gui.rect("focus on the bar")
    assert x0 - 1 <= left < figure_left < figure_right < right <= x1 + 1


def test_readout_of_a_pixel_in_focus_has_no_negative_zero(gui):
    gui.session.editing.edit_lens(
        replace(gui.session.facts.lens, focus_distance_m=BALL_M * (1 + 1e-6))
    )
    gui.settled()
    gui.move(gui.at_picture(*middle_of(BALL)))
    gui.frame(2)
    words = gui.screen.status.words(gui.screen.picture.hovered_px)
    assert "blur +0.00 px" in words


@pytest.mark.parametrize("focus_distance_m", [0.3, 0.9, 50.0])
@pytest.mark.parametrize("share", [0.001, 0.3, 0.5, 0.999])
def test_distance_at_the_pointer_lies_on_the_bar_beside_the_other_figures(
    gui, focus_distance_m, share
):
    gui.session.editing.edit_lens(
        replace(gui.session.facts.lens, focus_distance_m=focus_distance_m)
    )
    gui.frame(2)
    x0, y0, x1, y1 = gui.rect("focus bar")
    gui.move((x0 + share * (x1 - x0), (y0 + y1) / 2))
    gui.frame(2)
    left, _, right, _ = gui.rect("distance at the pointer")
    figures_left, _, figures_right, _ = gui.rect("sharp range on the bar")
    assert x0 - 1 <= left and right <= x1 + 1
    assert right <= figures_left or figures_right <= left
