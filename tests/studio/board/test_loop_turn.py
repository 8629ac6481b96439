"""The turn of the loop that window and pages share: due frames, sleep and rendering."""

import time

import pytest

from heatlens.studio.board.loop_turn import LoopTurn
from heatlens.studio.board.session import Session


@pytest.fixture
def turn(session) -> LoopTurn:
    """Return the turn of a session that rests, with its first frame drawn."""
    turn = LoopTurn(session)
    assert draw_due_frames(turn) == 1
    return turn


def draw_due_frames(turn: LoopTurn) -> int:
    """Draw frames while some are due; return their number."""
    count = 0
    while turn.begin_due_frame():
        turn.make_frame()
        count += 1
    return count


def turn_the_lens(session: Session, turn: LoopTurn) -> None:
    """Turn the lens before its due frame; nothing is known of costs: a preview comes first."""
    session.pictures.live.cost.seconds_per_px.clear()
    session.lens.commands.focus(3.0)
    turn.note_input()
    assert turn.begin_due_frame()


def test_frames_are_due_as_often_as_they_were_requested(turn):
    assert not turn.has_due_frame and draw_due_frames(turn) == 0
    turn.note_input(3)
    turn.draw_soon(2)  # fewer than are due already
    assert turn.has_due_frame and draw_due_frames(turn) == 3


def test_loop_sleeps_until_the_earliest_need_and_not_while_a_frame_is_due(session, turn):
    own_wait_s = session.seconds_until_needed()
    assert turn.seconds_to_sleep() == own_wait_s
    assert turn.seconds_to_sleep(0.25, None) == min(0.25, own_wait_s or 0.25)
    turn.draw_soon()
    assert turn.seconds_to_sleep(0.25) == 0.0


def test_input_rests_only_after_the_frame_that_answers_it(session, turn):
    turn_the_lens(session, turn)
    shown_s = []
    turn.make_frame(show=lambda: shown_s.append(time.perf_counter()))
    assert session.pictures.live._changed_at >= shown_s[0]


def test_rendering_requests_frames_that_show_it_and_ends(session, turn):
    turn_the_lens(session, turn)
    assert turn.make_frame()  # a preview, at once
    drawn = 1
    while session.time.scheduler.is_working:
        turn.work()
        drawn += draw_due_frames(turn)
    assert drawn > 1 and session.facts.shown_picture.is_whole
    assert session.facts.shown_picture.shot == session.facts.shot
    turn.work()
    assert not turn.has_due_frame


def test_answer_is_not_begun_while_newer_input_waits(session, turn):
    turn_the_lens(session, turn)
    turn.make_frame()
    live = session.pictures.live
    live.drop_work()
    live.is_answering = True  # as after the frame that finished the answer to an older change
    turn.work(is_input_newer=True)
    assert live.is_unanswered
    turn.work()
    assert not live.is_unanswered


def test_pulse_is_due_only_while_a_picture_is_rendered(session, turn):
    assert not turn.is_pulse_due(0.0)
    turn_the_lens(session, turn)
    turn.make_frame()
    assert session.time.scheduler.is_working
    assert turn.is_pulse_due(0.0) and not turn.is_pulse_due(3600.0)


def test_frame_notes_its_time_and_whether_it_made_a_picture(session, turn):
    session.time.speed.frames_s.clear()
    turn.draw_soon()
    assert turn.begin_due_frame() and not turn.make_frame()
    assert len(session.time.speed.frames_s) == 1
