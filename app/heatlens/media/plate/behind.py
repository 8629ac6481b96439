"""Surfaces hidden behind a plate: from other files, or from parts and layers of its own file."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.deep.stacked import Stacked, Surface, farthest_m, lists_over, stacked
from heatlens.media.plate.depth.depth import finite_range
from heatlens.media.plate.fragments import LEAST_COVERAGE, OPAQUE, SAME_DEPTH, FloatImage
from heatlens.media.plate.plate import BehindReport, Plate, ReadPixels
from heatlens.media.plate.windows import moved_to_window
from heatlens.media.sequence.depth_files import beside_path


def layer_options(options: PlateOptions, layer: str) -> PlateOptions:
    """Return how to read a layer of the plate's own file; its depth is found by its name."""
    own = replace(options, depth_channel=None, depth_source=None, depth_model=None)
    own = replace(own, never_blur=None, only_blur=None)
    return replace(own, color_layer=layer, behind=(), behind_conventions=())


def file_options(options: PlateOptions, number: int) -> PlateOptions:
    """Return how to read the file behind with this index; its channels are found by their names."""
    own = replace(
        layer_options(options, ""), color_layer=None, depth_convention=_convention(options, number)
    )
    if own.depth_convention.facts.takes_ends:
        return own
    return replace(own, near_m=None, far_m=None)


def deep_options(options: PlateOptions) -> PlateOptions:
    """Return how to read a deep file behind: options about flat depth channels do not apply."""
    return replace(
        options,
        depth_convention=DepthConvention.AUTO,
        depth_kind=DepthKind.AUTO,
        near_m=None,
        far_m=None,
        despike=False,
        flat_depth=None,
    )


def _convention(options: PlateOptions, number: int) -> DepthConvention:
    """Return the depth convention of a file behind.

    A convention that was given together with a separate depth file applies to that file only.
    """
    if options.behind_conventions:
        return options.behind_conventions[number]
    return options.depth_convention if options.depth_source is None else DepthConvention.AUTO


def behind_paths(path: Path, options: PlateOptions) -> tuple[Path, ...]:
    """Return the files behind the plate at `path`; a pattern gives its frame of the same number."""
    return tuple(beside_path(path, text, "--behind", "picture behind") for text in options.behind)


def with_behind(plate: Plate, behind: Sequence[Plate], names: Sequence[str] = ()) -> Plate:
    """Return the plate with the surfaces of other plates behind it, or in front of it.

    `names` are used in the reports; the default is the path of each plate. Each pixel is sorted by
    depth. Data windows may differ; pixels outside the plate's own data window are left out. Raises
    InputError where the display windows differ, and for plates that hold circles of confusion.
    """
    if not behind:
        return plate
    front, others = _surface(plate, plate.data_window), []
    for other in behind:
        _check_same_view(plate, other)
        others.append(_without_twins(_surface(other, plate.data_window), front))
    made = stacked([front, *others], _is_measured(plate, front, behind, others))
    names = names or [str(other.path) for other in behind]
    reports = tuple(
        _report(name, other.depth.convention, surface, front, made.depth_m)
        for name, other, surface in zip(names, behind, others, strict=True)
    )
    return _restacked(plate, made, reports)


def _without_twins(other: Surface, front: Surface) -> Surface:
    """Return `other` without the pixels in which it shows the same surface as the plate.

    A clean plate has the same distances beside the actor, but never exactly the same colours.
    """
    with np.errstate(invalid="ignore"):  # the sky in front of the sky
        is_close = np.abs(other.depth_m - front.depth_m) <= SAME_DEPTH * front.depth_m
    is_twin = np.where(np.isinf(front.depth_m), np.isinf(other.depth_m), is_close)
    is_twin &= front.color[..., 3] >= OPAQUE
    if not is_twin.any():
        return other
    color = np.where(is_twin[..., None], np.float32(0.0), other.color)
    return replace(other, color=color)


