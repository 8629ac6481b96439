"""Tool rows of the timeline: tools that do not fit are in a popup, and all key rows are visible."""

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.ui.timeline.tool_row import Tool, highest_fitting_rank
from support.gui import Gui
from support.timeline_window import reset_window, type_into

SPACING, MORE_BUTTON_WIDTH = 8.0, 30.0
KEYED = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP, LensParameter.FOCAL_LENGTH
ROWS = [f"row {parameter}" for parameter in KEYED]


def draw_nothing() -> None:
    """Draw nothing, since the tests only use the widths of the tools."""


TOOLS = st.lists(
    st.builds(
        Tool,
        st.just(draw_nothing),
        st.floats(1.0, 200.0),
        st.integers(0, 6),
        st.sampled_from((None, 2.0)),
        st.booleans(),
        st.booleans(),
    ),
    min_size=1,
    max_size=12,
).filter(lambda tools: not all(tool.is_rare for tool in tools))


def width(tools: list[Tool], rank: int) -> float:
    """Return the width of a row of the tools up to `rank`, with the button for the others."""
    shown_tools = [tool for tool in tools if tool.rank <= rank and not tool.is_rare]
    has_more = any((tool.rank > rank or tool.is_rare) and not tool.is_word for tool in tools)
    gaps = sum(SPACING if tool.gap is None else tool.gap for tool in shown_tools[1:])
    return sum(tool.width for tool in shown_tools) + gaps + MORE_BUTTON_WIDTH * has_more


@given(TOOLS, st.floats(0.0, 2000.0))
def test_highest_fitting_rank_shows_as_many_tools_as_fit(
    tools: list[Tool], row_width: float
) -> None:
    last_rank = highest_fitting_rank(tools, row_width, SPACING, MORE_BUTTON_WIDTH)
    ranks = sorted({tool.rank for tool in tools if not tool.is_rare})
    assert width(tools, last_rank) <= row_width or last_rank == ranks[0]
    assert all(width(tools, rank) > row_width for rank in ranks if rank > last_rank)


@pytest.fixture
def gui(ctx, film) -> Iterator[Gui]:
    gui = reset_window(film)
    lens, frame, shot = gui.session.facts.lens, gui.session.facts.frame, gui.session.facts.shot
    for parameter in KEYED:
        shot = shot.with_key(frame, parameter, getattr(lens, parameter))
    gui.session.editing.begin(shot)
    gui.frame(2)
    yield gui
    film.session.preferences.change(ui_scales={})
    film.frame(4)


def set_scale(gui: Gui, scale: float) -> None:
    gui.session.preferences.change(ui_scales={"": scale})
    gui.frame(6)
    gui.drawn.clear()
    gui.frame(2)


@pytest.mark.parametrize("scale", [1.0, 1.25, 1.5, 2.0])
def test_timeline_shows_every_key_row_below_two_rows_of_controls(gui: Gui, scale: float) -> None:
    gui.session.preferences.change(keep_frames=False)
    set_scale(gui, scale)
    window = imgui.internal.find_window_by_name("Timeline")
    for name in ("transport forwards", "frame", "set key", "auto key", *ROWS):
        x0, y0, x1, y1 = gui.rect(name)
        assert window.work_rect.min.x <= x0 and x1 <= window.work_rect.max.x, name
        assert window.inner_rect.min.y <= y0 and y1 <= window.inner_rect.max.y, name
    controls, keys = gui.rect("transport forwards")[1], gui.rect("set key")[1]
    assert gui.rect("timeline ruler")[1] == pytest.approx(keys + (keys - controls), abs=1)
    assert keys - controls < 2 * (gui.rect("set key")[3] - keys)
    picture = imgui.internal.find_window_by_name("Picture").size
    assert picture.x > 0.5 * gui.size[0] and picture.y > 0.35 * gui.size[1]


def test_tools_that_do_not_fit_are_behind_the_more_button(gui: Gui) -> None:
    set_scale(gui, 2.0)
    assert not {"frames per second", "interpolation", "ease in"} & gui.drawn.keys()
    gui.click(gui.middle("more transport"))
    type_into(gui, "frames per second", "25")
    assert gui.session.facts.shot.frames_per_second == 25.0
    gui.key(imgui.Key.escape)
    gui.frame(2)
    gui.click(gui.middle("more keys"))
    gui.frame(2)
    assert {"interpolation", "ease in", "ease out"} <= gui.drawn.keys()
    gui.key(imgui.Key.escape)


def test_low_timeline_scrolls_to_its_last_row(gui: Gui) -> None:
    set_scale(gui, 3.0)
    window = imgui.internal.find_window_by_name("Timeline")
    assert gui.rect(ROWS[-1])[3] > window.inner_rect.max.y
    imgui.internal.set_scroll_y(window, 1e4)
    gui.frame(3)
    assert gui.rect(ROWS[-1])[3] <= window.inner_rect.max.y
