"""How the time for an answer is shared between A and the picture that it is compared with."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.studio.session.pictures.compare_sides import CompareSides
from support.fake_renderer import FakeContext

SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0))
BESIDE = ViewState(compare=Compare.WIPE, against=Against.METHOD, b_method=Method.GATHER)


class TimedPicture:
    """Answers each request at once and tells how long that took."""

    def __init__(self, seconds: float) -> None:
        self.shown = SimpleNamespace(seconds=seconds)
        self.is_answering = False
        self.budgets: list[float] = []

    def request(self, shot: Shot, frame: int, budget_s: float, *more: Any) -> bool:
        self.budgets.append(budget_s)
        return True

    def pause(self) -> None:
        """Nothing is in progress."""


def shared(a_took_s: float, budget_s: float) -> tuple[list[float], list[float]]:
    """Return the budgets of A and of B."""
    sides = CompareSides(cast(Any, SimpleNamespace(has_many_views=False, ctx=FakeContext())))
    a, b = TimedPicture(a_took_s), TimedPicture(0.0)
    sides.a, sides.b = cast(Any, a), cast(Any, b)
    sides.request(BESIDE, SHOT, 1, budget_s)
    return a.budgets, b.budgets


@given(st.floats(0.0, 1.0), st.floats(0.001, 1.0))
def test_b_gets_what_a_left_but_at_least_a_quarter(a_took_s: float, budget_s: float) -> None:
    of_a, of_b = shared(a_took_s, budget_s)
    assert of_a == [budget_s]
    assert of_b == [pytest.approx(max(budget_s - a_took_s, budget_s / 4))]


def test_a_slow_a_leaves_b_a_quarter_of_the_time() -> None:
    assert shared(0.5, 0.04)[1] == [pytest.approx(0.01)]