def _is_measured(
    plate: Plate, front: Surface, behind: Sequence[Plate], others: Sequence[Surface]
) -> bool:
    """Return True if the coverage of every visible surface was measured, by samples or by alpha."""
    if plate.fragments is None or not plate.fragments.is_measured:
        return False
    return all(
        other.has_alpha or not _is_seen(surface, front).any()
        for other, surface in zip(behind, others, strict=True)
    )


def _report(
    name: str,
    convention: DepthConvention,
    added: Surface,
    front: Surface,
    nearest_m: FloatImage,
) -> BehindReport:
    """Return which share of the pixels `added` covers behind the plate, and in front of it."""
    is_hidden = _is_there(added) & (farthest_m(added) > (1 + SAME_DEPTH) * nearest_m)
    is_seen = _is_seen(added, front)
    return BehindReport(name, float(is_hidden.mean()), float(is_seen.mean()), convention)


def _is_seen(added: Surface, front: Surface) -> NDArray[np.bool_]:
    front_m = np.where(_is_there(front), front.depth_m, np.float32(np.inf))
    return _is_there(added) & (added.depth_m < np.float32(1 - SAME_DEPTH) * front_m)


def _is_there(surface: Surface) -> NDArray[np.bool_]:
    is_there: NDArray[np.bool_] = surface.color[..., 3] > LEAST_COVERAGE
    return is_there


def _restacked(plate: Plate, made: Stacked, reports: tuple[BehindReport, ...]) -> Plate:
    """Return the plate with the composite of all surfaces; it has alpha only if it had before."""
    has_alpha = plate.has_alpha and bool((made.color[..., 3] < 1.0).any())
    if not has_alpha:
        made.color[..., 3] = 1.0
    infinite_count = int(np.isinf(made.depth_m).sum())
    near_m, far_m = finite_range(made.depth_m, infinite_count)
    seen = replace(plate.depth, near_m=near_m, far_m=far_m, infinite_count=infinite_count)
    merged = ""
    if made.shortened:
        merged = (
            f"{plate.path}: surfaces of the most similar blur were merged in {made.shortened} "
            f"pixels, which have up to {made.most} of them."
        )
    return replace(
        plate,
        pixels=ReadPixels(made.color, made.depth_m),
        has_alpha=has_alpha,
        depth=seen,
        fragments=made.lists,
        notes=(
            *plate.notes,
            *(report.sentence for report in reports),
            *filter(None, (merged,)),
        ),
        surfaces_lost=plate.surfaces_lost or merged,
        behind=(*plate.behind, *reports),
    )


def _depth_of(plate: Plate) -> FloatImage:
    if plate.depth_m is None:
        raise InputError(
            f"{plate.path} holds circles of confusion and no distances, so it cannot be sorted "
            "with pictures behind it. Give --depth-convention and a depth channel."
        )
    return plate.depth_m


def _surface(plate: Plate, window: Box) -> Surface:
    """Return the plate's pixels over `window`; their coverage is 0 where the plate has none."""
    depth_m, lists = _depth_of(plate), plate.fragments
    if plate.data_window == window:
        return Surface(plate.color, depth_m, lists)
    planes = [
        moved_to_window(plate.color[..., k], plate.data_window, window, 0.0) for k in range(4)
    ]
    depth_m = moved_to_window(depth_m, plate.data_window, window, np.inf)
    lists = None if lists is None else lists_over(lists, plate.data_window, window)
    return Surface(np.stack(planes, axis=-1), depth_m, lists)


def _check_same_view(plate: Plate, other: Plate) -> None:
    if plate.display_window != other.display_window:
        raise InputError(
            f"{other.path} does not show the same view as {plate.path}: its display window is "
            f"{_size_words(other.display_window)}, that of the plate "
            f"{_size_words(plate.display_window)}. Render both with the same camera and size."
        )


def _size_words(box: Box) -> str:
    return f"{box.width}x{box.height} at {box.x0}, {box.y0}"
