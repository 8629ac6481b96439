"""Which options somebody gave, and which of these have no effect: those are refused."""

import argparse
from collections.abc import Callable, Iterable
from typing import Any

from heatlens.errors import InputError
from heatlens.model.settings import Method

Given = dict[str, Any]
AddOptions = Callable[[argparse.ArgumentParser], object]

_OF_DIFFUSION = ("bokeh", "quality", "layers")
_OF_BLUR = ("method", *_OF_DIFFUSION, "views", "proxy")
_OF_PLATES = (
    *("depth_channel", "color_layer", "depth_convention", "depth_kind", "scene_unit"),
    *("near", "far", "eye", "strict", "depth", "picture_curve"),
)
_OF_SCENES = ("size", "scene_camera", "frame", "pinhole")


def given(args: argparse.Namespace, *groups: AddOptions) -> Given:
    """Those options of `groups` that are not at their default: as they are typed, and the value."""
    plain = argparse.ArgumentParser()
    for add in groups:
        add(plain)
    defaults = vars(plain.parse_args([])).items()
    names = [name for name, default in defaults if getattr(args, name) != default]
    return {f"--{name.replace('_', '-')}": getattr(args, name) for name in names}


def refuse_unused(
    args: argparse.Namespace,
    source: str = "",
    is_scene: bool | None = None,
    method: Method | None = None,
) -> None:
    """InputError naming the options that were given and would change nothing.

    `is_scene` None: it does not matter whether `source` is one. `method` None: any may be asked
    for, later or one after the other.
    """
    if getattr(args, "pinhole", False):
        refuse_given(args, _OF_BLUR, "A picture without a lens has no blur")
    if method is not None and method is not Method.DIFFUSION:
        refuse_given(
            args, _OF_DIFFUSION, f"The method {method} has no such choice, only diffusion has"
        )
    if method is not None and not method.needs_scene:
        refuse_given(args, ("views",), f"The method {method} looks from one point alone")
    if is_scene is True:
        refuse_given(args, _OF_PLATES, f"{source} is a 3D scene, and that is for plates")
    if is_scene is False:
        refuse_given(args, _OF_SCENES, f"{source} is a plate, and that is for 3D scenes")


def refuse_given(args: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """InputError, beginning with `why`, for those of the options `names` that were given."""
    found = [name for name in names if getattr(args, name, None) not in (None, False)]
    if found:
        typed = ", ".join(f"--{name.replace('_', '-')}" for name in found)
        raise InputError(f"{why}: leave {typed} out.")
