"""What pages in a browser may ask of the board, and what turns the lens."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.studio.board.board import REMOTE_FIELDS, REQUESTS, Board


@pytest.fixture
def board(session):
    return Board(session)


def test_requests_that_name_a_file_are_not_remote(board):
    remote = [name for name, kind in REQUESTS.items() if kind.is_remote]
    for name in remote:
        assert not {"path", "name", "folder"} & set(REQUESTS[name].__slots__) or name == "TakeLook"
    assert {"Open", "Save", "Export"}.isdisjoint(remote) and "Focus" in remote


def test_commands_on_files_and_sources_are_not_remote(board):
    """Commands that open, write or delete files, or choose sources, are for the window only.

    A new command has to be put into one of the two sets.
    """
    kept = {"Render frames ahead", "Clear rendered frames", "Next shot", "Previous shot"}
    kept |= {"Leave the reel", "Next quality", "Next bokeh"}
    own = {command.name for command in board.commands if command.menu == "File"}
    remote = {command.name for command in board.remote_commands}
    assert {command.name for command in board.commands} == remote | own | kept
    assert not remote & (own | kept)


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        (
            {"change": "blur", "quality": "draft", "method": "heat"},
            "A page cannot change 'method'; it can change quality.",
        ),
        ({"change": "shot"}, None),
        (
            {"change": "shot", "source": "/etc/passwd"},
            "A page cannot change 'source'; it can change lens, blur, view after 'change'.",
        ),
        (
            {"change": ["lens"], "f_stop": 2},
            "A page cannot change 'f_stop'; it can change lens, blur, view after 'change'.",
        ),
        (
            {"do": "Reload"},
            "A page has no 'Reload': files are opened and written only in the window.",
        ),
        ({"do": "Open"}, "A page has no 'Open': files are opened and written only in the window."),
        ({"do": "Fly"}, "A page has no 'Fly': files are opened and written only in the window."),
        ({"do": "Focus", "distance_m": 2.0}, None),
        ({"do": "Undo"}, None),
        ({"do": ["Undo"]}, None),
        ({}, None),
    ],
)
def test_check_refuses_with_the_sentence_what_pages_may_not_do(board, message, sentence):
    """Whatever it lets pass, such as an unknown kind of change, is for `follow` to refuse."""
    try:
        board.check_remote(message)
    except InputError as error:
        assert str(error) == sentence
    else:
        assert sentence is None


@pytest.mark.parametrize("of", REMOTE_FIELDS)
def test_pages_may_change_each_field_that_is_listed(board, of):
    now = {"lens": board.facts.lens, "blur": board.facts.shot.defocus, "view": board.facts.view}[of]
    message = {"change": of} | {name: getattr(now, name) for name in REMOTE_FIELDS[of]}
    board.check_remote(message)
    with pytest.raises(InputError, match="cannot change 'made_up'"):
        board.check_remote(message | {"made_up": 1})


def test_commands_of_the_view_need_no_right_to_change_the_shot(board):
    assert board.turns_lens({"do": "Focus"}) and board.turns_lens({"do": "Undo"})
    assert not board.turns_lens({"do": "Thirds"})
    assert board.turns_lens({"change": "lens"}) and not board.turns_lens({"change": "view"})
    assert board.turns_lens({"do": "Fly"}) and not board.turns_lens({"do": "Wipe"})


_VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8)),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)
_MESSAGES = st.dictionaries(st.sampled_from(["do", "change", "f_stop", "name", "x_px"]), _VALUES)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(_MESSAGES)
def test_check_refuses_any_wrong_object_with_a_sentence(board, message):
    try:
        board.check_remote(message)
    except InputError as error:
        assert str(error).endswith(".")
