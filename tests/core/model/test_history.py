"""Compare undo and redo with a plain list and a position in it, for any sequence of gestures."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot import history
from heatlens.core.model.shot.history import History
from heatlens.core.model.shot.shot import Shot

SHOTS = [Shot(Lens(50.0, f_stop, 2.0, 36.0)) for f_stop in (2.0, 2.8, 4.0, 5.6)]
GESTURES = st.lists(
    st.one_of(
        st.lists(st.sampled_from(SHOTS), min_size=1, max_size=4),  # a drag through these
        st.sampled_from(["undo", "redo"]),
    ),
    max_size=30,
)


def drag_through(past: History, shots: list[Shot]) -> History:
    for shot in shots:
        past = past.with_current(shot)
    return past


@given(GESTURES)
def test_history_agrees_with_list_model_after_any_gestures(gestures):
    steps, position = [SHOTS[0]], 0
    history_now = History.of(SHOTS[0])
    for gesture in gestures:
        if gesture == "undo":
            history_now, position = history_now.undo(), max(position - 1, 0)
        elif gesture == "redo":
            history_now, position = history_now.redo(), min(position + 1, len(steps) - 1)
        else:
            history_now = drag_through(history_now, gesture).end_gesture()
            if gesture[-1] != steps[position]:
                steps, position = [*steps[: position + 1], gesture[-1]], position + 1
        assert history_now.current == history_now.last_step == steps[position]
        assert [*history_now.past, history_now.current, *reversed(history_now.future)] == steps


@given(GESTURES)
def test_undo_reaches_first_shot_and_redo_reaches_last(gestures):
    history_now = History.of(SHOTS[0])
    for gesture in gestures:
        history_now = (
            history_now.undo()
            if gesture == "undo"
            else history_now.redo()
            if gesture == "redo"
            else (drag_through(history_now, gesture).end_gesture())
        )
    while history_now.future:
        history_now = history_now.redo()
    last, steps = history_now.current, len(history_now.past)
    for _ in range(steps):
        history_now = history_now.undo()
    assert history_now.current == SHOTS[0] and history_now.undo() == history_now
    for _ in range(steps):
        history_now = history_now.redo()
    assert history_now.current == last and history_now.redo() == history_now


def test_drag_is_one_undo_step_and_none_if_it_returns():
    start = History.of(SHOTS[0])
    assert len(drag_through(start, SHOTS[1:]).end_gesture().past) == 1
    unchanged = drag_through(start, [SHOTS[1], SHOTS[0]]).end_gesture()
    assert (unchanged.past, unchanged.current) == ((), SHOTS[0])


def test_undo_during_drag_undoes_the_whole_drag():
    start = drag_through(History.of(SHOTS[0]), [SHOTS[1]]).end_gesture()
    during_drag = drag_through(start, [SHOTS[2], SHOTS[3]])
    assert during_drag.undo().current == SHOTS[1]
    assert during_drag.undo().redo().current == SHOTS[3]


def test_drag_that_returns_keeps_redo_steps():
    undone = drag_through(History.of(SHOTS[0]), [SHOTS[1]]).end_gesture().undo()
    assert drag_through(undone, [SHOTS[2], SHOTS[0]]).end_gesture().redo().current == SHOTS[1]


def test_history_drops_oldest_steps_beyond_maximum(monkeypatch):
    monkeypatch.setattr(history, "_STEPS_MAX", 5)
    history_now = History.of(SHOTS[0])
    for i in range(1, 12):
        history_now = history_now.with_current(SHOTS[i % 4]).end_gesture()
    assert len(history_now.past) == 5
    for _ in range(9):
        history_now = history_now.undo()
    assert history_now.current == SHOTS[6 % 4] and len(history_now.future) == 5
