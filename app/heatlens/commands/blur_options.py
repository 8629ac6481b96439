"""The options that say how the blur is computed, the same for every command that blurs."""

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from heatlens.commands.value_types import number, whole
from heatlens.errors import InputError
from heatlens.model.settings import (
    LAYERS_MAX,
    PROXY_MIN,
    VIEWS_MAX,
    Bokeh,
    DefocusSettings,
    Method,
    Quality,
)

_USUAL = DefocusSettings()
_RANGES = {"layers": (1, LAYERS_MAX), "proxy": (PROXY_MIN, 1), "views": (1, VIEWS_MAX)}


def add_blur_options(parser: argparse.ArgumentParser) -> None:
    """--method, --bokeh, --quality, --layers, --proxy."""
    group = parser.add_argument_group("blur", "How it is computed, never how much of it there is.")
    group.add_argument(
        "--method",
        choices=[str(method) for method in Method],
        help="diffusion (default) costs the same for every blur, as do heat, its basic form in one "
        "layer, and pyramid, blurred copies at smaller sizes; gather, which averages the disc "
        "around each pixel, and scatter, which draws each pixel as a disc, far to near, cost four "
        "times as much for twice the blur; accumulation and raytraced look at a 3D scene from "
        "--views points of the lens: the truth. All but the first are for comparison and take "
        "neither --bokeh nor --quality nor --layers",
    )
    group.add_argument(
        "--views",
        type=whole,
        metavar="N",
        help=f"points of the lens, or rays of each pixel, 1 to {VIEWS_MAX} (default 66)",
    )
    group.add_argument(
        "--bokeh",
        choices=[str(bokeh) for bokeh in Bokeh],
        help="shape of a point of light: disc as a lens (default), gaussian, or heat, "
        "the fastest, a four-pointed star",
    )
    group.add_argument(
        "--quality",
        choices=[str(quality) for quality in Quality],
        help="how closely that shape is met; the amount of blur is the same (default film)",
    )
    group.add_argument(
        "--layers",
        type=whole,
        metavar="N",
        help=f"depth layers, 1 (nothing uncovers) to {LAYERS_MAX}; default: as the quality says",
    )
    group.add_argument(
        "--proxy",
        type=number,
        metavar="SCALE",
        help=f"work on a smaller picture, {PROXY_MIN:g} to 1; blur scales with it",
    )


def settings_of(
    args: argparse.Namespace, unless_given: DefocusSettings = _USUAL
) -> DefocusSettings:
    """The blur options as a value; what is not given is as in `unless_given`.

    Raises InputError for numbers that no blur has.
    """
    kinds: dict[str, Callable[[Any], Any]] = {"method": Method, "bokeh": Bokeh, "quality": Quality}
    values: dict[str, Any] = {
        name: getattr(args, name)
        for name in (*kinds, "layers", "proxy", "views")
        if getattr(args, name, None) is not None
    }
    for name, value in values.items():
        if name in kinds:
            values[name] = kinds[name](value)
        else:
            low, high = _RANGES[name]
            _check(name, value, low, high)
    return replace(unless_given, **values)


def _check(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(f"--{name} must be {low:g} to {high:g}, got {value:g}.")
