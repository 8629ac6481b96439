"""Read files as plates: a picture with the depth that belongs to it."""

# The steps of `read_plate`. Each one uses the result of the previous step.
#
# 1. The file: a deep EXR holds samples instead of planes, and is read by `deep_plate`. The header
#    of any other EXR is checked as bytes (`exr_scan`) before a library opens it, because a damaged
#    one can claim gigabytes. Photos are converted to the form of EXR parts (`picture_parts`), so
#    the steps below handle one form only.
# 2. The color (`channel_choice`): it is chosen before the depth, because among equal names of
#    depth that of its layer, part and view wins, and because its data window is that of the plate.
# 3. The lens in the header (`camera_header`): it converts distances along the rays to depth.
# 4. The depth (`depth_read`): its channel, the meaning of its values (`depth_guess`, and
#    `depth_shape` where name and range do not decide), meters without holes (`depth`, `repair`),
#    and last the window of the color. If no channel holds a depth, positions are searched for.
# 5. The plate (`_read_layer`): a photo's point of focus becomes a distance in this step, because it
#    is read from the depth. A plate with alpha is padded with empty pixels to its display window.
# 6. The options for a whole plate (`read_plate`): a depth is made flat first, because surfaces
#    behind are sorted by it. The cutout comes last, because it splits pixels.
#
# Steps that neither the file nor an option needs are skipped: the usual plate, one EXR with Z,
# passes through `exr`, `header`, `depth` and this file, and what the other steps need is imported
# where they begin.

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.log import log_time
from heatlens.core.model.depth_words import DepthConvention, DepthKind, DepthSide
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.plate.depth.depth import DepthResult
from heatlens.media.plate.depth.repair import bound_color, repair_color
from heatlens.media.plate.depth_read import read_depth_of, read_exr_parts
from heatlens.media.plate.exr.exr_read import is_deep_file
from heatlens.media.plate.exr.exr_write import COMPRESSIONS
from heatlens.media.plate.grain import despike_with_note
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.header.channel_choice import ColorChoice, NoDepthError, choose_color
from heatlens.media.plate.header.channels import (
    Header,
    Part,
    behind_layers,
    compression_name,
    is_behind,
    list_channels,
    pixels_of,
    views_of,
)
from heatlens.media.plate.header.entries import (
    FOCUS_POINT,
    FOR_THE_EYE,
    attributes_to_keep,
    blurred_notes,
    notes_of,
)
from heatlens.media.plate.header.placement import PLACEMENT, read_rigid_placement
from heatlens.media.plate.picture.highlights import lift_highlights
from heatlens.media.plate.plate import DepthReport, FloatImage, Plate, read_pixels
from heatlens.media.plate.windows import pixel_aspect_of, read_header_window


def read_plate(path: str | os.PathLike[str], options: PlateOptions | None = None) -> Plate:
    """Read a picture with its depth, free of NaN, over the data window of its color.

    A picture with alpha is read over its display window too, see `with_empty_outside`. The plates
    behind it, which show what it hides, are read and combined with it.
    Raises InputError that names the file, what was found and which option would help.
    """
    path, options = Path(path), options or PlateOptions()
    with log_time(f"read {path}"):
        plate, plates_behind = _read_file(path, options)
    if options.lift_highlights_stops and not plate.attributes.get(FOR_THE_EYE):
        raise InputError(
            f"{path} holds light brighter than white, so nothing in it needs --lift-highlights: "
            "leave it out."
        )
    if options.flat_depth is not None:
        from heatlens.media.plate.mattes.matte_options import with_flat_depth

        plate = with_flat_depth(plate, options.flat_depth)
    if PLACEMENT in plate.attributes:
        plate = replace(
            plate, world_to_camera=read_rigid_placement(plate.attributes, options.scene_unit_m)
        )
    if options.behind:
        plates_behind |= _read_files_behind(path, options)
    if plates_behind:
        from heatlens.media.plate.behind import with_behind

        plate = with_behind(plate, list(plates_behind.values()), list(plates_behind))
    if options.never_blur is None and options.only_blur is None:
        return plate
    from heatlens.media.plate.mattes.matte_options import with_cutout

    return with_cutout(plate, options)


def _read_files_behind(path: Path, options: PlateOptions) -> dict[str, Plate]:
    """Return the plates of the files `options.behind`, by their texts there."""
    from heatlens.media.plate.behind import deep_options, file_options
    from heatlens.media.sequence.depth_files import behind_paths

    plates: dict[str, Plate] = {}
    for number, path_behind in enumerate(behind_paths(path, options)):
        flat_options = file_options(options, number)
        is_deep = is_deep_file(path_behind)
        own_options = deep_options(flat_options) if is_deep else flat_options
        plates[options.behind[number]] = _read_behind(path_behind, own_options)
    return plates


def _read_behind(path: Path, options: PlateOptions) -> Plate:
    """Return the plate of a picture behind another one. Raises InputError if it has no depth."""
    try:
        return read_plate(path, options)
    except NoDepthError as error:
        raise InputError(
            f"{path} has no depth channel, but pictures behind the plate are sorted by their "
            "depth: render Z into it."
        ) from error


def _read_file(path: Path, options: PlateOptions) -> tuple[Plate, dict[str, Plate]]:
    """Return the plate of the file at `path`, and the plates of its hidden layers by name."""
    if is_deep_file(path):
        from heatlens.media.plate.deep.deep_plate import read_deep_plate

        return read_deep_plate(path, options), {}
    parts = color_file_parts(path, options)
    plate = _read_layer(path, [part for part in parts if not is_behind(part)] or parts, options)
    layers = behind_layers(parts)
    if not layers:
        return plate, {}
    from heatlens.media.plate.behind import layer_options

    return plate, {
        f"The layer {layer}": _read_layer(path, parts, layer_options(options, layer))
        for layer in layers
    }


