"""Which preview level is rendered: laws of the choice, for machines of every speed."""

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.shot.settings import PROXY_MIN, DefocusSettings, Quality
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.preview.level_choice import (
    cheaper_levels,
    first_picture_settings,
    level_at_rest,
    level_while_moving,
    useful_levels,
)

SIZE = (1920, 1080)
REQUESTED = DefocusSettings(quality=Quality.FILM)
LEVELS = cheaper_levels(REQUESTED)
BUDGETS_S = st.floats(1e-4, 1.0)


def predict(per_px_s: float):
    """Return a function that predicts seconds: this many a pixel, more at better quality."""

    def seconds(settings: DefocusSettings) -> float:
        width, height = proxy_size(SIZE, settings.proxy)
        return per_px_s * width * height * (1 + list(Quality).index(settings.quality))

    return seconds


TIME_MODELS = st.floats(1e-12, 1e-5).map(predict)


@given(TIME_MODELS, BUDGETS_S)
def test_level_while_moving_is_the_best_within_the_budget(seconds_of, budget_s):
    chosen_level = level_while_moving(LEVELS, None, budget_s, seconds_of)
    fitting = [level for level in LEVELS if seconds_of(level) <= budget_s]
    assert chosen_level == (fitting[0] if fitting else LEVELS[-1])


@given(TIME_MODELS, BUDGETS_S, st.sampled_from(LEVELS), st.floats(0.8, 1.25))
def test_level_while_moving_stays_when_budget_changes_little(
    seconds_of, budget_s, previous_level, factor
):
    chosen_level = level_while_moving(LEVELS, previous_level, budget_s, seconds_of)
    for _ in range(2):  # there and back: neither step may make it flicker
        next_level = level_while_moving(LEVELS, chosen_level, budget_s, seconds_of)
        assert next_level == chosen_level
    if seconds_of(chosen_level) <= budget_s:
        level_with_other_budget = level_while_moving(
            LEVELS, chosen_level, budget_s * max(factor, 1 / 1.3 + 1e-9), seconds_of
        )
        assert LEVELS.index(level_with_other_budget) <= LEVELS.index(chosen_level)


@given(TIME_MODELS)
def test_level_at_rest_is_the_whole_picture_on_a_quick_machine(seconds_of):
    level = level_at_rest(REQUESTED, LEVELS[-1], is_plate_whole=True, predict=seconds_of)
    assert level is not None
    if seconds_of(REQUESTED) <= 3.0:
        assert level == REQUESTED
    elif level != REQUESTED:
        assert 3.0 * seconds_of(level) < seconds_of(REQUESTED)


@given(TIME_MODELS)
def test_level_at_rest_is_quick_while_the_plate_will_become_finer(seconds_of):
    level = level_at_rest(REQUESTED, LEVELS[-1], is_plate_whole=False, predict=seconds_of)
    if level == REQUESTED:
        assert seconds_of(REQUESTED) <= 0.25


@given(st.integers(8, 4000), st.booleans())
def test_recognisable_levels_are_large_enough_or_at_largest_proxy(width, is_of_scene):
    levels = useful_levels(REQUESTED, (width, width), is_of_scene)
    assert levels
    least_px = max(160, min(240, width / 5)) if is_of_scene else 160
    small_levels = [it for it in levels if proxy_size((width, width), it.proxy)[0] < least_px]
    assert not small_levels or {it.proxy for it in levels} == {LEVELS[0].proxy}


@given(st.integers(1, 16000), st.integers(1, 9000), st.floats(0.0, 4000.0))
def test_first_picture_gathers_few_samples_however_wide_the_blur(width, height, widest_px):
    """Its size follows the largest disc, down to the smallest scale that there is."""
    first = first_picture_settings(REQUESTED, (width, height), widest_px)
    pixels = width * height * first.proxy**2  # before each side becomes a whole number
    samples = pixels * (first.proxy * widest_px) ** 2
    assert proxy_size((width, height), first.proxy)[0] <= 320 or first.proxy == PROXY_MIN
    assert samples <= 2**26 * 1.0001 or first.proxy == PROXY_MIN
