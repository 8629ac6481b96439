"""Commands of a session without a window: the lens, the view, rows of keys, and what is said."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.view import DIFFERENCE_GAINS, Against, Compare
from heatlens.media.plate.coc_line import focused_at
from heatlens.studio.session.keys.key_rows import CAMERA, RowChoice
from heatlens.studio.session.messages import SHOWN_S, Messages, Problem
from heatlens.studio.session.session import Session
from heatlens.studio.session.shot.start import GivenOptions, Start
from support.fake_renderer import FakeRenderer


@pytest.fixture
def session() -> Iterator[Session]:
    renderer: Any = FakeRenderer()
    session = Session(renderer, Start(""))
    session.begin()
    yield session
    session.close()


def test_a_sentence_stays_as_long_as_it_takes_to_read_it():
    now = [0.0]
    messages = Messages(lambda: now[0])
    messages.say("Give the ends with --near.")
    assert messages.text == "Give the ends with near." and messages.seconds_until_needed() > 0
    now[0] = SHOWN_S
    messages.fade()
    assert messages.text
    now[0] = SHOWN_S + 0.1
    messages.fade()
    assert not messages.text and messages.seconds_until_needed() is None


def test_a_problem_stays_where_it_is_kept_and_good_news_do_not():
    now = [0.0]
    messages = Messages(lambda: now[0])
    for sentence, stays in ((Problem("It cannot be read."), True), ("It is saved.", False)):
        messages.say(sentence)
        now[0] += SHOWN_S + 0.1
        messages.fade(keeps_problem=True)
        assert bool(messages.text) is stays and messages.seconds_until_needed() is None
    messages.say(Problem("It cannot be read."))
    now[0] += SHOWN_S + 0.1
    messages.fade(keeps_problem=False)
    assert not messages.text


@given(st.floats(4.0, 300.0), st.floats(0.0, 300.0))
def test_focus_in_dioptres_is_never_within_the_focal_length(focal_mm, dioptres):
    lens = focused_at(Lens(focal_mm, 2.8, 400.0, 36.0), dioptres)
    assert lens.focus_distance_m > 1e-3 * focal_mm
    if 1e-4 < dioptres < 1 / (1.1e-3 * focal_mm):
        assert lens.focus_distance_m == pytest.approx(1 / dioptres)


def test_one_thing_is_compared_at_a_time_and_the_same_again_is_none(session):
    view = session.pictures.commands
    for command, field, off in (
        (view.toggle_overlay, "overlay", ("zones", "depth", "none")),
        (view.toggle_compare, "compare", (Compare.WIPE, Compare.FLIP, Compare.OFF)),
    ):
        first, second, none = off
        for toggled, expected in ((first, first), (second, second), (second, none)):
            command(toggled)
            assert getattr(session.facts.view, field) == expected


def test_gains_go_from_one_to_the_next_and_stay_at_the_ends(session):
    for _ in DIFFERENCE_GAINS:
        session.pictures.commands.step_gain(1)
    assert session.facts.view.difference_gain == DIFFERENCE_GAINS[-1]
    session.pictures.commands.step_gain(-1)
    assert session.facts.view.difference_gain == DIFFERENCE_GAINS[-2]


def test_b_is_no_reference_while_none_is_loaded(session):
    session.pictures.commands.compare_with(Method.GATHER)
    assert (
        session.facts.view.against is Against.METHOD and session.facts.view.compare is Compare.WIPE
    )
    before = session.facts.view
    session.pictures.commands.swap_b()
    assert session.facts.view == before and "No reference is loaded" in session.messages.text


def test_what_is_not_open_can_neither_be_saved_nor_copied(session):
    for key in ("save", "save shot"):
        assert (
            not session.files.commands.may_choose(key)
            and "Nothing is open" in session.messages.text
        )
    session.messages.clear()
    session.pictures.saving.copy()
    assert "Nothing is open" in session.messages.text
    assert session.files.commands.may_choose("open")


def test_the_cameras_row_is_chosen_only_where_it_is_seen():
    has_camera = [True]
    rows = RowChoice(lambda: has_camera[0])
    rows.choose(LensParameter.F_STOP)
    rows.choose(CAMERA)
    assert rows.chosen is CAMERA and rows.curve_of is LensParameter.F_STOP
    rows.toggle_curve()
    assert rows.chosen is LensParameter.F_STOP
    rows.toggle_curve()
    has_camera[0] = False
    assert rows.chosen is LensParameter.F_STOP


@pytest.mark.parametrize(("source", "first"), [("", "a.exr"), ("b.exr", "b.exr")])
def test_options_of_the_command_line_are_for_one_source(source, first):
    given = GivenOptions(Start(source, lens={"f_stop": 1.4}))
    assert given.are_for(first) and given.lens_of(first) == {"f_stop": 1.4}
    given.opened(first)
    assert given.has_opened and given.are_for(first)
    assert not given.are_for("c.exr") and given.lens_of("c.exr") == {}


def test_an_export_that_cannot_be_made_is_said(session, tmp_path: Path):
    (tmp_path / "file").write_text("")
    wish = session.files.exports.settings.__class__(str(tmp_path / "file" / "folder"), "name")
    session.files.exports.settings = wish
    session.files.exports.write_camera()
    assert "cannot be made" in session.messages.text and session.files.exports.run.state is None
