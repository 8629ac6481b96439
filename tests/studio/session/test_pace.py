"""However slow the machine, what is drawn between two looks for input becomes short."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.studio.session.opened.scene_preview import LEAST, MOST_S, QUICK_S, Pace

_SPEEDS = st.floats(1e-4, 2.0)  # seconds for a usual step


def after(pace: Pace, steps: int, usual_s: float) -> float:
    """Return the time of the last of so many steps on a machine with this speed."""
    for _ in range(steps):
        pace.took(usual_s * pace.share)
    return usual_s * pace.share


@given(speeds=st.lists(_SPEEDS, min_size=1, max_size=5))
def test_steps_fit_between_two_looks_for_input_whatever_the_load_becomes(speeds):
    pace = Pace()
    for usual_s in speeds:  # other programs come and go
        assert after(pace, 200, usual_s) <= MOST_S or pace.share == LEAST


@given(usual_s=st.floats(1e-4, QUICK_S / 2.1), before_s=_SPEEDS)
def test_a_machine_that_is_free_again_draws_as_much_as_before(usual_s, before_s):
    pace = Pace()
    after(pace, 20, before_s)
    after(pace, 200, usual_s)
    assert pace.share == 1.0


def test_one_slow_step_changes_nothing():
    pace = Pace()
    for _ in range(10):
        pace.took(1.0)  # a program was built
        pace.took(0.01)
    assert pace.share == 1.0


def test_two_slow_steps_in_a_row_halve_and_many_quick_ones_double():
    pace = Pace()
    pace.took(2 * MOST_S)
    assert pace.share == 1.0
    pace.took(2 * MOST_S)
    assert pace.share == 0.5
    for _ in range(31):
        pace.took(QUICK_S / 2)
    assert pace.share == 0.5
    pace.took(QUICK_S / 2)
    assert pace.share == 1.0
