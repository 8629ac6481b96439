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
    """Stand-in for a live picture that answers each request at once in `seconds`."""

    def __init__(self, seconds: float) -> None:
        self.output = SimpleNamespace(seconds=seconds)
        self.is_answering = False
        self.budgets: list[float] = []

    def request(self, shot: Shot, frame: int, budget_s: float, *more: Any) -> bool:
        self.budgets.append(budget_s)
        return True

    def drop_work(self) -> None:
        """Nothing is in progress."""


def request_with_budget(a_took_s: float, budget_s: float) -> tuple[list[float], list[float]]:
    """Request both sides of a comparison; return the budgets in seconds that A and B got."""
    sides = CompareSides(cast(Any, SimpleNamespace(has_many_views=False, ctx=FakeContext())))
    a, b = TimedPicture(a_took_s), TimedPicture(0.0)
    sides.a, sides.b = cast(Any, a), cast(Any, b)
    sides.request(BESIDE, SHOT, 1, budget_s)
    return a.budgets, b.budgets


@given(st.floats(0.0, 1.0), st.floats(0.001, 1.0))
def test_compare_budget_of_b_is_rest_of_a_but_at_least_a_quarter(
    a_took_s: float, budget_s: float
) -> None:
    of_a, of_b = request_with_budget(a_took_s, budget_s)
    assert of_a == [budget_s]
    assert of_b == [pytest.approx(max(budget_s - a_took_s, budget_s / 4))]


def test_compare_budget_of_b_is_a_quarter_when_a_is_slow() -> None:
    assert request_with_budget(0.5, 0.04)[1] == [pytest.approx(0.01)]
