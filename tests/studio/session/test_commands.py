"""Commands of a session without a window: the lens, the view, rows of keys, and what is said."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.messages import SHOWN_S, Messages, Problem
from heatlens.core.model.keys.key_rows import CAMERA, RowChoice
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.view import DIFFERENCE_GAINS, Against, Compare
from heatlens.media.plate.coc_line import focused_at
from heatlens.studio.board.session import Session
from heatlens.studio.settings.start import CommandLineOptions, Start
from support.fake_renderer import FakeRenderer


@pytest.fixture
def session() -> Iterator[Session]:
    renderer: Any = FakeRenderer()
    session = Session(renderer, Start(""))
    session.begin()
    yield session
    session.close()


def test_message_fades_after_its_reading_time():
    clock_s = [0.0]
    messages = Messages(lambda: clock_s[0])
    messages.notify("Give the ends with --near.")
    assert messages.text == "Give the ends with near." and messages.seconds_until_needed() > 0
    clock_s[0] = SHOWN_S
    messages.fade()
    assert messages.text
    clock_s[0] = SHOWN_S + 0.1
    messages.fade()
    assert not messages.text and messages.seconds_until_needed() is None


def test_message_fade_keeps_problems_only_with_keeps_problem():
    clock_s = [0.0]
    messages = Messages(lambda: clock_s[0])
    for sentence, stays in ((Problem("It cannot be read."), True), ("It is saved.", False)):
        messages.notify(sentence)
        clock_s[0] += SHOWN_S + 0.1
        messages.fade(keeps_problem=True)
        assert bool(messages.text) is stays and messages.seconds_until_needed() is None
    messages.notify(Problem("It cannot be read."))
    clock_s[0] += SHOWN_S + 0.1
    messages.fade(keeps_problem=False)
    assert not messages.text


@given(st.floats(4.0, 300.0), st.floats(0.0, 300.0))
def test_focused_at_never_focuses_within_the_focal_length(focal_mm, dioptres):
    lens = focused_at(Lens(focal_mm, 2.8, 400.0, 36.0), dioptres)
    assert lens.focus_distance_m > 1e-3 * focal_mm
    if 1e-4 < dioptres < 1 / (1.1e-3 * focal_mm):
        assert lens.focus_distance_m == pytest.approx(1 / dioptres)


def test_toggling_same_overlay_or_comparison_again_turns_it_off(session):
    view = session.pictures.commands
    for command, field, off in (
        (view.toggle_overlay, "overlay", ("zones", "depth", "none")),
        (view.toggle_compare, "compare", (Compare.WIPE, Compare.FLIP, Compare.OFF)),
    ):
        first, second, none = off
        for toggled, expected in ((first, first), (second, second), (second, none)):
            command(toggled)
            assert getattr(session.facts.view, field) == expected


def test_step_gain_walks_through_gains_and_stops_at_the_last(session):
    for _ in DIFFERENCE_GAINS:
        session.pictures.commands.step_gain(1)
    assert session.facts.view.difference_gain == DIFFERENCE_GAINS[-1]
    session.pictures.commands.step_gain(-1)
    assert session.facts.view.difference_gain == DIFFERENCE_GAINS[-2]


def test_swap_b_without_loaded_reference_changes_nothing(session):
    session.pictures.commands.compare_with(Method.GATHER)
    assert (
        session.facts.view.against is Against.METHOD and session.facts.view.compare is Compare.WIPE
    )
    before = session.facts.view
    session.pictures.commands.swap_b()
    assert session.facts.view == before and "No reference is loaded" in session.messages.text


def test_save_and_copy_are_refused_while_nothing_is_open(session):
    for key in ("save", "save shot"):
        assert (
            not session.files.commands.may_choose(key)
            and "Nothing is open" in session.messages.text
        )
    session.messages.clear()
    session.pictures.saving.copy()
    assert "Nothing is open" in session.messages.text
    assert session.files.commands.may_choose("open")


def test_row_choice_drops_camera_row_without_a_camera():
    has_camera = [True]
    rows = RowChoice(lambda: has_camera[0])
    rows.select(LensParameter.F_STOP)
    rows.select(CAMERA)
    assert rows.selected_row is CAMERA and rows.curve_parameter is LensParameter.F_STOP
    rows.toggle_curve()
    assert rows.selected_row is LensParameter.F_STOP
    rows.toggle_curve()
    has_camera[0] = False
    assert rows.selected_row is LensParameter.F_STOP


@pytest.mark.parametrize(("source", "first"), [("", "a.exr"), ("b.exr", "b.exr")])
def test_command_line_options_apply_only_to_the_first_source(source, first):
    options = CommandLineOptions(Start(source, lens={"f_stop": 1.4}))
    assert options.apply_to(first) and options.lens_of(first) == {"f_stop": 1.4}
    options.note_opened(first)
    assert options.has_opened and options.apply_to(first)
    assert not options.apply_to("c.exr") and options.lens_of("c.exr") == {}


def test_write_camera_reports_folder_that_cannot_be_made(session, tmp_path: Path):
    (tmp_path / "file").write_text("")
    wish = session.files.exports.settings.__class__(str(tmp_path / "file" / "folder"), "name")
    session.files.exports.settings = wish
    session.files.exports.write_camera()
    assert "cannot be made" in session.messages.text and session.files.exports.run.state is None
