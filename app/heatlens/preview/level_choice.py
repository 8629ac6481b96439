"""Which preview level to render: pure functions of what is wished, what is shown and what it costs.

They ask a prediction for seconds and know no renderer: the same answers for the same numbers.
"""

from collections.abc import Callable

from heatlens.defocus.plate_passes import proxy_size
from heatlens.model.settings import DefocusSettings
from heatlens.preview.levels import cheaper, is_better, on_the_way

Predict = Callable[[DefocusSettings], float]  # seconds that a picture takes

_KEEP = 0.7, 1.3  # hysteresis: a better level below so much of the time, a cheaper one above
_LEAST_WIDTH_PX = 160  # of a preview
_PATIENCE_S = 3.0  # the whole picture follows directly where it takes no longer than this,
_SOON_S = 0.25  # no longer than this where the plate itself will soon be finer,
_FAST_ENOUGH = 3.0  # or where a preview between them is not so many times as quick


def recognisable(wished: DefocusSettings, size: tuple[int, int]) -> list[DefocusSettings]:
    """Return the levels of a plate of this size that are large enough to tell anything.

    Of a plate that is small itself these are the largest ones.
    """
    levels = cheaper(wished)
    large = [it for it in levels if proxy_size(size, it.proxy)[0] >= _LEAST_WIDTH_PX]
    return large or [it for it in levels if it.proxy == levels[0].proxy]


def level_while_moving(
    levels: list[DefocusSettings],
    held: DefocusSettings | None,
    budget_s: float,
    predict: Predict,
) -> DefocusSettings:
    """Return the best of `levels`, the best one first, that fits the time.

    `held`, the one before, is kept while it about fits, so that the picture does not flicker
    between two levels.
    """
    fitting = [level for level in levels if predict(level) <= budget_s]
    best = fitting[0] if fitting else levels[-1]
    if held is None or held not in levels:
        return best
    if levels.index(best) < levels.index(held):
        return best if predict(best) <= _KEEP[0] * budget_s else held
    return best if predict(held) > _KEEP[1] * budget_s else held


def level_at_rest(
    wished: DefocusSettings,
    shown: DefocusSettings | None,
    is_plate_whole: bool,
    predict: Predict,
) -> DefocusSettings | None:
    """Return what follows the preview that is shown: the whole picture, or a better one before it.

    Of a plate that will soon be finer only what comes soon is rendered, which may be nothing.
    """
    whole_s = predict(wished)
    patience_s = _PATIENCE_S if is_plate_whole else _SOON_S
    if whole_s <= patience_s and not wished.method.needs_scene:
        return wished
    for level in on_the_way(wished):
        is_step_up = shown is None or is_better(level, shown, wished)
        if is_step_up and predict(level) * _FAST_ENOUGH < whole_s:
            return level
    return wished if is_plate_whole or wished.method.needs_scene else None
