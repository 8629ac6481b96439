"""The options of the lens: given values come first, then the plate's header; all are printed.

A lens kit gives the properties and the limits of its lenses. The options for reading a plate are
here too, because they use the given focal length and film back.
"""

import argparse
from collections.abc import Mapping
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Explained
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.filmback import filmback_named
from heatlens.core.model.lens.lens import Lens, MeasuredFrom, measured_text
from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.options.field_options import (
    add_fields,
    attribute_names,
    flag_of,
    given_fields,
)
from heatlens.fronts.commands.options.kit_options import add_kit_option, kit_values, limit_to_kit
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.plate.coc_line import depth_at_m, focused_at_pixel, no_distances_error
from heatlens.media.plate.estimate.trusted import trust
from heatlens.media.plate.header.header_lens import MissingLensError, plate_lens
from heatlens.media.plate.plate import Plate

# The values that a lens needs; those in the plate's header need not be given.
_NEEDED_FIELDS = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m")
_MEASURING_FIELDS = ("measured_from", "pupil_offset_mm")
_OTHER_FIELDS = (*APERTURE_FIELDS, "widest_f_stop", "model", "breathing", *_MEASURING_FIELDS)
_FLAGS = {name: flag_of(Lens, name) for name in (*_NEEDED_FIELDS, "model")}
_FLAGS_BY_FIELD = {**_FLAGS, "focus_distance_m": f"{_FLAGS['focus_distance_m']} or --focus-at"}


def add_lens_options(parser: argparse.ArgumentParser, can_pick: bool = True) -> None:
    """Add the group `lens` to `parser`: the values of a lens, --filmback and --focus-at.

    If `can_pick` is False, --focus-at is left out, because there is no picture to pick from yet.
    """
    group = parser.add_argument_group(
        "lens",
        "Values not given are taken from the plate's header or the scene's camera if possible.",
    )
    add_fields(group, Lens, ["focal_length_mm"])
    back = group.add_mutually_exclusive_group()
    add_fields(back, Lens, ["sensor_width_mm"])
    back.add_argument("--filmback", metavar="NAME", help='a film back by name, such as "Super 35"')
    add_fields(group, Lens, ["f_stop"])
    focus = group.add_mutually_exclusive_group()
    add_fields(focus, Lens, ["focus_distance_m"])
    if can_pick:
        focus.add_argument(
            "--focus-at",
            metavar="X,Y",
            help="focus on the surface at this pixel, from the top left",
        )
    add_fields(group, Lens, _OTHER_FIELDS)
    add_kit_option(group)


def sensor_width_of(args: argparse.Namespace) -> float | None:
    """Return the width in mm of --sensor-width or --filmback; None if neither is given.

    Raises InputError for an unknown film back.
    """
    name: str | None = getattr(args, "filmback", None)
    width_mm: float | None = getattr(args, "sensor_width", None)
    return width_mm if name is None else filmback_named(name).width_mm


def given_lens_fields(args: argparse.Namespace) -> Values:
    """Return the fields of Lens that the options give, except what --focus-at finds.

    Raises InputError for an invalid distance, an unknown film back, an unknown lens kit or an
    aperture image that cannot be read.
    """
    _read_aperture_image(args)
    values = {**kit_values(args), **given_fields(args, Lens, (*_NEEDED_FIELDS, *_OTHER_FIELDS))}
    _measure_from_pupil(values)
    width_mm = sensor_width_of(args)
    return values if width_mm is None else {**values, "sensor_width_mm": width_mm}


def _read_aperture_image(args: argparse.Namespace) -> None:
    """Replace the path in --aperture-image by its picture, unless that is done already.

    Raises InputError if the file cannot be read. Prints messages.
    """
    if not isinstance(args.aperture_image, str):
        return
    from heatlens.media.plate.opening_picture import opening_notes, read_opening_image

    args.aperture_image = read_opening_image(args.aperture_image)
    print_messages(*opening_notes(args.aperture_image, bool(args.blades or args.blade_curvature)))


def _measure_from_pupil(values: Values) -> None:
    """Convert the focus in `values` to a distance from the entrance pupil.

    Raises InputError for a focus behind the pupil, and for a pupil offset without a film plane.
    """
    measured_from = values.get("measured_from", MeasuredFrom.PUPIL)
    if "pupil_offset_mm" in values and measured_from is MeasuredFrom.PUPIL:
        raise InputError("--pupil-offset needs --distances-from film-plane.")
    if "focus_distance_m" in values:
        offset_m = measured_from.offset_m(values.get("pupil_offset_mm", 0.0))
        values["focus_distance_m"] -= offset_m
        if offset_m and values["focus_distance_m"] <= 0:
            raise InputError(
                f"A focus at {values['focus_distance_m'] + offset_m:g} m from the film plane is "
                f"nearer than the entrance pupil, which is {offset_m:g} m from it. Give a larger "
                "--focus-distance."
            )


