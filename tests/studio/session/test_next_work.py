"""What is rendered next, as a function of the state: laws that hold for every state."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.session.playing.render_scheduler import (
    NextWork,
    PlateState,
    SideState,
    Work,
    WorkState,
    is_rendering,
    next_work,
)

SECONDS = st.floats(0.0, 1.0)
PLATES = st.builds(
    PlateState, st.booleans(), st.booleans(), st.booleans(), st.booleans(), st.none() | SECONDS
)
SIDES = st.lists(
    st.builds(SideState, st.booleans(), st.booleans(), SECONDS, st.booleans()),
    min_size=1,
    max_size=2,
)
STATES = st.builds(
    WorkState, st.booleans(), PLATES, SIDES.map(tuple), st.integers(0, 1), st.none() | SECONDS
)
WHOLE = PlateState(is_there=True, is_good=True, is_whole=True, is_asked=True, wait_s=None)
DONE, BUSY = SideState(True, False, 0.0), SideState(False, True, 0.0)


@given(STATES)
def test_only_a_side_that_has_work_is_worked_on_and_only_on_a_plate_that_is_good(state):
    found = next_work(state)
    if found.work is Work.SIDE:
        side = state.sides[found.side]
        assert state.plate.is_there and (state.plate.is_good or side.is_answering)
        assert side.has_work and found.wait_s == side.wait_s


@given(STATES, st.integers(0, 1))
def test_a_change_is_answered_before_the_plate_becomes_good(state, at):
    answering = SideState(False, True, 0.0, is_answering=True)
    sides = tuple(answering if at == i else BUSY for i in range(2))
    plate = replace(state.plate, is_there=True)
    found = next_work(replace(state, plate=plate, sides=sides, plays_rendered=False))
    assert found == NextWork(Work.SIDE, 0.0, at)


@given(STATES)
def test_frames_wait_until_everything_that_is_seen_is_there(state):
    found = next_work(state)
    if is_rendering(state.plate, state.sides) and not state.plays_rendered:
        assert found.work in (Work.PLATE, Work.SIDE)
    else:
        assert found.work in (Work.NOTHING, Work.FRAMES)


@given(STATES)
def test_nothing_else_is_rendered_while_rendered_frames_are_played(state):
    assert next_work(replace(state, plays_rendered=True)) == NextWork(Work.NOTHING, None)


@given(STATES)
def test_the_turn_decides_between_sides_that_both_have_work(state):
    both = (BUSY, BUSY)
    found = next_work(replace(state, plate=WHOLE, sides=both, plays_rendered=False))
    assert found == NextWork(Work.SIDE, 0.0, state.turn)


@given(st.integers(0, 1))
def test_a_side_without_work_leaves_its_turn_to_the_other(turn):
    for sides, expected in (((BUSY, DONE), 0), ((DONE, BUSY), 1)):
        assert next_work(WorkState(False, WHOLE, sides, turn, None)).side == expected


def test_with_everything_done_there_is_nothing_to_wait_for():
    assert next_work(WorkState(False, WHOLE, (DONE,), 0, None)) == NextWork(Work.NOTHING, None)
    assert next_work(WorkState(False, WHOLE, (DONE,), 0, 0.3)) == NextWork(Work.FRAMES, 0.3)


def test_a_plate_that_nobody_asked_for_yet_is_waited_for():
    unasked = replace(WHOLE, is_asked=False)
    assert next_work(WorkState(False, unasked, (DONE,), 0, 0.0)) == NextWork(Work.PLATE, None)
