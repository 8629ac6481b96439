"""The facts of a session as JSON: all that pages read, and made anew only after a change."""

import json
import re
from pathlib import Path

import pytest

import heatlens
from heatlens.studio.board.board import Board
from heatlens.studio.board.requests import Focus, MarkAt
from support.evening import run_loop_once, run_until_settled

WEB = Path(heatlens.__file__).parent / "studio/web"
NULL = {"hyperfocal_m", "keyed_focus_m", "timecode", "part_done", "guides", "scale"}


@pytest.fixture
def board(session):
    return Board(session)


def entries_that_pages_read() -> set[str]:
    """Return the entries of the state that the scripts of the page name."""
    text = "".join(path.read_text(encoding="utf-8") for path in sorted(WEB.glob("*.js")))
    unpacked = ", ".join(re.findall(r"{ ([a-z_, ]+) } = (?:link\.)?state;", text))
    main = (WEB / "main.js").read_text(encoding="utf-8")  # where `now` is the state
    named = re.findall(r"\bstate\.([a-z_]+)", text) + re.findall(r"\bnow\.([a-z_]+)", main)
    return {*named, *unpacked.split(", ")}


def test_json_has_what_pages_read(board):
    board.do(MarkAt(10, 10))
    entries = json.loads(json.dumps(board.json_state(), allow_nan=False))
    read = entries_that_pages_read()
    assert len(read) > 18 and read <= set(entries), read - set(entries)
    assert set(entries) >= NULL and len(entries["scale"]["heights"]) > 10


def test_json_is_made_again_only_after_a_change(board):
    facts, entries = board.facts, board.json_state()
    assert board.facts is facts and board.json_state() is entries
    board.do(Focus(3.0))
    assert board.facts != facts and board.json_state()["lens"]["focus_distance_m"] == 3.0
    assert board.json_state()["scale"] is entries["scale"]  # its depths have not changed


def test_page_messages_name_no_keys_that_a_tablet_lacks(session):
    board = Board(session)
    for message, expected in (
        ("Mark A is set. Shift+M pulls the focus from mark to mark.", "Mark A is set."),
        ("Ctrl+Shift+click on the thing.", ""),
        ("Saved /a/b.json.", "Saved /a/b.json."),
    ):
        session.messages.notify(message)
        run_loop_once(session)
        assert board.json_state()["message"] == expected and board.facts.message == message


def test_lens_number_changes_with_lens_and_frame_and_the_picture_follows(session):
    board = Board(session)
    number = board.json_state()["lens_number"]
    assert board.facts.shows_lens and board.json_state()["lens_number"] == number
    board.do(Focus(3.0))
    assert board.json_state()["lens_number"] == number + 1 and not board.facts.shows_lens
    run_until_settled(session)
    assert board.facts.shows_lens and board.json_state()["lens_number"] == number + 1
