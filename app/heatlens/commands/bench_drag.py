"""`heatlens bench --drag`: its options, and the picture that is dragged."""

import argparse
from dataclasses import replace
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.commands.options.given_options import given
from heatlens.commands.options.lens_options import add_lens_options, lens_of
from heatlens.commands.options.plate_options import add_plate_options, plate_options
from heatlens.commands.output.plate_words import say_plate
from heatlens.measure.bench.drag import level_words
from heatlens.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.model.lens import Lens
from heatlens.model.settings import PROXY_MIN, DefocusSettings
from heatlens.plate.plate import Plate
from heatlens.plate.read import read_plate
from heatlens.preview.levels import cheaper

Size = tuple[int, int]
Dragged = tuple[Plate, Lens, DefocusSettings]


def add_drag_options(parser: argparse.ArgumentParser, group: "argparse._ArgumentGroup") -> None:
    """Add --drag and --plate to `group`, and the options of the plate and its lens to `parser`."""
    group.add_argument(
        "--drag",
        action="store_true",
        help="instead of passes, measure what you see while dragging a control: for each preview "
        "level of the window, pictures per second and FLIP to the picture at rest, as they look "
        "on the screen at 1:1; FLIP needs pip install 'heatlens[compare]'",
    )
    group.add_argument(
        "--plate",
        type=Path,
        metavar="FILE",
        help="with --drag: an EXR with colour and depth instead of the generated scene; "
        "--size then scales it down (default: its own size)",
    )
    add_lens_options(parser)
    add_plate_options(parser)


def check_drag(args: argparse.Namespace) -> None:
    """Raise InputError for options that would have no effect."""
    if args.plate is None:
        names = given(args, add_lens_options, add_plate_options)
        if names:
            raise InputError(f"{', '.join(names)} needs --plate: give both.")
    elif not args.drag:
        raise InputError("--plate is used only by --drag: give both.")


def dragged(args: argparse.Namespace, settings: DefocusSettings, default: Size) -> Dragged | None:
    """Return the plate, the lens and the settings at the requested size for --drag, else None.

    Raises HeatlensError if the plate cannot be read or is too small.
    """
    if not args.drag:
        return None
    if args.plate is None:
        return scene_plate(args.size or default), LENS, settings
    options = plate_options(args)
    plate = read_plate(args.plate, options)
    lens, said = lens_of(args, plate)
    say_plate(plate, lens, said, options)
    return plate, lens, _at_size(plate, settings, args.size)


def _at_size(plate: Plate, settings: DefocusSettings, size: Size | None) -> DefocusSettings:
    """Return the settings with the proxy scale that gives the width of `size`."""
    if size is None:
        return settings
    full = plate.data_window.width, plate.data_window.height
    if size[0] > full[0] or size[1] > full[1]:
        raise InputError(
            f"--size {size[0]}x{size[1]} is larger than {plate.path.name}, which has "
            f"{full[0]}x{full[1]} pixels: a plate can only be made smaller."
        )
    return replace(settings, proxy=max(PROXY_MIN, settings.proxy * size[0] / full[0]))


def level_sentences(what: Dragged) -> tuple[str, ...]:
    """Return the progress messages at the beginning of each level."""
    plate, _, settings = what
    size = plate.data_window.width, plate.data_window.height
    return tuple(level_words(level, size) for level in cheaper(settings))
