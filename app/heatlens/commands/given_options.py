"""Find the options that were given, and refuse those that would have no effect."""

import argparse
from collections.abc import Callable, Iterable
from typing import Any

from heatlens.commands.field_options import attributes_of, unasked
from heatlens.errors import InputError
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import DefocusSettings, Method
from heatlens.source.kind import SourceKind

Given = dict[str, Any]
AddOptions = Callable[[argparse.ArgumentParser], object]

_OF_PLATES = attributes_of(PlateOptions)
_OF_SCENES = (
    *("size", "scene_camera", "frame", "pinhole", "overscan", "deep", "clip", "first_frame"),
    *("up_axis", "meters_per_unit"),
)
_OF_OTHERS = {  # by kind of source: the options that are for other kinds
    SourceKind.PLATES: (_OF_SCENES, "is a plate, and that is for 3D scenes"),
    SourceKind.SCENE: (_OF_PLATES, "is a 3D scene, and that is for plates"),
    SourceKind.STREAM: (_OF_SCENES, "is a running renderer, and that is for 3D scenes"),
}


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
    kind: SourceKind | None = None,
    method: Method | None = None,
) -> None:
    """Raise InputError that names the given options without effect.

    `kind` is the kind of `source`, None if it does not matter. If `method` is None, any method may
    be used, later or one after the other.
    """
    if getattr(args, "pinhole", False):
        blur = attributes_of(DefocusSettings)
        refuse_given(args, blur, "A picture without a lens has no blur")
    if method is not None:
        for why_not, names in unasked(method).items():
            refuse_given(args, names, f"The method {method} {why_not}")
    if kind is not None:
        others, why = _OF_OTHERS[kind]
        if kind is not SourceKind.SCENE and getattr(args, "is_rate_of_scene", False):
            others = (*others, "fps")
        refuse_given(args, others, f"{source} {why}")


def refuse_given(args: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """Raise InputError, beginning with `why`, for those of the options `names` that were given."""
    found = [name for name in names if getattr(args, name, None) not in (None, False)]
    if found:
        typed = ", ".join(f"--{name.replace('_', '-')}" for name in found)
        raise InputError(f"{why}: leave {typed} out.")
