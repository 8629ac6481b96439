"""Which preview level is rendered: laws of the choice, for machines of every speed."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.preview.level_choice import (
    cheaper,
    level_at_rest,
    level_while_moving,
    recognisable,
)

SIZE = (1920, 1080)
WISHED = DefocusSettings(quality=Quality.FILM)
LEVELS = cheaper(WISHED)
BUDGETS = st.floats(1e-4, 1.0)


def predict(per_px_s: float):
    """Return a function that predicts seconds: this many a pixel, more at better quality."""

    def seconds(settings: DefocusSettings) -> float:
        width, height = proxy_size(SIZE, settings.proxy)
        return per_px_s * width * height * (1 + list(Quality).index(settings.quality))

    return seconds


PRICES = st.floats(1e-12, 1e-5).map(predict)


@given(PRICES, BUDGETS)
def test_while_something_moves_the_best_level_that_fits_is_taken(price, budget_s):
    found = level_while_moving(LEVELS, None, budget_s, price)
    fitting = [level for level in LEVELS if price(level) <= budget_s]
    assert found == (fitting[0] if fitting else LEVELS[-1])


@given(PRICES, BUDGETS, st.sampled_from(LEVELS), st.floats(0.8, 1.25))
def test_a_level_that_was_chosen_is_kept_while_the_time_changes_little(
    price, budget_s, held, factor
):
    settled = level_while_moving(LEVELS, held, budget_s, price)
    for _ in range(2):  # there and back: neither step may make it flicker
        after = level_while_moving(LEVELS, settled, budget_s, price)
        assert after == settled
    if price(settled) <= budget_s:
        back = level_while_moving(LEVELS, settled, budget_s * max(factor, 1 / 1.3 + 1e-9), price)
        assert LEVELS.index(back) <= LEVELS.index(settled)


@given(PRICES)
def test_a_quick_machine_goes_to_the_whole_picture_at_once(price):
    found = level_at_rest(WISHED, LEVELS[-1], True, price)
    assert found is not None
    if price(WISHED) <= 3.0:
        assert found == WISHED
    elif found != WISHED:
        assert 3.0 * price(found) < price(WISHED)


@given(PRICES)
def test_of_a_plate_that_will_be_finer_nothing_slow_is_rendered(price):
    found = level_at_rest(WISHED, LEVELS[-1], False, price)
    if found == WISHED:
        assert price(WISHED) <= 0.25


@given(st.integers(8, 4000))
def test_levels_are_large_enough_or_the_largest_there_are(width):
    found = recognisable(WISHED, (width, width))
    assert found
    small = [it for it in found if proxy_size((width, width), it.proxy)[0] < 160]
    assert not small or {it.proxy for it in found} == {LEVELS[0].proxy}
