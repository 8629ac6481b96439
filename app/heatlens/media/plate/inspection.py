"""Describe what is in a file and how it would be read, as values that JSON can hold."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.base.paths import open_regular_file
from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.plausibility import DepthSpan, Doubt, find_doubts, span_doubts
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.exr.exr_read import choose_deep_channels, is_deep_file
from heatlens.media.plate.exr.exr_scan import parse_channels, scan_headers
from heatlens.media.plate.grain import DESPIKE_HELPS, despike_with_note, measure_noise, noise_note
from heatlens.media.plate.header.camera_header import camera_at_header, lens_model_of
from heatlens.media.plate.header.channel_choice import ColorChoice, choose_color
from heatlens.media.plate.header.channels import (
    Header,
    Part,
    behind_layers,
    compression_name,
    is_behind,
    pixels_of,
    type_name,
    views_of,
)
from heatlens.media.plate.header.entries import FOR_THE_EYE, blurred_notes, is_blurred, notes_of
from heatlens.media.plate.header.primaries import HeaderPrimaries, header_primaries
from heatlens.media.plate.mattes.cryptomatte import thing_names
from heatlens.media.plate.mattes.things import require_things
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.picture.highlights import clipped_note
from heatlens.media.plate.plate import CameraHeader, Plate, depth_span
from heatlens.media.plate.read import (
    color_file_parts,
    read_color,
    read_or_estimate_depth,
    read_plate,
)
from heatlens.media.plate.windows import pixel_aspect_of, read_header_window

Facts = dict[str, Any]

# NumPy type -> name in EXR; channels of any other type hold a list of samples for each pixel.
_PIXEL_TYPE_NAMES = {"f2": "half", "f4": "float", "u4": "uint"}


def inspect(path: Path, options: PlateOptions) -> Facts:
    """Return size, parts, camera, color and depth of the file at `path`.

    Lengths are in meters or millimeters as their names say; windows are [x0, y0, x1, y1], of which
    x1 and y1 lie just outside. If no color or no depth can be read, its entry is {"problem":
    sentence}. Infinity becomes "infinity" and NaN becomes None, because JSON has neither. Raises
    InputError only if the file itself cannot be read, or no frame has a thing that the options
    name.
    """
    require_things(path, options)
    if is_deep_file(path):
        return _deep_facts(read_plate(path, options), options)
    all_parts = color_file_parts(path, options)
    parts = [part for part in all_parts if not is_behind(part)] or all_parts
    headers = [header for header, _ in parts]
    choice, color = _color_facts(path, parts, options)
    header = headers[choice.rgb[0].part if choice else 0]
    window, display = (read_header_window(header, name) for name in ("dataWindow", "displayWindow"))
    primaries = header_primaries(header)
    camera = camera_at_header([header, *headers])
    depth, depth_notes = _depth_facts(path, parts, choice, options, camera)
    aspect, aspect_notes = pixel_aspect_of(path, header)
    notes = [*color.pop("notes", ()), *aspect_notes, *depth_notes]
    return {
        "path": str(path),
        **_size_facts(window, display),
        "pixel_aspect_ratio": aspect,
        "views": list(views_of(headers)),
        "things": thing_names(path.parent, headers),
        "parts": [_part_facts(header, _pixel_types_of(channels)) for header, channels in all_parts],
        "behind": _behind_facts(path, options, bool(behind_layers(all_parts))),
        "camera": {name: _json_value(value) for name, value in asdict(camera).items()},
        "primaries": None if primaries is None else _primaries_facts(primaries),
        "is_for_the_eye": bool(header.get(FOR_THE_EYE)),
        "is_blurred": is_blurred(header),
        "color": color,
        "depth": depth,
        "notes": [*blurred_notes(path, header), *notes_of(header), *notes],
    }


def _size_facts(window: Box, display: Box) -> Facts:
    """Return the sizes and corners of the data window and of the display window."""
    return {
        "width_px": window.width,
        "height_px": window.height,
        "data_window": list(window.corners),
        "display_window": list(display.corners),
        "display_width_px": display.width,
        "display_height_px": display.height,
    }


def _deep_facts(plate: Plate, options: PlateOptions) -> Facts:
    """Return the facts of a deep file: those of its flattened picture and of its surfaces."""
    headers = read_headers(plate.path)
    window, display = _deep_window(plate.path, headers, options), plate.display_window
    rgb = plate.color[..., :3]
    noise = measure_noise(rgb)
    depth = {name: _json_value(value) for name, value in asdict(plate.depth).items()}
    span = depth_span(plate, options.scene_unit_m)
    primaries = header_primaries(plate.attributes)
    return {
        "path": str(plate.path),
        **_size_facts(window, display),
        "pixel_aspect_ratio": plate.pixel_aspect_ratio,
        "is_for_the_eye": False,
        "is_blurred": is_blurred(plate.attributes),
        "views": list(views_of(headers)),
        "things": thing_names(plate.path.parent, headers),
        "parts": _deep_part_facts(plate.path, headers),
        "behind": _behind_reports(plate),
        "camera": {name: _json_value(value) for name, value in asdict(plate.camera).items()},
        "primaries": None if primaries is None else _primaries_facts(primaries),
        "color": {
            "layer": "",
            "view": "",
            "has_alpha": plate.has_alpha,
            "min": float(rgb.min()),
            "max": float(rgb.max()),
            "nan_count": 0,
            "infinite_count": 0,
            "noise": noise,
        },
        "depth": depth,
        "notes": [
            *plate.notes,
            *noise_note(noise, str(plate.path)),
            *(doubt.sentence for doubt in _find_doubts(plate.camera, span)),
        ],
    }


def _deep_part_facts(path: Path, headers: Sequence[Header]) -> list[Facts]:
    """Return the facts of each part, whose pixels are not read."""
    with open_regular_file(path) as file:
        raw_headers = scan_headers(file)
    pixel_types = [
        {
            channel.name.decode(errors="replace"): channel.numpy_type
            for channel in parse_channels(raw_header)
        }
        for raw_header in raw_headers
    ]
    return [_part_facts(*pair) for pair in zip(headers, pixel_types, strict=True)]


def _deep_window(path: Path, headers: Sequence[Header], options: PlateOptions) -> Box:
    """Return the data window in the file, which may be smaller than that of the deep plate."""
    channels = choose_deep_channels(path, headers, options.color_layer, options.eye)
    return read_header_window(headers[channels.part], "dataWindow")


def _behind_facts(path: Path, options: PlateOptions, has_layers: bool) -> list[Facts]:
    """Return facts on each picture behind. Raises InputError if a given file cannot be added."""
    if not (has_layers or options.behind):
        return []
    try:
        plate = read_plate(path, options)
    except InputError as error:
        if options.behind:
            raise
        return [{"name": "its own layers", "problem": str(error), "words": "cannot be added"}]
    return _behind_reports(plate)


def _behind_reports(plate: Plate) -> list[Facts]:
    """Return the reports on the pictures behind a plate, which were added without a problem."""
    return [asdict(report) | {"problem": "", "words": report.words} for report in plate.behind]


def _primaries_facts(primaries: HeaderPrimaries) -> Facts:
    """Return the attribute, its value, and the color space that it names; None if unknown.

    `by_matrix` is True if a matrix from the primaries can convert an unknown space to Rec. 709.
    """
    return {
        "attribute": primaries.attribute,
        "value": primaries.value,
        "space": None if primaries.known is None else primaries.known.name,
        "by_matrix": primaries.primaries is not None,
    }


def _pixel_types_of(channels: Mapping[str, np.ndarray]) -> dict[str, str]:
    """Return the NumPy type of each channel, such as "<f2"."""
    return {name: pixels.dtype.str for name, pixels in channels.items()}


def _part_facts(header: Header, pixel_types: Mapping[str, str]) -> Facts:
    """Return name, layout and channels of one part; `pixel_types` are the channels' NumPy types."""
    return {
        "name": str(header.get("name", "")),
        "type": type_name(header),
        "compression": compression_name(header),
        "data_window": list(read_header_window(header, "dataWindow").corners),
        "channels": {
            channel.name: _PIXEL_TYPE_NAMES.get(
                pixel_types.get(channel.name, "").lstrip("<>=|"), "deep"
            )
            for channel in header["channels"]
        },
    }


