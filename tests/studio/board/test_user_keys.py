"""The user's own keys: read from keys.json, given to the commands, and reported where wrong."""

import json

import pytest

from heatlens.studio.board.board import Board
from heatlens.studio.board.user_keys import NAMED_KEYS


def board_with(session, keys: object) -> Board:
    """Return a board that finds this beside the preferences."""
    text = keys if isinstance(keys, str) else json.dumps(keys)
    path = session.preferences.path.with_name("keys.json")
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    return Board(session)


def keys_of(board: Board) -> dict[str, str]:
    return {command.name: command.key for command in board.with_commands_of(())}


def test_a_command_has_the_key_of_the_file_and_the_others_keep_theirs(session):
    usual = keys_of(Board(session))
    board = board_with(session, {"Undo": "Ctrl+Y", "Copy picture": "", "Fit": "F1"})
    changed = {"Undo": "Ctrl+Y", "Copy picture": "", "Fit": "F1"}
    assert keys_of(board) == usual | changed
    assert not session.messages.text


def test_a_command_that_loses_its_key_is_named(session):
    board = board_with(session, {"Grid of looks": "W"})
    assert keys_of(board)["Grid of looks"] == "W" and keys_of(board)["Wipe"] == ""
    assert "W means 'Grid of looks' now, and no longer 'Wipe'" in session.messages.text


def test_two_commands_swap_their_keys(session):
    keys = keys_of(board_with(session, {"Wipe": "X", "Show B": "W"}))
    assert (keys["Wipe"], keys["Show B"]) == ("X", "W") and not session.messages.text


def test_an_unknown_command_is_named_and_changes_no_key(session):
    usual = keys_of(Board(session))
    assert keys_of(board_with(session, {"Fly": "W"})) == usual
    assert "there is no command 'Fly'" in session.messages.text


@pytest.mark.parametrize(
    "wrong",
    [
        *({"Undo": "Alt+Z"}, {"Undo": "Strg+Z"}, {"Undo": "z"}, {"Undo": 3}, {"Undo": "Ctrl+"}),
        *({"Undo": "Ctrl+Y", "Redo": "Ctrl+Y"}, ["Undo"], "{"),
    ],
)
def test_a_wrong_file_is_one_sentence_and_the_usual_keys(session, wrong):
    usual = keys_of(Board(session))
    board = board_with(session, wrong)
    said = session.messages.text
    assert keys_of(board) == usual
    assert "keys.json" in said and said.endswith("The usual keys are used.")


def test_every_named_key_can_be_given(session):
    for key in NAMED_KEYS:
        assert keys_of(board_with(session, {"Undo": key}))["Undo"] == key
