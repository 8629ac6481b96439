"""Read the depth that belongs to a color layer: planar, over the data window of the color."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.plate.depth.depth import DepthResult, finite_range, read_depth
from heatlens.media.plate.depth.raw_depth import DepthOrigin
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M
from heatlens.media.plate.exr.exr_read import is_deep_file, read_parts
from heatlens.media.plate.header.camera_header import camera_at_header, require_lens_mm
from heatlens.media.plate.header.channel_choice import ColorChoice, choose_depth
from heatlens.media.plate.header.channels import ChannelRef, Header, Part, flat_channels, pixels_of
from heatlens.media.plate.header.entries import picture_facts, writing_program
from heatlens.media.plate.plate import CameraHeader, FloatImage
from heatlens.media.plate.position import depth_of_positions, position_channels
from heatlens.media.plate.windows import (
    move_to_window,
    pixel_aspect_of,
    read_header_window,
    resize_nearest,
)

# The leaf of Mitsuba's `depth` integrator: the parameter t of the ray that hits.
_MITSUBA_RAY_LEAF = "t"
_SAME_ASPECT = 0.02  # rounding of the sizes may change the aspect ratio by this part


def read_depth_of(
    path: Path, parts: Sequence[Part], color: ColorChoice | None, options: PlateOptions
) -> DepthResult:
    """Read the depth that belongs to `color`, planar, over the color's data window.

    Without a color, the depth covers its own data window. If `options` name a depth file, it is
    read from there. Raises InputError that names the file, the channel and the option that helps.
    """
    headers = [header for header, _ in parts]
    target = headers[color.rgb[0].part] if color else None
    if options.depth_source is not None:
        from heatlens.media.sequence.depth_files import depth_path_for

        path = depth_path_for(path, options.depth_source)
        parts = read_depth_file_parts(path)
        camera_headers, headers = headers, [header for header, _ in parts]
        choose_channel = partial(_choose_in_depth_file, path, headers, color, options)
    else:
        camera_headers = headers
        is_coc = options.depth_convention.facts.is_coc
        choose_channel = partial(choose_depth, path, headers, options.depth_channel, color, is_coc)
    source = _find_depth_source(path, parts, color, options, camera_headers, choose_channel)
    return _read_source(path, parts, source, target, camera_headers, options)


def read_depth_file_parts(path: Path) -> list[Part]:
    """Read the parts of a depth file; the values stay as they are stored."""
    if not is_picture(path):
        return read_exr_parts(path)
    from heatlens.media.plate.parts.picture_parts import depth_parts

    return depth_parts(path)


def read_exr_parts(path: Path) -> list[Part]:
    """Read the parts of an EXR; a deep file gives one part, its flattened picture."""
    if not is_deep_file(path):
        return read_parts(path)
    from heatlens.media.plate.deep.deep_plate import read_flattened_part

    return [read_flattened_part(path)]


@dataclass(frozen=True, eq=False)
class _DepthSource:
    """Stored depth values (H, W) and their channel.

    why  how the values were computed from positions; "" if they were stored as a depth
    """

    ref: ChannelRef
    values: FloatImage
    why: str = ""


def _find_depth_source(
    path: Path,
    parts: Sequence[Part],
    color: ColorChoice | None,
    options: PlateOptions,
    camera_headers: Sequence[Header],
    choose_channel: Callable[[], ChannelRef],
) -> _DepthSource:
    """Find the depth channel, or compute a depth from a layer of positions.

    Positions are used if there is no depth channel, or if the options name them.
    """
    headers = [header for header, _ in parts]
    name, view = options.depth_channel, color.view if color else ""
    position = None if name is None else position_channels(headers, name, view)
    if position is None:
        try:
            ref = choose_channel()
            return _DepthSource(ref, pixels_of(parts, ref).astype(np.float32))
        except InputError:
            position = None if name is not None else position_channels(headers, name, view)
            if position is None:
                raise
    points = np.stack([pixels_of(parts, ref).astype(np.float32) for ref in position], axis=-1)
    all_headers = [*camera_headers, *headers]
    values, why = depth_of_positions(path, points, position[0].layer, all_headers)
    return _DepthSource(position[2], values, why)


def _choose_in_depth_file(
    path: Path, headers: Sequence[Header], color: ColorChoice | None, options: PlateOptions
) -> ChannelRef:
    """Find the depth channel of a separate depth file; its only channel may have any name.

    The red channel is used where the depth was written as gray in R, G and B. Raises InputError if
    several channels could be the depth.
    """
    is_coc = options.depth_convention.facts.is_coc
    try:
        return choose_depth(path, headers, options.depth_channel, color, is_coc)
    except InputError:
        only_channel = _only_channel(headers, color.view if color else "")
        if options.depth_channel is not None or only_channel is None:
            raise
        return only_channel


def _only_channel(headers: Sequence[Header], view: str) -> ChannelRef | None:
    """Return the only channel of a view besides alpha, or the red of three gray ones; else None."""
    view_channels = [ref for ref in flat_channels(headers) if not view or ref.view in ("", view)]
    value_channels = [ref for ref in view_channels if ref.leaf.lower() not in ("a", "alpha")]
    if len(value_channels) == 1:
        return value_channels[0]
    by_letter = {ref.leaf.lower(): ref for ref in value_channels}
    return (
        by_letter["r"] if len(value_channels) == 3 and by_letter.keys() == {"r", "g", "b"} else None
    )


def _read_source(
    path: Path,
    parts: Sequence[Part],
    source: _DepthSource,
    target: Header | None,
    camera_headers: Sequence[Header],
    options: PlateOptions,
) -> DepthResult:
    """Return the depth of `source`, planar, over the data window of `target` (None: its own)."""
    ref, values = source.ref, source.values
    headers = [header for header, _ in parts]
    header = headers[ref.part]
    facts = picture_facts(header)
    size_notes: tuple[str, ...] = ()
    if target is None:
        target = header
    elif options.depth_source is not None:
        values, header, size_notes = _resize_to_color(path, values, header, target)
    _check_same_display(path, ref.full_name, header, target)
    label = f"{path}: depth channel {ref.full_name!r}"
    if facts is not None:
        label = f"{path}: the depth"
    kind, kind_notes = _likely_kind(ref, label, options)
    origin = DepthOrigin(writing_program(headers), kind, facts)
    # A depth computed from positions is a planar distance already.
    if source.why:
        options = replace(
            options, depth_convention=DepthConvention.DISTANCE, depth_kind=DepthKind.PLANAR
        )
    result = read_depth(values, label, ref.full_name, options, origin)
    if source.why:
        result = replace(result, report=replace(result.report, why=source.why))
    result = replace(result, notes=(*size_notes, *result.notes, *kind_notes))
    if result.report.kind is DepthKind.RADIAL:
        camera = camera_at_header([target, header, *camera_headers])
        result = _replace_values(
            result, _convert_to_planar(path, result.values, header, camera, options)
        )
    return _move_to_color_window(path, result, header, target)


def _resize_to_color(
    path: Path, values: FloatImage, depth_header: Header, target: Header
) -> tuple[FloatImage, Header, tuple[str, ...]]:
    """Resize the depth of a full frame to the size of the color; return other depths unchanged.

    Returns the values, their header and notes. Only a depth without overscan and with the same
    aspect ratio is resized.
    """
    window = read_header_window(depth_header, "dataWindow")
    color_window = read_header_window(target, "displayWindow")
    is_full_frame = window == read_header_window(depth_header, "displayWindow")
    is_same_aspect = (
        abs(window.width * color_window.height / (window.height * color_window.width) - 1)
        < _SAME_ASPECT
    )
    if window == color_window or not (is_full_frame and is_same_aspect):
        return values, depth_header, ()
    note = (
        f"{path} is {window.width} x {window.height} pixels and the colour {color_window.width} x "
        f"{color_window.height}: every pixel takes the depth nearest to it."
    )
    color_windows = {
        "dataWindow": target["displayWindow"],
        "displayWindow": target["displayWindow"],
    }
    return (
        resize_nearest(values, (color_window.height, color_window.width)),
        depth_header | color_windows,
        (note,),
    )


def _likely_kind(
    ref: ChannelRef, label: str, options: PlateOptions
) -> tuple[DepthKind, tuple[str, ...]]:
    """Return the kind of depth that the channel's name suggests, with a note if it is radial.

    The name decides nothing if the options state the kind.
    """
    if ref.leaf.lower() != _MITSUBA_RAY_LEAF or options.depth_kind is not DepthKind.AUTO:
        return DepthKind.PLANAR, ()
    note = (
        f"{label} is named as Mitsuba names distances along the ray: taken as radial; "
        "--depth-kind planar overrules it."
    )
    return DepthKind.RADIAL, (note,)


def _check_same_display(path: Path, channel: str, depth_header: Header, target: Header) -> None:
    """Raise InputError if the display windows differ, so that pixels cannot be matched."""
    if read_header_window(depth_header, "displayWindow") != read_header_window(
        target, "displayWindow"
    ):
        raise InputError(
            f"{path}: depth channel {channel!r} and the colour have different display windows, so "
            "it is unclear which pixels belong together. Write them with the same one."
        )


def _convert_to_planar(
    path: Path, radial_m: FloatImage, header: Header, camera: CameraHeader, options: PlateOptions
) -> FloatImage:
    """Convert distances along the rays to depth along the axis.

    Focal length and sensor width of the options take precedence over those of the header.
    """
    focal_length_mm, sensor_width_mm = require_lens_mm(
        path,
        options.focal_length_mm or camera.focal_length_mm,
        options.sensor_width_mm or camera.sensor_width_mm,
    )
    planar_m = planar_depth_m(
        radial_m,
        read_header_window(header, "dataWindow"),
        read_header_window(header, "displayWindow"),
        pixel_aspect_of(path, header)[0],
        focal_length_mm,
        sensor_width_mm,
    )
    return np.maximum(planar_m, np.float32(DEPTH_LEAST_M))  # views of nearly 180 degrees reach 0


def _move_to_color_window(
    path: Path, result: DepthResult, depth_header: Header, target: Header
) -> DepthResult:
    """Return `result` over the data window of the color, infinite where it has no depth."""
    source = read_header_window(depth_header, "dataWindow")
    window = read_header_window(target, "dataWindow")
    if source == window:
        return result
    is_coc = result.report.convention.facts.is_coc
    values = move_to_window(result.values, source, window, 0.0 if is_coc else math.inf)
    shared = source.intersection(window)
    missing = values.size - shared.width * shared.height
    note = (
        f"{path}: {missing} pixels of the colour lie outside the data window of depth channel "
        f"{result.report.channel!r}: taken as {'in focus' if is_coc else 'infinitely far'}."
    )
    notes = (*result.notes, note) if missing else result.notes
    return _replace_values(replace(result, notes=notes), values)


def _replace_values(result: DepthResult, values: FloatImage) -> DepthResult:
    """Return `result` with other values, and with their range in its report."""
    if result.report.convention.facts.is_coc:
        return replace(result, values=values)
    infinite_count = int(np.count_nonzero(np.isinf(values)))
    near_m, far_m = finite_range(values, infinite_count)
    report = replace(result.report, near_m=near_m, far_m=far_m, infinite_count=infinite_count)
    return replace(result, values=values, report=report)


def planar_depth_m(
    radial_m: FloatImage,
    data_window: Box,
    display_window: Box,
    pixel_aspect_ratio: float,
    focal_length_mm: float,
    sensor_width_mm: float,
) -> FloatImage:
    """Convert distances along the rays to planar meters (H, W) over `data_window`.

    z = r / sqrt(1 + (x/f)^2 + (y/f)^2), with x and y the pixel's center on the sensor, measured
    from the center of the display window, whose width is the sensor's. Infinity stays infinity.
    """
    pitch_x = sensor_width_mm / display_window.width / focal_length_mm
    pitch_y = pitch_x / pixel_aspect_ratio
    centre_x = (display_window.x0 + display_window.x1) / 2
    centre_y = (display_window.y0 + display_window.y1) / 2
    x = (np.arange(data_window.x0, data_window.x1) + 0.5 - centre_x) * pitch_x
    y = (np.arange(data_window.y0, data_window.y1) + 0.5 - centre_y) * pitch_y
    stretch = np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    planar: FloatImage = (radial_m / stretch).astype(np.float32)
    return planar