def _color_facts(
    path: Path, parts: Sequence[Part], options: PlateOptions
) -> tuple[ColorChoice | None, Facts]:
    """Return the chosen color, and facts such as its range over R, G and B before any repair."""
    try:
        headers = [header for header, _ in parts]
        choice = choose_color(path, headers, options.color_layer, options.eye)
    except InputError as error:
        return None, {"problem": str(error)}
    planes = [pixels_of(parts, ref) for ref in dict.fromkeys(choice.rgb)]
    finite = [plane[np.isfinite(plane)] for plane in planes]
    facts: Facts = {
        "layer": choice.layer,
        "view": choice.view,
        "has_alpha": choice.alpha is not None,
        "min": min((float(values.min()) for values in finite if values.size), default=None),
        "max": max((float(values.max()) for values in finite if values.size), default=None),
        "nan_count": sum(int(np.count_nonzero(np.isnan(plane))) for plane in planes),
        "infinite_count": sum(int(np.count_nonzero(np.isinf(plane))) for plane in planes),
    }
    try:
        color, notes = read_color(path, parts, choice)
        facts["noise"] = noise = measure_noise(color)
        facts["notes"] = [*choice.notes, *notes, *noise_note(noise, str(path), DESPIKE_HELPS)]
        is_for_eye = parts[choice.rgb[0].part][0].get(FOR_THE_EYE)
        if is_for_eye and not options.lift_highlights_stops:
            facts["notes"] += clipped_note(color, str(path))
    except InputError as error:
        facts["problem"] = str(error)
    return choice, facts


