"""Find the options that were given, and refuse given options that would have no effect."""

import argparse
from collections.abc import Callable, Iterable

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.fronts.commands.options.field_options import attribute_names, unused_blur_options
from heatlens.render.source.kinds import kind_of

OptionValues = dict[str, object]
AddOptions = Callable[[argparse.ArgumentParser], object]

_PLATE_OPTIONS = attribute_names(PlateOptions)
_SCENE_OPTIONS = (
    *("size", "scene_camera", "frame", "pinhole", "overscan", "deep", "clip", "first_frame"),
    *("up_axis", "meters_per_unit"),
)


def changed_options(args: argparse.Namespace, *groups: AddOptions) -> OptionValues:
    """Return the options of `groups` that are not at their default, with their values."""
    parser = argparse.ArgumentParser()
    for add_options in groups:
        add_options(parser)
    defaults = vars(parser.parse_args([])).items()
    names = [name for name, default in defaults if getattr(args, name) != default]
    return {f"--{name.replace('_', '-')}": getattr(args, name) for name in names}


def refuse_unused_options(
    args: argparse.Namespace, source: str = "", method: Method | None = None
) -> None:
    """Raise InputError that names the given options without effect.

    `source` is "" if its kind does not matter. If `method` is None, any method may follow.
    """
    if getattr(args, "pinhole", False):
        blur = attribute_names(DefocusSettings)
        refuse_options(args, blur, "A picture without a lens has no blur")
    if method is not None:
        for why_not, names in unused_blur_options(method).items():
            refuse_options(args, names, f"The method {method} {why_not}")
    if source:
        kind = kind_of(source)
        reason = f"{source} is {kind.article_word}, but this option is for"
        if not kind.reads_plates:
            refuse_options(args, _PLATE_OPTIONS, f"{reason} plates")
        if not kind.has_camera:
            rate = ("fps",) if getattr(args, "is_rate_of_scene", False) else ()
            refuse_options(args, (*_SCENE_OPTIONS, *rate), f"{reason} 3D scenes")


def refuse_options(args: argparse.Namespace, names: Iterable[str], reason: str) -> None:
    """Raise InputError, beginning with `why`, for those of the options `names` that were given."""
    attributes = [name for name in names if getattr(args, name, None) not in (None, False)]
    if attributes:
        option_list = ", ".join(f"--{name.replace('_', '-')}" for name in attributes)
        raise InputError(f"{reason}: leave {option_list} out.")
