"""Find the options that were given, and refuse those that would have no effect."""

import argparse
from collections.abc import Callable, Iterable

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.fronts.commands.options.field_options import attributes_of, unasked
from heatlens.render.source.kinds import kind_of

Given = dict[str, object]
AddOptions = Callable[[argparse.ArgumentParser], object]

_OF_PLATES = attributes_of(PlateOptions)
_OF_SCENES = (
    *("size", "scene_camera", "frame", "pinhole", "overscan", "deep", "clip", "first_frame"),
    *("up_axis", "meters_per_unit"),
)


def given(args: argparse.Namespace, *groups: AddOptions) -> Given:
    """Return the options of `groups` that are not at their default, with their values."""
    plain = argparse.ArgumentParser()
    for add in groups:
        add(plain)
    defaults = vars(plain.parse_args([])).items()
    names = [name for name, default in defaults if getattr(args, name) != default]
    return {f"--{name.replace('_', '-')}": getattr(args, name) for name in names}


def refuse_unused(
    args: argparse.Namespace,
    source: str = "",
    method: Method | None = None,
) -> None:
    """Raise InputError that names the given options without effect.

    `source` is "" if its kind does not matter. If `method` is None, any method may follow.
    """
    if getattr(args, "pinhole", False):
        blur = attributes_of(DefocusSettings)
        refuse_given(args, blur, "A picture without a lens has no blur")
    if method is not None:
        for why_not, names in unasked(method).items():
            refuse_given(args, names, f"The method {method} {why_not}")
    if source:
        kind = kind_of(source)
        what = f"{source} is {kind.article_word}, but this option is for"
        if not kind.reads_plates:
            refuse_given(args, _OF_PLATES, f"{what} plates")
        if not kind.has_camera:
            rate = ("fps",) if getattr(args, "is_rate_of_scene", False) else ()
            refuse_given(args, (*_OF_SCENES, *rate), f"{what} 3D scenes")


def refuse_given(args: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """Raise InputError, beginning with `why`, for those of the options `names` that were given."""
    attributes = [name for name in names if getattr(args, name, None) not in (None, False)]
    if attributes:
        typed = ", ".join(f"--{name.replace('_', '-')}" for name in attributes)
        raise InputError(f"{why}: leave {typed} out.")