def color_file_parts(path: Path, options: PlateOptions) -> list[Part]:
    """Read the header and channels of every part, with scene-linear colors.

    Raises InputError as `read_exr_parts` does.
    """
    if is_picture(path):
        from heatlens.media.plate.parts.picture_parts import color_parts

        return color_parts(path, options.picture_curve, options.depth_side)
    if options.depth_side is not DepthSide.NONE:
        raise InputError(f"{path} is an EXR, which has depth channels: leave --depth-side out.")
    return read_exr_parts(path)


def _read_layer(path: Path, parts: Sequence[Part], options: PlateOptions) -> Plate:
    """Return the plate of one layer of the file, with the depth that belongs to it."""
    headers = [header for header, _ in parts]
    choice = choose_color(path, headers, options.color_layer, options.eye)
    color, color_notes = read_color(path, parts, choice)
    header = headers[choice.rgb[0].part]
    camera = camera_at_header([header, *headers])
    aspect, aspect_notes = pixel_aspect_of(path, header)
    depth = read_or_estimate_depth(path, parts, choice, options)
    blur_notes = blurred_notes(path, header, options.strict)
    notes = *blur_notes, *choice.notes, *color_notes, *aspect_notes, *depth.notes
    if header.get(FOR_THE_EYE) and options.lift_highlights_stops:
        color = lift_highlights(color, options.lift_highlights_stops)
    if options.despike:
        notes += despike_with_note(color, depth.values, str(path))
    is_coc = depth.report.convention.facts.is_coc
    plate = Plate(
        path=path,
        pixels=read_pixels(color, depth.values, is_coc),
        has_alpha=choice.alpha is not None,
        data_window=read_header_window(header, "dataWindow"),
        display_window=read_header_window(header, "displayWindow"),
        pixel_aspect_ratio=aspect,
        camera=camera,
        depth=depth.report,
        aovs=tuple(ref.full_name for ref in list_channels(headers)),
        attributes=attributes_to_keep(header) | ({"view": choice.view} if choice.view else {}),
        notes=(*notes_of(header), *notes),
        compression=_offered_compression(header),
        views=views_of(headers),
    )
    if FOCUS_POINT in header:
        from heatlens.media.plate.picture.portrait import apply_photo_focus

        plate = apply_photo_focus(plate, header)
    if not plate.has_alpha:
        return plate
    from heatlens.media.plate.deep.stacked import with_empty_outside

    return with_empty_outside(plate)


def read_or_estimate_depth(
    path: Path, parts: Sequence[Part], choice: ColorChoice | None, options: PlateOptions
) -> DepthResult:
    """Return the depth that belongs to a color, read from a file or estimated by a network.

    Raises InputError as `read_depth_of` and `estimate_depth` do.
    """
    if options.one_distance_m is not None and choice is not None:
        return _depth_of_one_distance(pixels_of(parts, choice.rgb[0]).shape, options.one_distance_m)
    is_in_file = options.depth_source is not None or options.depth_channel is not None
    is_in_half = options.depth_side is not DepthSide.NONE
    if is_in_file + is_in_half + (options.depth_model is not None) > 1:
        raise InputError(
            f"{path}: the depth is given in more than one way. Give one: --depth or "
            "--depth-channel, --depth-side, or --depth-model."
        )
    if options.depth_model is None:
        return read_depth_of(path, parts, choice, options)
    if choice is None:
        raise InputError(f"{path} has no colour from which a depth could be estimated.")
    from heatlens.media.plate.estimate.estimated_depth import estimate_depth

    light = read_color(path, parts, choice)[0]
    return estimate_depth(path, light, options, partial(read_light, options))


def _depth_of_one_distance(shape: tuple[int, ...], distance_m: float) -> DepthResult:
    """Return a depth with everything at one distance."""
    why = f"Everything in the picture is taken as {distance_m:g} m away."
    report = DepthReport(
        *("none", DepthConvention.DISTANCE, DepthKind.PLANAR, why),
        *(distance_m, distance_m, 0, 0),
    )
    return DepthResult(np.full(shape, distance_m, np.float32), report, ())


def read_light(options: PlateOptions, path: Path) -> FloatImage:
    """Return the light (H, W, 4) of the picture at `path`: scene-linear, premultiplied RGBA."""
    parts = color_file_parts(path, options)
    choice = choose_color(path, [header for header, _ in parts], options.color_layer, options.eye)
    return read_color(path, parts, choice)[0]


def read_color(
    path: Path, parts: Sequence[Part], choice: ColorChoice
) -> tuple[FloatImage, tuple[str, ...]]:
    """Return RGBA (H, W, 4) of the chosen channels with NaN and infinity repaired, and notes."""
    red = pixels_of(parts, choice.rgb[0])
    color = np.empty((*red.shape, 4), dtype=np.float32)
    for index, ref in enumerate(choice.rgb):
        color[:, :, index] = pixels_of(parts, ref)
    color[:, :, 3] = 1.0 if choice.alpha is None else pixels_of(parts, choice.alpha)
    label = f"{path}: colour layer {choice.layer or 'RGB'!r}"
    count = repair_color(color, label)
    clamp_notes = bound_color(color, label)
    if not count:
        return color, clamp_notes
    return color, (
        f"{path}: {count} of {red.size} pixels had NaN or infinity in their colour and were "
        "replaced by the median of their neighbours.",
        *clamp_notes,
    )


def _offered_compression(header: Header) -> str:
    """Return the compression of the color part, or "" if `write_exr` does not offer it."""
    name = compression_name(header)
    return name if name in COMPRESSIONS else ""
