"""What a page may ask: never a file, and of the rest only what is listed."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.board.board import REQUESTS, Board
from heatlens.studio.share.page_message import parsed
from heatlens.studio.share.shared import SharedSession
from support.evening import begun, settled, write_plates


@pytest.fixture
def door(tmp_path):
    session = begun(tmp_path / "preferences", write_plates(tmp_path))
    settled(session)
    yield Board(session)
    session.close()


def asked(door, *messages):
    """Return what is answered to the messages of one page."""
    shared, said = SharedSession(), []
    for message in messages:
        shared.ask("tablet 1", message, said.append)
    shared.follow(door)
    return said


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
def test_what_is_refused_gets_a_sentence_and_changes_nothing(door, message):
    before = door.state()
    (said,) = asked(door, message)
    assert said.endswith((".", "'", "missing", ")")) or " " in said
    assert door.state() == before


def test_requests_that_name_a_file_are_not_remote(door):
    remote = [name for name, kind in REQUESTS.items() if kind.is_remote]
    for name in remote:
        assert not {"path", "name"} & set(REQUESTS[name].__slots__) or name == "TakeLook"
    assert {"Open", "Save"}.isdisjoint(remote) and "Focus" in remote


def test_commands_on_files_and_sources_are_not_remote(door):
    """Those that open, write or delete files, or choose between sources, stay in the window."""
    kept = {"Render frames ahead", "Clear rendered frames", "Next shot", "Previous shot"}
    own = {command.name for command in door.commands if command.menu == "File"}
    remote = {command.name for command in door.remote_commands}
    assert {command.name for command in door.commands} == remote | own | kept
    assert not remote & (own | kept)


def test_what_is_allowed_is_done(door):
    said = asked(
        door,
        {"do": "Focus", "distance_m": 2.5},
        {"change": "lens", "f_stop": 4},
        {"do": "Set mark here"},
        {"change": "view", "exposure_stops": 1},
    )
    state = door.state()
    assert said == [] and (state.lens.focus_distance_m, state.lens.f_stop) == (2.5, 4)
    assert len(state.marks) == 1 and state.view.exposure_stops == 1


def test_two_hands_do_not_turn_at_once(door):
    shared, said = SharedSession(), []
    shared.ask("Ann (1)", {"do": "Focus", "distance_m": 2.5}, said.append)
    shared.ask("Bob (2)", {"do": "Focus", "distance_m": 9.0}, said.append)
    shared.ask("Bob (2)", {"change": "view", "gamma": 1.1}, said.append)
    shared.follow(door)
    assert door.state().lens.focus_distance_m == 2.5 and door.state().view.gamma == 1.1
    assert said == ["Ann (1) has the lens."]


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
def test_any_text_is_an_object_or_refused(text):
    try:
        assert isinstance(parsed(text), dict)
    except InputError as error:
        assert str(error).endswith(".")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(_MESSAGES)
def test_any_object_is_allowed_or_refused_in_a_sentence(door, message):
    try:
        door.check_remote(message)
    except InputError as error:
        assert str(error).endswith(".")


def test_nesting_is_limited():
    with pytest.raises(InputError):
        parsed('{"a":' + "[" * 9 + "]" * 9 + "}")
    with pytest.raises(InputError):
        parsed("[" * 100_000)