def lens_of(args: argparse.Namespace, plate: Plate) -> tuple[Lens, str]:
    """Return the lens of the options and the plate's header, and a text with all its values."""
    values, sources = given_lens_fields(args), value_origins(args)
    if plate.coc_px is not None:
        return _lens_of_coc(args, plate, values)
    if args.focus_at is not None:
        values["focus_distance_m"] = depth_at_m(plate, *parse_pixel(args.focus_at))
    try:
        with_sources = plate_lens(plate, values)
    except MissingLensError as error:
        raise InputError(error.sentence(_FLAGS_BY_FIELD)) from None
    source_texts = {
        "assumed full frame": f"assumed full frame; change it with {_FLAGS['sensor_width_mm']}"
    }
    origins = {
        field: source_texts.get(source, source) for field, source in with_sources.sources.items()
    }
    lens = with_sources.lens
    if args.focus_at is not None:
        lens = focused_at_pixel(plate, lens, *parse_pixel(args.focus_at))
    lens = limit_to_kit(args, lens)
    return lens, lens_words("lens", lens, {**origins, **sources})


def value_origins(args: argparse.Namespace) -> dict[str, str]:
    """Return the origin of each given field of Lens: an option, a camera or a key."""
    sensor_origin = f"film back {args.filmback}" if args.filmback is not None else "--sensor-width"
    focus_origin = "--focus-distance" if args.focus_at is None else f"--focus-at {args.focus_at}"
    options_by_field = {
        **_FLAGS,
        "sensor_width_mm": sensor_origin,
        "focus_distance_m": focus_origin,
    }
    if args.focal_length is None:
        options_by_field["focal_length_mm"] = f"--lens-kit {args.lens_kit}"
    options_by_field |= getattr(args, "origins", {})
    given_fields_of_lens = given_lens_fields(args)
    return {
        field: option
        for field, option in options_by_field.items()
        if field in given_fields_of_lens
        or (field == "focus_distance_m" and args.focus_at is not None)
    }


FOLLOWED_ORIGIN = "--follow"  # the origin of a focus that is not known yet


def lens_words(beginning: str, lens: Lens, sources: Mapping[str, str]) -> Explained:
    """Return the lens in a few words, with what is assumed, and behind them each value's origin."""
    values = {
        "focal_length_mm": f"{lens.focal_length_mm:g} mm",
        "f_stop": f"f/{lens.f_stop:g}",
        "focus_distance_m": _focus_text(lens, sources["focus_distance_m"]),
        "sensor_width_mm": f"sensor width {lens.sensor_width_mm:g} mm",
        "model": f"discs of a {lens.model.facts.words}",
    }
    all_texts = {field: f"{text} ({sources[field]})" for field, text in values.items()}
    short = [
        all_texts[field] if "assumed" in sources[field] else text
        for field, text in values.items()
        if "assumed" in sources[field] or field not in ("sensor_width_mm", "model")
    ]
    why = f"{beginning}: {', '.join(all_texts.values())}"
    return Explained(f"{beginning}: {', '.join(short)}", why)


def _focus_text(lens: Lens, origin: str) -> str:
    """Return the focus as text, and from where it is measured if that is not the pupil."""
    # The distance of a followed mark is measured when the lens is complete. Until then the lens
    # holds 1 m, which must not be shown as the focus.
    if origin == FOLLOWED_ORIGIN:
        return "focus on a mark"
    focus = f"focus {measured_text(lens, lens.focus_distance_m)}"
    is_usual = lens.measured_from is MeasuredFrom.PUPIL
    return focus if is_usual else f"{focus} from the {lens.measured_from.words}"


def _lens_of_coc(
    args: argparse.Namespace, plate: Plate, values: Mapping[str, Any]
) -> tuple[Lens, str]:
    """Return a lens for a plate with circles of confusion, and a message.

    Only the aperture of the lens is used. The message names the given options without effect.
    """
    if args.focus_at is not None:
        raise no_distances_error(plate)
    messages = ["lens: none needed, the plate holds circles of confusion"]
    # What other plates need to convert distances to circles of confusion.
    converting_options = (*attribute_names(Lens, (*_NEEDED_FIELDS, "model")), "filmback")
    given_options = [name for name in converting_options if getattr(args, name) is not None]
    messages += [f"--{name.replace('_', '-')} is not used" for name in given_options]
    return plate_lens(plate, values).lens, ", ".join(messages)


def parse_pixel(text: str) -> tuple[int, int]:
    """Parse X,Y for --focus-at. Raises InputError for anything else."""
    try:
        x, y = (int(number) for number in text.split(","))
    except ValueError:
        raise InputError(
            f"--focus-at takes a pixel as X,Y, got {text!r}. Example: 960,540."
        ) from None
    return x, y


def add_plate_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `how to read the plate` to `parser`: an option for each field that has one."""
    add_fields(parser.add_argument_group("how to read the plate"), PlateOptions)


def plate_options(args: argparse.Namespace) -> PlateOptions:
    """Return the plate options, with lens and film back if the command has options for them.

    Raises HeatlensError for an unknown unit or film back, or an option without effect.
    """
    trust(getattr(args, "depth_model", None))
    options = PlateOptions(
        focal_length_mm=getattr(args, "focal_length", None),
        sensor_width_mm=sensor_width_of(args),
        **given_fields(args, PlateOptions),
    )
    options.refuse_estimate_without_network()
    return options
