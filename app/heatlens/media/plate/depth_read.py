"""Read the depth that belongs to a colour layer: planar, over the data window of the colour."""

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
from heatlens.media.plate.deep.deep_plate import flattened_part
from heatlens.media.plate.depth.depth import DepthResult, finite_range, read_depth
from heatlens.media.plate.depth.depth_guess import DepthOrigin
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M
from heatlens.media.plate.exr.exr_read import is_deep_file, read_parts
from heatlens.media.plate.header.camera_header import camera_at_header, checked_lens_mm
from heatlens.media.plate.header.channel_choice import ColorChoice, choose_depth
from heatlens.media.plate.header.channels import ChannelRef, Header, Part, flat_channels, pixels_of
from heatlens.media.plate.header.entries import picture_facts, written_by
from heatlens.media.plate.parts.picture_parts import depth_parts
from heatlens.media.plate.plate import CameraHeader, FloatImage
from heatlens.media.plate.position import depth_of_positions, position_channels
from heatlens.media.plate.windows import (
    box_at_header,
    moved_to_window,
    pixel_aspect_of,
    resized_nearest,
)
from heatlens.media.sequence.depth_files import depth_path_for

# The leaf of Mitsuba's `depth` integrator: the parameter t of the ray that hits.
_ALONG_RAY = "t"
_SAME_ASPECT = 0.02  # rounding of the sizes may change the aspect ratio by this part


def read_depth_of(
    path: Path, parts: Sequence[Part], color: ColorChoice | None, options: PlateOptions
) -> DepthResult:
    """Read the depth that belongs to `color`, planar, over the colour's data window.

    Without a colour it covers its own data window. If `options` name a depth file, it is read from
    there. Raises InputError that names the file, the channel and the option that helps.
    """
    headers = [header for header, _ in parts]
    target = headers[color.rgb[0].part] if color else None
    if options.depth_source is not None:
        path = depth_path_for(path, options.depth_source)
        parts = depth_file_parts(path)
        camera_headers, headers = headers, [header for header, _ in parts]
        find = partial(_in_depth_file, path, headers, color, options)
    else:
        camera_headers = headers
        is_coc = options.depth_convention.facts.is_coc
        find = partial(choose_depth, path, headers, options.depth_channel, color, is_coc)
    source = _depth_channel(path, parts, color, options, camera_headers, find)
    return _read(path, parts, source, target, camera_headers, options)


def depth_file_parts(path: Path) -> list[Part]:
    """Read the parts of a depth file; the values stay as they are stored."""
    if is_picture(path):
        return depth_parts(path)
    return [flattened_part(path)] if is_deep_file(path) else read_parts(path)


@dataclass(frozen=True, eq=False)
class _Source:
    """Stored values (H, W), their channel, and how they were computed from positions, if so."""

    ref: ChannelRef
    values: FloatImage
    why: str = ""


def _depth_channel(
    path: Path,
    parts: Sequence[Part],
    color: ColorChoice | None,
    options: PlateOptions,
    camera_headers: Sequence[Header],
    find: Callable[[], ChannelRef],
) -> _Source:
    """Find the depth channel, or compute a depth from positions.

    Positions are used if there is no depth channel, or if the options name them.
    """
    headers = [header for header, _ in parts]
    name, view = options.depth_channel, color.view if color else ""
    position = None if name is None else position_channels(headers, name, view)
    if position is None:
        try:
            ref = find()
            return _Source(ref, pixels_of(parts, ref).astype(np.float32))
        except InputError:
            position = None if name is not None else position_channels(headers, name, view)
            if position is None:
                raise
    points = np.stack([pixels_of(parts, ref).astype(np.float32) for ref in position], axis=-1)
    all_headers = [*camera_headers, *headers]
    values, why = depth_of_positions(path, points, position[0].layer, all_headers)
    return _Source(position[2], values, why)


def _in_depth_file(
    path: Path, headers: Sequence[Header], color: ColorChoice | None, options: PlateOptions
) -> ChannelRef:
    """Find the depth channel of a separate depth file; its only channel may have any name.

    The red channel is used where the depth was written as grey in R, G and B. Raises InputError if
    several channels could be the depth.
    """
    is_coc = options.depth_convention.facts.is_coc
    try:
        return choose_depth(path, headers, options.depth_channel, color, is_coc)
    except InputError:
        only = _only_channel(headers, color.view if color else "")
        if options.depth_channel is not None or only is None:
            raise
        return only


def _only_channel(headers: Sequence[Header], view: str) -> ChannelRef | None:
    """Return the only channel of a view besides alpha, or the red one of three that are grey."""
    usable = [ref for ref in flat_channels(headers) if not view or ref.view in ("", view)]
    plain = [ref for ref in usable if ref.leaf.lower() not in ("a", "alpha")]
    if len(plain) == 1:
        return plain[0]
    by_letter = {ref.leaf.lower(): ref for ref in plain}
    return by_letter["r"] if len(plain) == 3 and by_letter.keys() == {"r", "g", "b"} else None