def _depth_facts(
    path: Path,
    parts: Sequence[Part],
    color: ColorChoice | None,
    options: PlateOptions,
    camera: CameraHeader,
) -> tuple[Facts, tuple[str, ...]]:
    """Return how the depth was read, with notes, or why there is none."""
    try:
        result = read_or_estimate_depth(path, parts, color, options)
    except InputError as error:
        return {"problem": str(error)}, ()
    report = result.report
    facts = {name: _json_value(value) for name, value in asdict(report).items()}
    span = DepthSpan(report.near_m, report.far_m, report.infinite_count > 0, options.scene_unit_m)
    doubt_sentences = tuple(doubt.sentence for doubt in _find_doubts(camera, span))
    if report.convention.facts.is_coc:
        facts["min_px"] = float(result.values.min())
        facts["max_px"] = float(result.values.max())
    if not options.despike or color is None:
        return facts, (*result.notes, *doubt_sentences)
    despike_notes = despike_with_note(read_color(path, parts, color)[0], result.values, str(path))
    return facts, (*result.notes, *doubt_sentences, *despike_notes)


def _find_doubts(camera: CameraHeader, span: DepthSpan) -> tuple[Doubt, ...]:
    """Return doubts about the depths, and about the lens in the header if it is complete."""
    focal_mm, f_stop = camera.focal_length_mm, camera.f_stop
    focus_m, sensor_mm = camera.focus_distance_m, camera.sensor_width_mm
    if focal_mm is None or f_stop is None or focus_m is None or sensor_mm is None:
        return span_doubts(span)
    try:
        model, _ = lens_model_of(camera)
        return find_doubts(Lens(focal_mm, f_stop, focus_m, sensor_mm, model=model), span)
    except LensError as error:
        return (Doubt("lens", f"The header describes an impossible lens. {error}"),)


def _json_value(value: object) -> object:
    """Return `value`; for a float that JSON cannot express, return a word or None."""
    if isinstance(value, float) and not math.isfinite(value):
        return "infinity" if value == math.inf else None
    return value
