"""`next_work` chooses what is rendered next from the state: laws that hold for every state."""

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
WHOLE_PLATE = PlateState(exists=True, is_good=True, is_whole=True, is_requested=True, wait_s=None)
DONE_SIDE, BUSY_SIDE = (
    SideState(is_finished=True, has_work=False, wait_s=0.0),
    SideState(is_finished=False, has_work=True, wait_s=0.0),
)
DONE = WorkState(
    plays_rendered=False, plate=WHOLE_PLATE, sides=(DONE_SIDE,), turn_index=0, frames_wait_s=None
)


@given(STATES)
def test_next_work_picks_only_sides_with_work_on_a_good_plate(state):
    chosen = next_work(state)
    if chosen.work is Work.SIDE:
        side = state.sides[chosen.side]
        assert state.plate.exists and (state.plate.is_good or side.is_answering)
        assert side.has_work and chosen.wait_s == side.wait_s


@given(STATES, st.integers(0, 1))
def test_next_work_answers_a_change_before_the_plate_is_good(state, at):
    answering = SideState(is_finished=False, has_work=True, wait_s=0.0, is_answering=True)
    sides = tuple(answering if at == i else BUSY_SIDE for i in range(2))
    plate = replace(state.plate, exists=True)
    chosen = next_work(replace(state, plate=plate, sides=sides, plays_rendered=False))
    assert chosen == NextWork(work=Work.SIDE, wait_s=0.0, side=at)


@given(STATES)
def test_next_work_is_the_plate_or_a_side_until_both_are_rendered(state):
    """While rendered frames play, there is nothing to render."""
    chosen = next_work(state)
    if is_rendering(state.plate, state.sides) and not state.plays_rendered:
        assert chosen.work in (Work.PLATE, Work.SIDE)
    else:
        assert chosen.work in (Work.NOTHING, Work.FRAMES)


@given(STATES)
def test_next_work_is_nothing_while_rendered_frames_play(state):
    assert next_work(replace(state, plays_rendered=True)) == NextWork(Work.NOTHING, None)


@given(STATES)
def test_next_work_picks_side_by_turn_when_both_have_work(state):
    busy_sides = (BUSY_SIDE, BUSY_SIDE)
    chosen = next_work(replace(state, plate=WHOLE_PLATE, sides=busy_sides, plays_rendered=False))
    assert chosen == NextWork(work=Work.SIDE, wait_s=0.0, side=state.turn_index)


@given(st.integers(0, 1))
def test_next_work_picks_the_other_side_when_one_is_done(turn):
    for sides, expected in (((BUSY_SIDE, DONE_SIDE), 0), ((DONE_SIDE, BUSY_SIDE), 1)):
        assert next_work(replace(DONE, sides=sides, turn_index=turn)).side == expected


def test_next_work_is_nothing_when_everything_is_done():
    assert next_work(DONE) == NextWork(Work.NOTHING, None)
    assert next_work(replace(DONE, frames_wait_s=0.3)) == NextWork(Work.FRAMES, 0.3)


def test_next_work_waits_for_a_plate_not_requested_yet():
    unrequested = replace(WHOLE_PLATE, is_requested=False)
    assert next_work(replace(DONE, plate=unrequested, frames_wait_s=0.0)) == NextWork(
        Work.PLATE, None
    )
