"""The board alone drives a session: values and JSON in, plain values out, no window anywhere."""

import json
from dataclasses import FrozenInstanceError, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.shot.settings import Quality
from heatlens.core.model.view.view import Compare
from heatlens.studio.board.board import REQUESTS, Board
from heatlens.studio.board.facts import FactsReader
from heatlens.studio.board.requests import Focus, FocusAt, Go, MarkAt, Open, Pull, Save, TakeLook
from support.evening import FIRST, begin_session, run_loop_once, run_until_settled, write_plates
from support.watched_calls import watch_calls


@pytest.fixture
def session(tmp_path):
    session = begin_session(tmp_path / "preferences")
    yield session
    session.close()


@pytest.fixture
def board(session, tmp_path):
    board = Board(session)
    board.do(Open(write_plates(tmp_path)))
    run_until_settled(session)
    return board


def commands(board):
    return {command.name: command for command in board.command_states()}


def test_board_makes_and_saves_a_focus_pull(session, board, tmp_path):
    first = board.facts
    assert first.shot.source.endswith("walls.####.exr") and first.played.first < first.played.last
    assert first.size_px is not None and first.is_whole and first.near_m < first.far_m
    board.do(FocusAt(1, 1))
    near = board.facts.lens.focus_distance_m
    width, height = first.size_px
    board.do(MarkAt(width - 2, height - 2))
    run_until_settled(session)
    (mark,) = board.facts.marks
    assert mark.distance_m is not None and mark.distance_m != near
    board.do(Pull(mark.name, 2))
    board.do(Go(first.played.first + 2))
    run_until_settled(session)
    assert board.facts.lens.focus_distance_m == pytest.approx(mark.distance_m)
    assert board.facts.title.endswith("*")
    board.do(Save(str(tmp_path / "walls.shot"), "save shot"))
    run_until_settled(session)
    assert (tmp_path / "walls.shot").is_file() and not board.facts.title.endswith("*")


def test_board_picture_number_changes_only_with_the_picture(session, board):
    before = board.facts.picture
    assert board.facts.picture == before
    board.do(Focus(board.facts.lens.focus_distance_m / 2))
    run_until_settled(session)
    assert board.facts.picture > before


def test_board_runs_named_commands_and_reports_their_state(board):
    assert commands(board)["Undo"].barred
    before = board.facts.lens
    board.do("Open 1/3 stop")
    run_loop_once(board._session)
    assert board.facts.lens.f_stop < before.f_stop
    assert not commands(board)["Undo"].barred and commands(board)["Undo"].is_on is None
    board.do("Undo")
    assert board.facts.lens == before
    assert commands(board)["Depth of field"].is_on
    board.do("Depth of field")
    assert not commands(board)["Depth of field"].is_on and not board.facts.view.depth_of_field


def test_facts_stay_as_they_were_and_the_same_until_the_turn_has_others(session, board):
    before, shot = board.facts, session.editing.shot
    assert board.facts is before
    with pytest.raises(FrozenInstanceError):
        before.frame = 3
    session.editing.edit_lens(replace(before.lens, f_stop=4.0))  # as a panel does
    assert board.facts.lens.f_stop == 4.0 and before.lens == shot.lens
    session.time.timeline.go_to(FIRST + 1)
    assert (board.facts.frame, before.frame) == (FIRST + 1, FIRST)
    run_until_settled(session)
    rest = board.facts
    run_loop_once(session)
    assert board.facts is rest and rest.is_whole


def test_facts_are_read_once_for_a_shot_that_equals_the_one_before(session, board, monkeypatch):
    before, reads = board.facts, watch_calls(monkeypatch, FactsReader, "read")
    session.editing.amend(lambda shot: replace(shot))
    assert session.editing.shot is not before.shot and board.facts is before
    assert board.facts is before and len(reads) == 1


def test_two_changes_in_one_turn_both_last(session, board):
    lens, blur = board.facts.lens, board.facts.shot.defocus
    board.change(replace(lens, f_stop=4.0))
    board.change(replace(blur, quality=Quality.DRAFT))
    board.change(replace(board.facts.lens, focal_length_mm=35.0))
    shot = session.editing.shot
    assert (shot.lens.f_stop, shot.lens.focal_length_mm) == (4.0, 35.0)
    assert shot.defocus.quality is Quality.DRAFT and board.facts == session.facts


def test_command_that_is_as_before_keeps_the_object_of_its_state(board):
    before = commands(board)
    board.do("Auto key")
    after = commands(board)
    changed = {name for name, state in after.items() if state is not before[name]}
    assert "Auto key" in changed and after["Auto key"].is_on is not before["Auto key"].is_on
    assert all(after[name] != before[name] for name in changed)


