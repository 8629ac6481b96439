"""Choose the preview level to render, with pure functions of the settings and predicted times.

They know nothing of the renderer, and give the same answers for the same numbers.
"""

from collections.abc import Callable

from heatlens.defocus.plate_passes import proxy_size
from heatlens.model.settings import DefocusSettings
from heatlens.preview.levels import cheaper, is_better, on_the_way

Predict = Callable[[DefocusSettings], float]  # seconds that a picture takes

# Hysteresis, as parts of the time budget: change to a better level below the first number, and to
# a cheaper one above the second.
_KEEP = 0.7, 1.3
_LEAST_WIDTH_PX = 160  # least width of a preview
# The whole picture follows directly if it takes no longer than this,
_PATIENCE_S = 3.0
# or than this if the plate itself will soon be refined,
_SOON_S = 0.25
# or if an intermediate preview is less than this many times faster.
_FAST_ENOUGH = 3.0


def recognisable(requested: DefocusSettings, size: tuple[int, int]) -> list[DefocusSettings]:
    """Return the preview levels that are large enough to be useful for a plate of this size.

    For a plate that is small itself, return the levels of the largest size.
    """
    levels = cheaper(requested)
    large = [it for it in levels if proxy_size(size, it.proxy)[0] >= _LEAST_WIDTH_PX]
    return large or [it for it in levels if it.proxy == levels[0].proxy]


def level_while_moving(
    levels: list[DefocusSettings],
    held: DefocusSettings | None,
    budget_s: float,
    predict: Predict,
) -> DefocusSettings:
    """Return the best of `levels`, which are sorted from best to fastest, that fits the budget.

    The previous level `held` is kept while it fits approximately, so that the picture does not
    flicker between two levels.
    """
    fitting = [level for level in levels if predict(level) <= budget_s]
    best = fitting[0] if fitting else levels[-1]
    if held is None or held not in levels:
        return best
    if levels.index(best) < levels.index(held):
        return best if predict(best) <= _KEEP[0] * budget_s else held
    return best if predict(held) > _KEEP[1] * budget_s else held


def level_at_rest(
    requested: DefocusSettings,
    shown: DefocusSettings | None,
    is_plate_whole: bool,
    predict: Predict,
) -> DefocusSettings | None:
    """Return the settings to render after the shown preview: the whole picture or a better preview.

    If the plate will soon be refined, return only settings that are fast to render, or None.
    """
    whole_s = predict(requested)
    patience_s = _PATIENCE_S if is_plate_whole else _SOON_S
    if whole_s <= patience_s and not requested.method.needs_scene:
        return requested
    for level in on_the_way(requested):
        is_step_up = shown is None or is_better(level, shown, requested)
        if is_step_up and predict(level) * _FAST_ENOUGH < whole_s:
            return level
    return requested if is_plate_whole or requested.method.needs_scene else None
