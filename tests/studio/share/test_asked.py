"""Messages that a shared page may send: no access to files, and only the listed commands."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.board.board import REQUESTS, Board
from heatlens.studio.share.page_message import parsed
from heatlens.studio.share.shared import SharedSession
from support.evening import begin_session, run_until_settled, write_plates


@pytest.fixture
def door(tmp_path):
    session = begin_session(tmp_path / "preferences", write_plates(tmp_path))
    run_until_settled(session)
    yield Board(session)
    session.close()


def answers_to(door, *messages):
    """Send messages of one page to the session; return the answers."""
    shared, answers = SharedSession(), []
    for message in messages:
        shared.queue_message("tablet 1", message, answers.append)
    shared.follow_messages(door)
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
def test_refused_page_message_is_answered_and_changes_nothing(door, message):
    before = door.state()
    (answer,) = answers_to(door, message)
    assert answer.endswith((".", "'", "missing", ")")) or " " in answer
    assert door.state() == before


def test_requests_that_name_a_file_are_not_remote(door):
    remote = [name for name, kind in REQUESTS.items() if kind.is_remote]
    for name in remote:
        assert not {"path", "name"} & set(REQUESTS[name].__slots__) or name == "TakeLook"
    assert {"Open", "Save"}.isdisjoint(remote) and "Focus" in remote


def test_commands_on_files_and_sources_are_not_remote(door):
    """Commands that open, write or delete files, or choose sources, are for the window only.

    A new command has to be put into one of the two sets.
    """
    kept = {"Render frames ahead", "Clear rendered frames", "Next shot", "Previous shot"}
    own = {command.name for command in door.commands if command.menu == "File"}
    remote = {command.name for command in door.remote_commands}
    assert {command.name for command in door.commands} == remote | own | kept
    assert not remote & (own | kept)


def test_allowed_page_messages_change_lens_marks_and_view(door):
    answers = answers_to(
        door,
        {"do": "Focus", "distance_m": 2.5},
        {"change": "lens", "f_stop": 4},
        {"do": "Set mark here"},
        {"change": "view", "exposure_stops": 1},
    )
    state = door.state()
    assert answers == [] and (state.lens.focus_distance_m, state.lens.f_stop) == (2.5, 4)
    assert len(state.marks) == 1 and state.view.exposure_stops == 1


def test_second_page_cannot_turn_the_lens_while_the_first_holds_it(door):
    shared, answers = SharedSession(), []
    shared.queue_message("Ann (1)", {"do": "Focus", "distance_m": 2.5}, answers.append)
    shared.queue_message("Bob (2)", {"do": "Focus", "distance_m": 9.0}, answers.append)
    shared.queue_message("Bob (2)", {"change": "view", "gamma": 1.1}, answers.append)
    shared.follow_messages(door)
    assert door.state().lens.focus_distance_m == 2.5 and door.state().view.gamma == 1.1
    assert answers == ["Ann (1) has the lens."]


def test_commands_of_the_view_need_no_hand(door):
    assert door.turns_lens({"do": "Focus"}) and door.turns_lens({"do": "Undo"})
    assert not door.turns_lens({"do": "Thirds"})


_VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8)),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)
_MESSAGES = st.dictionaries(st.sampled_from(["do", "change", "f_stop", "name", "x_px"]), _VALUES)


@given(
    st.one_of(st.text(), _VALUES.map(json.dumps), st.binary().map(lambda b: b.decode("latin-1")))
)
def test_parsed_returns_an_object_or_refuses_any_text(text):
    try:
        assert isinstance(parsed(text), dict)
    except InputError as error:
        assert str(error).endswith(".")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(_MESSAGES)
def test_check_refuses_any_wrong_object_with_a_sentence(door, message):
    try:
        door.check_remote(message)
    except InputError as error:
        assert str(error).endswith(".")


def test_parsed_refuses_deep_nesting():
    with pytest.raises(InputError):
        parsed('{"a":' + "[" * 9 + "]" * 9 + "}")
    with pytest.raises(InputError):
        parsed("[" * 100_000)
