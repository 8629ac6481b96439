"""The state of a session as JSON: it holds no objects, and is made anew only after a change."""

import json
from dataclasses import fields, is_dataclass
from enum import Enum

import pytest

from heatlens.studio.board.board import Board
from heatlens.studio.board.requests import Focus, MarkAt
from heatlens.studio.board.state import IS_OBJECT, State

HELD = [field.name for field in fields(State) if field.metadata.get(IS_OBJECT)]
# The entries that pages read, see `studio/web`; those of them that may be null.
NULL = {"hyperfocal_m", "keyed_focus_m", "timecode", "part_done", "guides", "scale"}
OF_PAGES = {"table", "guides", "scale"} | {field.name for field in fields(State)} - set(HELD)


@pytest.fixture
def board(session):
    return Board(session)


def is_plain(value):
    """Return True for a value that JSON can hold, or a record or tuple of such values."""
    if is_dataclass(value):
        return all(is_plain(getattr(value, field.name)) for field in fields(value))
    if isinstance(value, tuple):
        return all(is_plain(item) for item in value)
    return value is None or isinstance(value, bool | int | float | str | Enum)


def test_only_marked_fields_of_the_state_are_objects(board):
    board.do(MarkAt(10, 10))
    state = board.state()
    assert [it.name for it in fields(State) if not is_plain(getattr(state, it.name))] == HELD


def test_json_has_all_fields_but_the_marked_ones(board):
    entries = json.loads(json.dumps(board.json_state(), allow_nan=False))
    missing = OF_PAGES - set(entries)
    assert set(entries) <= OF_PAGES and all(getattr(board.state(), it) is None for it in missing)
    assert missing.isdisjoint(NULL) and len(entries["scale"]["heights"]) > 10


def test_state_and_its_json_are_made_again_only_after_a_change(board):
    state, entries = board.state(), board.json_state()
    assert board.state() is state and board.json_state() is entries
    board.do(Focus(3.0))
    assert board.state() != state and board.json_state()["lens"]["focus_distance_m"] == 3.0
    assert board.json_state()["scale"] is entries["scale"]  # its depths have not changed