def _read(
    path: Path,
    parts: Sequence[Part],
    source: _Source,
    target: Header | None,
    camera_headers: Sequence[Header],
    options: PlateOptions,
) -> DepthResult:
    """Read the depth of `source`, planar, over the window of `target`; None means its own."""
    ref, values = source.ref, source.values
    headers = [header for header, _ in parts]
    header = headers[ref.part]
    facts = picture_facts(header)
    size_notes: tuple[str, ...] = ()
    if target is None:
        target = header
    elif options.depth_source is not None:
        values, header, size_notes = _at_size_of(path, values, header, target)
    _check_same_display(path, ref.full_name, header, target)
    what = f"{path}: depth channel {ref.full_name!r}"
    if facts is not None:
        what = f"{path}: the depth"
    kind, kind_notes = _likely_kind(ref, what, options)
    origin = DepthOrigin(written_by(headers), kind, facts)
    if source.why:
        options = replace(
            options, depth_convention=DepthConvention.DISTANCE, depth_kind=DepthKind.PLANAR
        )
    result = read_depth(values, what, ref.full_name, options, origin)
    if source.why:
        result = replace(result, report=replace(result.report, why=source.why))
    result = replace(result, notes=(*size_notes, *result.notes, *kind_notes))
    if result.report.kind is DepthKind.RADIAL:
        camera = camera_at_header([target, header, *camera_headers])
        result = _with_values(result, _made_planar(path, result.values, header, camera, options))
    return _aligned(path, result, header, target)


def _at_size_of(
    path: Path, values: FloatImage, own: Header, target: Header
) -> tuple[FloatImage, Header, tuple[str, ...]]:
    """Resize the depth of a full frame to the size of the colour; return others unchanged.

    Returns the values, their header and notes. Only a depth without overscan and with the same
    aspect ratio is resized.
    """
    window = box_at_header(own, "dataWindow")
    wanted = box_at_header(target, "displayWindow")
    is_whole = window == box_at_header(own, "displayWindow")
    is_like = abs(window.width * wanted.height / (window.height * wanted.width) - 1) < _SAME_ASPECT
    if window == wanted or not (is_whole and is_like):
        return values, own, ()
    note = (
        f"{path} is {window.width} x {window.height} pixels and the colour {wanted.width} x "
        f"{wanted.height}: every pixel takes the depth nearest to it."
    )
    placed = {"dataWindow": target["displayWindow"], "displayWindow": target["displayWindow"]}
    return resized_nearest(values, (wanted.height, wanted.width)), own | placed, (note,)


def _likely_kind(
    ref: ChannelRef, what: str, options: PlateOptions
) -> tuple[DepthKind, tuple[str, ...]]:
    """Return the kind of depth that the channel's name suggests, with a note if it is radial."""
    if ref.leaf.lower() != _ALONG_RAY or options.depth_kind is not DepthKind.AUTO:
        return DepthKind.PLANAR, ()
    note = (
        f"{what} is named as Mitsuba names distances along the ray: taken as radial; "
        "--depth-kind planar overrules it."
    )
    return DepthKind.RADIAL, (note,)


def _check_same_display(path: Path, channel: str, own: Header, target: Header) -> None:
    """Raise InputError if the display windows differ, so that pixels cannot be matched."""
    if box_at_header(own, "displayWindow") != box_at_header(target, "displayWindow"):
        raise InputError(
            f"{path}: depth channel {channel!r} and the colour have different display windows, so "
            "it is unclear which pixels belong together. Write them with the same one."
        )


def _made_planar(
    path: Path, radial_m: FloatImage, header: Header, camera: CameraHeader, options: PlateOptions
) -> FloatImage:
    """Convert distances along the rays to depth along the axis.

    Focal length and sensor width of the options take precedence over those of the header.
    """
    focal_length_mm, sensor_width_mm = checked_lens_mm(
        path,
        options.focal_length_mm or camera.focal_length_mm,
        options.sensor_width_mm or camera.sensor_width_mm,
    )
    planar_m = planar_depth_m(
        radial_m,
        box_at_header(header, "dataWindow"),
        box_at_header(header, "displayWindow"),
        pixel_aspect_of(path, header)[0],
        focal_length_mm,
        sensor_width_mm,
    )
    return np.maximum(planar_m, np.float32(DEPTH_LEAST_M))  # views of nearly 180 degrees reach 0


def _aligned(path: Path, result: DepthResult, own: Header, target: Header) -> DepthResult:
    """Return `result` over the data window of the colour, infinite where it has no depth."""
    source, window = box_at_header(own, "dataWindow"), box_at_header(target, "dataWindow")
    if source == window:
        return result
    is_coc = result.report.convention.facts.is_coc
    values = moved_to_window(result.values, source, window, 0.0 if is_coc else math.inf)
    shared = source.intersection(window)
    missing = values.size - shared.width * shared.height
    note = (
        f"{path}: {missing} pixels of the colour lie outside the data window of depth channel "
        f"{result.report.channel!r}: taken as {'in focus' if is_coc else 'infinitely far'}."
    )
    notes = (*result.notes, note) if missing else result.notes
    return _with_values(replace(result, notes=notes), values)


def _with_values(result: DepthResult, values: FloatImage) -> DepthResult:
    """Return `result` with other values, and with a report of the range of these."""
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
    """Convert distances along the rays to planar metres (H, W) over `data_window`.

    z = r / sqrt(1 + (x/f)^2 + (y/f)^2), with x and y the pixel's centre on the sensor, measured
    from the centre of the display window, whose width is the sensor's. Infinity stays infinity.
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
