"""What a page may ask: never a file, and of the rest only what is listed."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.session.door.door import REQUESTS, Door
from heatlens.studio.share.asked import check, parsed, shared, turns_lens
from heatlens.studio.share.shared import SharedSession
from support.evening import begun, settled, write_plates


@pytest.fixture
def door(tmp_path):
    session = begun(tmp_path / "preferences", write_plates(tmp_path))
    settled(session)
    yield Door(session)
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


def test_no_request_that_names_a_file_is_shared(door):
    allowed = [name for name in REQUESTS if _passes({"do": name})]
    for name in allowed:
        assert not {"path", "name"} & set(REQUESTS[name].__slots__) or name == "TakeLook"
    assert {"Open", "Save"}.isdisjoint(allowed) and "Focus" in allowed


def test_who_adds_a_command_says_whether_pages_have_it(door):
    """Those that open, write or delete files, or choose between sources, stay in the window."""
    kept = {"Render frames ahead", "Clear rendered frames", "Next shot", "Previous shot"}
    own = {command.name for command in door.commands if command.menu == "File"}
    assert {command.name for command in door.commands} == shared() | own | kept
    assert not shared() & (own | kept)


def _passes(message):
    try:
        check(message)
    except InputError:
        return False
    return True


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


def test_what_the_view_shows_needs_no_hand():
    assert turns_lens({"do": "Focus"}, {}) and turns_lens({"do": "Undo"}, {"Undo": "Edit"})
    assert not turns_lens({"do": "Thirds"}, {"Thirds": "View"})


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


@given(_MESSAGES)
def test_any_object_is_allowed_or_refused_in_a_sentence(message):
    try:
        check(message)
    except InputError as error:
        assert str(error).endswith(".")


def test_nesting_is_limited():
    with pytest.raises(InputError):
        parsed('{"a":' + "[" * 9 + "]" * 9 + "}")
    with pytest.raises(InputError):
        parsed("[" * 100_000)
