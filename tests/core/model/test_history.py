"""Undo against a list with a place in it, for any run of gestures."""

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


def dragged(past: History, shots: list[Shot]) -> History:
    for shot in shots:
        past = past.changed(shot)
    return past


@given(GESTURES)
def test_it_is_a_list_of_gestures_with_a_place_in_it(gestures):
    steps, place = [SHOTS[0]], 0
    now = History.of(SHOTS[0])
    for gesture in gestures:
        if gesture == "undo":
            now, place = now.undone(), max(place - 1, 0)
        elif gesture == "redo":
            now, place = now.redone(), min(place + 1, len(steps) - 1)
        else:
            now = dragged(now, gesture).at_rest()
            if gesture[-1] != steps[place]:
                steps, place = [*steps[: place + 1], gesture[-1]], place + 1
        assert now.now == now.settled == steps[place]
        assert [*now.past, now.now, *reversed(now.future)] == steps


@given(GESTURES)
def test_undo_to_the_start_and_redo_to_the_end(gestures):
    now = History.of(SHOTS[0])
    for gesture in gestures:
        now = (
            now.undone()
            if gesture == "undo"
            else now.redone()
            if gesture == "redo"
            else (dragged(now, gesture).at_rest())
        )
    while now.future:
        now = now.redone()
    last, steps = now.now, len(now.past)
    for _ in range(steps):
        now = now.undone()
    assert now.now == SHOTS[0] and now.undone() == now
    for _ in range(steps):
        now = now.redone()
    assert now.now == last and now.redone() == now


def test_a_drag_is_one_step_and_one_that_comes_back_is_none():
    start = History.of(SHOTS[0])
    assert len(dragged(start, SHOTS[1:]).at_rest().past) == 1
    back = dragged(start, [SHOTS[1], SHOTS[0]]).at_rest()
    assert (back.past, back.now) == ((), SHOTS[0])


def test_undo_in_the_middle_of_a_drag_takes_back_the_drag():
    start = dragged(History.of(SHOTS[0]), [SHOTS[1]]).at_rest()
    amid = dragged(start, [SHOTS[2], SHOTS[3]])
    assert amid.undone().now == SHOTS[1]
    assert amid.undone().redone().now == SHOTS[3]


def test_a_change_that_comes_back_leaves_what_can_be_redone():
    undone = dragged(History.of(SHOTS[0]), [SHOTS[1]]).at_rest().undone()
    assert dragged(undone, [SHOTS[2], SHOTS[0]]).at_rest().redone().now == SHOTS[1]


def test_the_oldest_steps_are_forgotten(monkeypatch):
    monkeypatch.setattr(history, "_STEPS_MAX", 5)
    now = History.of(SHOTS[0])
    for i in range(1, 12):
        now = now.changed(SHOTS[i % 4]).at_rest()
    assert len(now.past) == 5
    for _ in range(9):
        now = now.undone()
    assert now.now == SHOTS[6 % 4] and len(now.future) == 5
