"""Read the lens kit of the command line, and keep a lens within it."""

import argparse
from dataclasses import replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import LensKit
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.options.field_options import flag_of
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.documents.lens_kits import kit_shelf

# The fields of Lens that a kit limits, and the options that set them.
_LIMITED_OPTIONS = {
    "focal_length_mm": ("focal_length",),
    "f_stop": ("f_stop",),
    "focus_distance_m": ("focus_distance", "focus_at"),
}


def add_kit_option(group: "argparse._ArgumentGroup") -> None:
    """Add --lens-kit and --breathe."""
    group.add_argument(
        "--lens-kit",
        metavar="NAME[:LENGTH]",
        help="use a lens of a kit, such as vintage-primes:50: its focal length, character, widest "
        "stop and close focus; `heatlens kits` lists them",
    )
    group.add_argument(
        "--breathe",
        action="store_true",
        help="let the view breathe with focus as the lens of the kit does (default: no breathing); "
        "--breathing sets it for a lens without a kit",
    )


def kit_of(args: argparse.Namespace) -> LensKit | None:
    """Return the kit of the options. Raises InputError if there is no such kit."""
    return None if args.lens_kit is None else kit_shelf().select_kit(args.lens_kit)[0]


def kit_values(args: argparse.Namespace) -> dict[str, object]:
    """Return the fields of Lens from --lens-kit: the character, and the focal length if given.

    Raises InputError if two focal lengths are given.
    """
    if args.lens_kit is None:
        if args.breathe:
            raise InputError(
                "--breathe lets the view change as the lens of a kit does: give --lens-kit, or "
                "--breathing with a ratio."
            )
        return {}
    kit, length_mm = kit_shelf().select_kit(args.lens_kit)
    values = kit.character.opening | ({"breathing": _any_breathing(kit)} if args.breathe else {})
    if length_mm is None:
        return values
    if args.focal_length not in (None, length_mm):
        raise InputError(
            f"--lens-kit {args.lens_kit} and {flag_of(Lens, 'focal_length_mm')} "
            f"{args.focal_length:g} give two focal lengths: give one."
        )
    return {**values, "focal_length_mm": length_mm}


def _any_breathing(kit: LensKit) -> float:
    """Return the breathing of any lens of the kit; that of the lens in use later replaces it."""
    return next((lens.breathing for lens in kit.lenses if lens.breathing != 1.0), 1.0)


def limit_to_kit(args: argparse.Namespace, lens: Lens) -> Lens:
    """Return the lens limited to what the kit of the options allows, and print any change.

    Raises InputError if an option requests something that the kit does not have.
    """
    kit = kit_of(args)
    if kit is None:
        return lens
    refusal = kit.refusal_message(lens)
    limited = kit.limit_change(None, lens)
    if args.breathing is not None:
        limited = replace(limited, breathing=args.breathing)
    changed_fields = [
        name for name in _LIMITED_OPTIONS if getattr(limited, name) != getattr(lens, name)
    ]
    if any(
        getattr(args, option, None) is not None
        for name in changed_fields
        for option in _LIMITED_OPTIONS[name]
    ):
        raise InputError(refusal)
    if refusal:
        print_messages(f"{refusal} The nearest possible value is used.")
    return limited


def shot_with_kit(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with the kit of the options, its lens within the kit."""
    kit = kit_of(args)
    return shot if kit is None else replace(shot, kit=kit, lens=limit_to_kit(args, shot.lens))
