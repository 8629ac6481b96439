"""The Plan panel: a drag focuses, a drag of the name of a mark moves the mark, all to scale."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.units import FOOT_M
from heatlens.studio.ui.panels.plan_panel import round_steps_m
from support.gui import Gui, gui_of
from support.session_files import BALL, BALL_M, QUICK, room_file


@pytest.fixture(scope="module")
def shared_gui(session_context, tmp_path_factory) -> Iterator[Gui]:
    plate = room_file(tmp_path_factory.mktemp("plan") / "room.exr")
    with gui_of(session_context, plate, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx, shared_gui) -> Gui:
    shared_gui.begin_again()
    shared_gui.session.editing.begin(replace(shared_gui.session.facts.shot, marks=()))
    imgui.set_window_focus("Marks")
    shared_gui.frame(3)
    return shared_gui


def focus_m(gui) -> float:
    return gui.session.facts.lens.focus_distance_m


def camera_and_metre(gui) -> tuple[float, float]:
    """Return the y of the camera, and screen units for a metre, from two focus distances."""
    ys = []
    for distance_m in (1.0, 2.0):
        gui.session.lens.commands.focus(distance_m)
        gui.frame(2)
        ys.append(gui.rect("focus on the plan")[1])
    return 2 * ys[0] - ys[1], ys[0] - ys[1]


def test_plan_drag_focuses_under_the_pointer_in_one_undo_step(gui):
    y0, metre = camera_and_metre(gui)
    gui.rest()
    before = len(gui.session.editing.history.past)
    x, _ = gui.middle("plan")
    gui.drag((x, y0 - 1.2 * metre), (x + 5, y0 - 1.7 * metre))
    assert focus_m(gui) == pytest.approx(1.7, abs=1.5 / metre)
    gui.rest()
    assert len(gui.session.editing.history.past) == before + 1


def test_plan_has_the_same_scale_across_and_in_depth(gui):
    _, metre = camera_and_metre(gui)
    x0, _, x1, _ = gui.rect("focus on the plan")  # at 2 m
    lens = gui.session.facts.lens
    seen_m = lens.sensor_width_mm / lens.focal_length_mm * 2.0
    assert (x1 - x0) / metre == pytest.approx(seen_m, rel=1e-4)


def test_plan_scale_stays_while_the_farthest_mark_is_dragged(gui):
    gui.session.editing.begin(
        replace(gui.session.facts.shot, marks=(DistanceMark("A", 1.5), DistanceMark("B", 2.5)))
    )
    gui.frame(3)
    y0, metre = camera_and_metre(gui)
    (x, y), top = gui.middle("B on the plan"), gui.rect("plan")[1]
    gui.drag((x, y), (x, top - 40), steps=12)
    reach_m = gui.session.facts.shot.marks[1].distance_m
    assert 2.5 < reach_m <= (y0 - top) / metre + 0.01
    y0, metre = camera_and_metre(gui)
    gui.drag(gui.middle("B on the plan"), (x, y0 - 1.9 * metre), steps=12)
    assert gui.session.facts.shot.marks[1].distance_m == pytest.approx(1.9, abs=2 / metre)


def test_plan_wheel_zooms_and_keeps_the_focus(gui):
    _, metre = camera_and_metre(gui)
    focus = focus_m(gui)
    gui.wheel(gui.middle("plan"), 2)
    assert focus_m(gui) == focus
    assert camera_and_metre(gui)[1] == pytest.approx(1.25**2 * metre, rel=1e-3)
    gui.wheel(gui.middle("plan"), -2)


def test_plan_drag_of_a_distance_mark_moves_it_and_keeps_the_focus(gui):
    marks = DistanceMark("A", 1.5), PointMark("B", *BALL)
    gui.session.editing.begin(replace(gui.session.facts.shot, marks=marks))
    y0, metre = camera_and_metre(gui)
    gui.session.editing.begin(gui.session.facts.shot)
    gui.frame(2)
    focus, (x, y) = focus_m(gui), gui.middle("A on the plan")
    assert y == pytest.approx(y0 - 1.5 * metre, abs=1.0)
    assert gui.middle("B on the plan")[1] == pytest.approx(y0 - BALL_M * metre, abs=1.0)
    gui.drag((x, y), (x + 3, y0 - 1.1 * metre))
    moved_mark, other_mark = gui.session.facts.shot.marks
    assert moved_mark.distance_m == pytest.approx(1.1, abs=1.5 / metre)
    assert other_mark == marks[1] and focus_m(gui) == focus
    gui.rest()
    assert len(gui.session.editing.history.past) == 1


@pytest.mark.parametrize(
    ("reach_m", "unit", "expected"),
    [
        (6.2, "m", [1, 2, 3, 4, 5, 6]),
        (0.9, "m", [0.2, 0.4, 0.6, 0.8]),
        (30.0, "m", [5, 10, 15, 20, 25, 30]),
        (20 * FOOT_M, "ft", [5 * FOOT_M, 10 * FOOT_M, 15 * FOOT_M, 20 * FOOT_M]),
    ],
)
def test_round_steps_of_the_plan_are_round_distances(reach_m, unit, expected):
    assert round_steps_m(reach_m, unit) == pytest.approx(expected)
