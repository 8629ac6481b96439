"""From the parts of a file to the depth that belongs to its colour: planar and in its window."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from heatlens.errors import InputError
from heatlens.image.bounds import DEPTH_LEAST_M
from heatlens.image.camera_header import camera_at_header
from heatlens.image.channel_choice import ColorChoice, choose_depth
from heatlens.image.channels import ChannelRef, Header, Part, pixels_of
from heatlens.image.depth import DepthResult, finite_range, read_depth
from heatlens.image.plate import CameraHeader, FloatImage
from heatlens.image.radial import checked_lens_mm, planar_depth_m
from heatlens.image.windows import box_at_header, moved_to_window, pixel_aspect_of
from heatlens.image.written_by import written_by
from heatlens.model.plate_options import DepthKind, PlateOptions

# The leaf of Mitsuba's `depth` integrator: the parameter t of the ray that hits.
_ALONG_RAY = "t"


def read_depth_of(
    path: Path, parts: Sequence[Part], color: ColorChoice | None, options: PlateOptions
) -> DepthResult:
    """The depth that belongs to `color`, planar, over the colour's data window.

    Without a colour, over its own. Raises InputError naming file, channel and option.
    """
    headers = [header for header, _ in parts]
    is_coc = options.depth_convention == "coc"
    ref = choose_depth(path, headers, options.depth_channel, color, is_coc)
    header = headers[ref.part]
    target = headers[color.rgb[0].part] if color else header
    _check_same_display(path, ref.full_name, header, target)
    values = pixels_of(parts, ref).astype(np.float32)
    what = f"{path}: depth channel {ref.full_name!r}"
    kind, kind_notes = _likely_kind(ref, what, options)
    result = read_depth(values, what, ref.full_name, options, written_by(headers), kind)
    result = replace(result, notes=(*result.notes, *kind_notes))
    if result.report.kind == "radial":
        camera = camera_at_header([target, header, *headers])
        result = _with_values(result, _made_planar(path, result.values, header, camera, options))
    return _aligned(path, result, header, target)


def _likely_kind(
    ref: ChannelRef, what: str, options: PlateOptions
) -> tuple[DepthKind, tuple[str, ...]]:
    """What the channel's name says that it is measured along; said where it is not the axis."""
    if ref.leaf.lower() != _ALONG_RAY or options.depth_kind != "auto":
        return "planar", ()
    note = (
        f"{what} is named as Mitsuba names distances along the ray: taken as radial; "
        "--depth-kind planar overrules it."
    )
    return "radial", (note,)


def _check_same_display(path: Path, channel: str, own: Header, target: Header) -> None:
    """InputError when nothing says how the pixels of two parts lie on each other."""
    if box_at_header(own, "displayWindow") != box_at_header(target, "displayWindow"):
        raise InputError(
            f"{path}: depth channel {channel!r} and the colour have different display windows, so "
            "it is unclear which pixels belong together. Write them with the same one."
        )


def _made_planar(
    path: Path, radial_m: FloatImage, header: Header, camera: CameraHeader, options: PlateOptions
) -> FloatImage:
    """Distances along the rays turned into depth along the axis; the options know the lens best."""
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
    return np.maximum(planar_m, np.float32(DEPTH_LEAST_M))  # at the rim of a view of 180 degrees


def _aligned(path: Path, result: DepthResult, own: Header, target: Header) -> DepthResult:
    """`result` over the data window of the colour's part; infinitely far where not covered."""
    source, window = box_at_header(own, "dataWindow"), box_at_header(target, "dataWindow")
    if source == window:
        return result
    is_coc = result.report.convention == "coc"
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
    """`result` with other values and a report of their range."""
    if result.report.convention == "coc":
        return replace(result, values=values)
    infinite_count = int(np.count_nonzero(np.isinf(values)))
    near_m, far_m = finite_range(values, infinite_count)
    report = replace(result.report, near_m=near_m, far_m=far_m, infinite_count=infinite_count)
    return replace(result, values=values, report=report)
