"""`Pace` shortens the drawing between two polls for input on slow machines."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.session.opened.scene_preview import MIN_SHARE, QUICK_S, SLOW_S, Pace

_SPEEDS = st.floats(1e-4, 2.0)  # seconds for a usual step


def step_time_after(pace: Pace, steps: int, usual_s: float) -> float:
    """Return the time in seconds of the last of `steps`, where a full step takes `usual_s`."""
    for _ in range(steps):
        pace.note_time(usual_s * pace.share)
    return usual_s * pace.share


@given(speeds=st.lists(_SPEEDS, min_size=1, max_size=5))
def test_pace_keeps_steps_short_under_any_load(speeds):
    pace = Pace()
    for usual_s in speeds:  # other programs come and go
        assert step_time_after(pace, 200, usual_s) <= SLOW_S or pace.share == MIN_SHARE


@given(usual_s=st.floats(1e-4, QUICK_S / 2.1), before_s=_SPEEDS)
def test_pace_returns_to_full_steps_on_a_free_machine(usual_s, before_s):
    pace = Pace()
    step_time_after(pace, 20, before_s)
    step_time_after(pace, 200, usual_s)
    assert pace.share == 1.0


def test_pace_ignores_single_slow_steps():
    pace = Pace()
    for _ in range(10):
        pace.note_time(1.0)  # a program was built
        pace.note_time(0.01)
    assert pace.share == 1.0


def test_pace_halves_after_two_slow_steps_and_doubles_after_32_quick():
    pace = Pace()
    pace.note_time(2 * SLOW_S)
    assert pace.share == 1.0
    pace.note_time(2 * SLOW_S)
    assert pace.share == 0.5
    for _ in range(31):
        pace.note_time(QUICK_S / 2)
    assert pace.share == 0.5
    pace.note_time(QUICK_S / 2)
    assert pace.share == 1.0