def test_board_answer_in_json_agrees_with_state_values(board):
    answer = board.answer({"do": "Focus", "distance_m": 3.5})
    assert answer["state"]["lens"]["focus_distance_m"] == 3.5
    answer = board.answer({"change": "lens", "f_stop": 2, "focal_length_mm": 35})
    assert (answer["state"]["lens"]["f_stop"], answer["state"]["lens"]["focal_length_mm"]) == (
        2,
        35,
    )
    answer = board.answer({"change": "blur", "quality": "draft"})
    assert (
        board.facts.shot.defocus.quality is Quality.DRAFT
        and answer["state"]["blur"]["quality"] == "draft"
    )
    assert board.answer({"change": "view", "exposure_stops": 1.5})["state"]["view"]
    assert board.facts.view.exposure_stops == 1.5
    assert json.loads(json.dumps(board.answer({}))) == board.answer({})


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ([1], ["braces"]),
        ({"do": "Fly"}, ["'Fly'"]),
        ({"do": 3}, ["do", "text"]),
        ({"do": "Undo", "times": 2}, ["'times'"]),
        ({"do": "Undo"}, ["nothing to undo"]),
        ({"do": "Focus"}, ["'distance_m'", "missing"]),
        ({"do": "Focus", "distance_m": "near"}, ["distance_m", "number"]),
        ({"do": "Focus", "distance_m": -1}, ["distance"]),
        ({"do": "Pull", "mark": "Z", "frames": 3}, ["'Z'"]),
        ({"do": "TakeLook", "name": "Z"}, ["'Z'"]),
        ({"do": "Save", "path": "a.exr", "what": "all"}, ["what", "sheet"]),
        ({"change": "weather"}, ["lens", "blur", "view"]),
        ({"change": "lens", "f_stop": 0}, ["f-stop"]),
        ({"change": "lens", "fstop": 2}, ["f_stop"]),
        ({"change": "view", "unit": 5}, ["unit"]),
        ({"undo": True}, ["'do'"]),
    ],
)
def test_board_answers_wrong_message_with_problem_and_changes_nothing(board, message, words):
    before = board._session.facts.shot
    answer = board.answer(message)
    assert set(answer) == {"problem"} and all(word in answer["problem"] for word in words)
    assert board._session.facts.shot == before


_LEAVES = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=6))
_VALUES = st.recursive(_LEAVES, lambda inner: st.lists(inner, max_size=3), max_leaves=4)


def test_board_answers_any_message_with_state_or_problem(session, board):
    """Each random message gets a state or a problem; no exception leaves `answer`."""
    request_names = [
        name for name in REQUESTS if name not in ("Open", "Save")
    ]  # which touch the disk
    names = st.sampled_from([*request_names, "Undo", "Next frame"]) | st.text(max_size=8)
    entries = st.sampled_from(["distance_m", "frame", "x_px", "y_px", "f_stop", "zoom", "quality"])
    message = st.one_of(
        _VALUES,
        st.dictionaries(entries, _VALUES, max_size=3).flatmap(
            lambda more: st.one_of(
                names.map(lambda name: {**more, "do": name}),
                st.sampled_from(["lens", "blur", "view"]).map(lambda of: {**more, "change": of}),
            )
        ),
    )

    @given(message)
    def check_answer(message):
        assert set(board.answer(message)) in ({"state"}, {"problem"})

    check_answer()
    run_loop_once(session)
    assert board.facts.lens is not None


def test_take_look_restores_lens_by_the_name_of_the_look(board):
    board.do("Keep this look")
    before = board.facts
    board.do(Focus(1.25))
    board.do(TakeLook(before.shot.looks[0].name))
    assert board.facts.lens == before.lens
    assert board.facts.view.compare is Compare.OFF
    board.do("Grid of looks")
    assert board.facts.view.compare is Compare.GRID
    board.do(TakeLook(before.shot.looks[0].name))
    assert board.facts.view.compare is Compare.OFF
    board.do(TakeLook("none"))
    assert board.facts.is_problem and "none" in board.facts.message


def test_take_look_leaves_a_wipe_as_it_is(board):
    board.do("Keep this look")
    board.do("Wipe")
    board.do(TakeLook(board.facts.shot.looks[0].name))
    assert board.facts.view.compare is Compare.WIPE


def test_pull_goes_from_the_focus_of_now_to_the_named_mark_in_its_frames(session, board):
    """The window would offer the first mark, off all marks."""
    for at in ((8, 16), (40, 16)):
        board.do(MarkAt(*at))
    run_until_settled(session)
    first = board.facts.played.first
    board.do(Focus(5.0))
    board.do(Pull("B", 4))
    distances_m = []
    for frame in (first, first + 4, first + 9):
        board.do(Go(frame))
        distances_m.append(board.facts.lens.focus_distance_m)
    assert distances_m == pytest.approx([5.0, 8.0, 8.0])
    board.do(Pull("B", 0))
    assert board.facts.message == "A pull must last at least 1 frame, not 0."


def test_next_shot_of_a_reel_steps_by_one_and_previous_back(session, monkeypatch):
    steps = []
    monkeypatch.setattr(session.files.reel, "step", steps.append)
    monkeypatch.setattr(type(session.files.reel), "why_not", "")
    board = Board(session)
    for name in ("Next shot", "Previous shot"):
        board.do(name)
    assert steps == [1, -1]
