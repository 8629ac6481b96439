"""The user's own keys: read from keys.json, given to the commands, and reported where wrong."""

import json

import pytest

from heatlens.studio.board.board import Board
from heatlens.studio.board.user_keys import NAMED_KEYS


def board_with(walls, keys: object) -> Board:
    """Return a board that finds this beside the preferences."""
    text = keys if isinstance(keys, str) else json.dumps(keys)
    path = walls.preferences.path.with_name("keys.json")
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    return Board(walls)


def keys_of(board: Board) -> dict[str, str]:
    return {command.name: command.key for command in board.with_commands_of(())}


def test_a_command_has_the_key_of_the_file_and_the_others_keep_theirs(walls):
    usual = keys_of(Board(walls))
    board = board_with(walls, {"Undo": "Ctrl+Y", "Copy picture": "", "Fit": "F1"})
    changed = {"Undo": "Ctrl+Y", "Copy picture": "", "Fit": "F1"}
    assert keys_of(board) == usual | changed
    assert not walls.messages.text


def test_a_command_that_loses_its_key_is_named(walls):
    board = board_with(walls, {"Grid of looks": "W"})
    assert keys_of(board)["Grid of looks"] == "W" and keys_of(board)["Wipe"] == ""
    assert "W means 'Grid of looks' now, and no longer 'Wipe'" in walls.messages.text


def test_two_commands_swap_their_keys(walls):
    keys = keys_of(board_with(walls, {"Wipe": "X", "Flip to B": "W"}))
    assert (keys["Wipe"], keys["Flip to B"]) == ("X", "W") and not walls.messages.text


def test_an_unknown_command_is_named_and_changes_no_key(walls):
    usual = keys_of(Board(walls))
    assert keys_of(board_with(walls, {"Fly": "W"})) == usual
    assert "there is no command 'Fly'" in walls.messages.text


@pytest.mark.parametrize(
    "wrong",
    [
        *({"Undo": "Alt+Z"}, {"Undo": "Strg+Z"}, {"Undo": "z"}, {"Undo": 3}, {"Undo": "Ctrl+"}),
        *({"Undo": "Ctrl+Y", "Redo": "Ctrl+Y"}, ["Undo"], "{"),
    ],
)
def test_a_wrong_file_is_one_sentence_and_the_usual_keys(walls, wrong):
    usual = keys_of(Board(walls))
    board = board_with(walls, wrong)
    said = walls.messages.text
    assert keys_of(board) == usual
    assert "keys.json" in said and said.endswith("The usual keys are used.")


def test_every_named_key_can_be_given(walls):
    for key in NAMED_KEYS:
        assert keys_of(board_with(walls, {"Undo": key}))["Undo"] == key
