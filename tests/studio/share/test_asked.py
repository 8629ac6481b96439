"""Messages that a shared page may send: no access to files, and only the listed commands."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.board.board import Board
from heatlens.studio.share.page_message import parsed
from heatlens.studio.share.shared import SharedSession
from support.evening import begin_session, run_until_settled, write_plates


@pytest.fixture
def board(tmp_path):
    session = begin_session(tmp_path / "preferences", write_plates(tmp_path))
    run_until_settled(session)
    yield Board(session)
    session.close()


def answers_to(board, *messages):
    """Send messages of one page to the session; return the answers."""
    shared, answers = SharedSession(), []
    for message in messages:
        shared.queue_message("tablet 1", message, answers.append)
    shared.follow_messages(board)
    return answers


@pytest.mark.parametrize(
    "message",
    [
        {"do": "Open", "name": "/etc/passwd"},
        {"do": "Save", "path": "x.exr"},
        {"do": "Open the demo"},
        {"do": "Reload"},
        {"do": "Copy picture"},
        {"do": "Clear rendered frames"},
        {"do": "Render frames ahead"},
        {"do": "Next shot"},
        {"do": "Previous shot"},
        {"do": "Fly"},
        {"change": "lens", "image": "/etc/passwd"},
        {"change": "lens", "sensor_width_mm": 20},
        {"change": "view", "input_space": "ACEScg"},
        {"change": ["lens"], "f_stop": 2},
        {"change": "shot", "source": "/etc/passwd"},
        {"do": ["Open"], "name": "a"},
        {"write": "x"},
        {"do": "Focus"},
        {"do": "Focus", "distance_m": "near"},
    ],
)
def test_refused_page_message_is_answered_and_changes_nothing(board, message):
    before = board.facts
    (answer,) = answers_to(board, message)
    assert answer.endswith((".", "'", "missing", ")")) or " " in answer
    assert board.facts == before


def test_allowed_page_messages_change_lens_marks_and_view(board):
    answers = answers_to(
        board,
        {"do": "Focus", "distance_m": 2.5},
        {"change": "lens", "f_stop": 4},
        {"do": "Set mark here"},
        {"change": "view", "exposure_stops": 1},
    )
    state = board.facts
    assert answers == [] and (state.lens.focus_distance_m, state.lens.f_stop) == (2.5, 4)
    assert len(state.marks) == 1 and state.view.exposure_stops == 1


def test_second_page_cannot_turn_the_lens_while_the_first_holds_it(board):
    shared, answers = SharedSession(), []
    shared.queue_message("Ann (1)", {"do": "Focus", "distance_m": 2.5}, answers.append)
    shared.queue_message("Bob (2)", {"do": "Focus", "distance_m": 9.0}, answers.append)
    shared.queue_message("Bob (2)", {"change": "view", "gamma": 1.1}, answers.append)
    shared.follow_messages(board)
    assert board.facts.lens.focus_distance_m == 2.5 and board.facts.view.gamma == 1.1
    assert answers == ["Ann (1) moves the lens: wait a moment."]


_VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8)),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)


@given(
    st.one_of(st.text(), _VALUES.map(json.dumps), st.binary().map(lambda b: b.decode("latin-1")))
)
def test_parsed_returns_an_object_or_refuses_any_text(text):
    try:
        assert isinstance(parsed(text), dict)
    except InputError as error:
        assert str(error).endswith(".")


def test_parsed_refuses_deep_nesting():
    with pytest.raises(InputError):
        parsed('{"a":' + "[" * 9 + "]" * 9 + "}")
    with pytest.raises(InputError):
        parsed("[" * 100_000)
