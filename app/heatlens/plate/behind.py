"""Pictures of what lies behind a plate: other files, or parts and layers of its own file."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from heatlens.errors import InputError
from heatlens.model.boxes import Box
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.channels import Part, list_channels
from heatlens.plate.fragments import (
    LEAST_COVERAGE,
    SAME_DEPTH,
    FloatImage,
    Stacked,
    Surface,
    stacked,
)
from heatlens.plate.plate import BehindReport, Plate, ReadPixels
from heatlens.plate.windows import moved_to_window
from heatlens.sequence.depth_files import beside_path

_BEHIND = re.compile(r"behind(\.\d+)?$", re.IGNORECASE)


def is_behind(part: Part) -> bool:
    """Return True for a part that holds what is hidden, by its name: behind, behind.1, ..."""
    return bool(_BEHIND.match(str(part[0].get("name", ""))))


def behind_layers(parts: Sequence[Part]) -> tuple[str, ...]:
    """Return the layers, of any part, that hold what is hidden, in the order of the file."""
    layers = dict.fromkeys(ref.layer for ref in list_channels([header for header, _ in parts]))
    return tuple(name for name in layers if _BEHIND.match(name))


def own_options(options: PlateOptions) -> PlateOptions:
    """Return how to read a picture behind: the channels are found by their names in it."""
    return replace(options, depth_channel=None, color_layer=None, depth_source=None, behind=())


def behind_paths(path: Path, options: PlateOptions) -> tuple[Path, ...]:
    """Return the files behind the plate at `path`: of a pattern, the frame of the same number."""
    return tuple(beside_path(path, text, "--behind", "picture behind") for text in options.behind)


def with_behind(plate: Plate, behind: Sequence[tuple[str, Plate]]) -> Plate:
    """Return the plate with what other plates show behind it, or in front of it.

    `behind` has the name of each picture, and the picture. Each pixel is sorted by depth. Data
    windows may differ; what lies outside the plate's own is left out. Raises InputError for other
    display windows, and for plates of circles of confusion.
    """
    if not behind:
        return plate
    surfaces = [Surface(plate.color, _depth_of(plate))]
    for _, other in behind:
        _check_same_view(plate, other)
        surfaces.append(_over_window(other, plate.data_window))
    made = stacked(surfaces)
    reports = tuple(
        _report(name, surface, surfaces[0], made.depth_m)
        for (name, _), surface in zip(behind, surfaces[1:], strict=True)
    )
    return _restacked(plate, made, reports)


def _report(name: str, added: Surface, front: Surface, nearest_m: FloatImage) -> BehindReport:
    """Return how much of the picture `added` lies behind, and how much in front of the plate."""
    is_there = added.color[..., 3] > LEAST_COVERAGE
    front_m = np.where(front.color[..., 3] > LEAST_COVERAGE, front.depth_m, np.float32(np.inf))
    is_hidden = is_there & (added.depth_m > (1 + SAME_DEPTH) * nearest_m)
    is_seen = is_there & (added.depth_m < (1 - SAME_DEPTH) * front_m)
    return BehindReport(name, float(is_hidden.mean()), float(is_seen.mean()))


def _restacked(plate: Plate, made: Stacked, reports: tuple[BehindReport, ...]) -> Plate:
    has_alpha = plate.has_alpha and bool((made.color[..., 3] < 1.0).any())
    if not has_alpha:
        made.color[..., 3] = 1.0
    return replace(
        plate,
        pixels=ReadPixels(np.ascontiguousarray(made.color), made.depth_m),
        has_alpha=has_alpha,
        fragments=made.lists,
        notes=(*plate.notes, *(report.sentence for report in reports)),
        behind=reports,
    )


def _depth_of(plate: Plate) -> FloatImage:
    if plate.depth_m is None:
        raise InputError(
            f"{plate.path} holds circles of confusion and no distances, so that it cannot be "
            "sorted with pictures behind it. Give --depth-convention and a depth channel."
        )
    return plate.depth_m


def _over_window(plate: Plate, window: Box) -> Surface:
    """Return the plate's pixels over `window`; without coverage where it has none."""
    planes = [
        moved_to_window(plate.color[..., k], plate.data_window, window, 0.0) for k in range(4)
    ]
    depth_m = moved_to_window(_depth_of(plate), plate.data_window, window, np.inf)
    return Surface(np.stack(planes, axis=-1), depth_m)


def _check_same_view(plate: Plate, other: Plate) -> None:
    if plate.display_window != other.display_window:
        raise InputError(
            f"{other.path} shows another picture than {plate.path}: its display window is "
            f"{_size_words(other.display_window)}, that of the plate "
            f"{_size_words(plate.display_window)}. Render both with the same camera and size."
        )


def _size_words(box: Box) -> str:
    return f"{box.width}x{box.height} at {box.x0}, {box.y0}"
