"""Surfaces hidden behind a plate: from other files, or from parts and layers of its own file."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.deep.stacked import (
    Stacked,
    Surface,
    farthest_m,
    move_lists,
    stack_surfaces,
)
from heatlens.media.plate.depth.depth import finite_range
from heatlens.media.plate.fragments import LEAST_COVERAGE, OPAQUE, SAME_DEPTH, FloatImage
from heatlens.media.plate.plate import BehindReport, Plate, ReadPixels
from heatlens.media.plate.windows import move_to_window


def layer_options(options: PlateOptions, layer: str) -> PlateOptions:
    """Return the options for reading a layer of the plate's own file.

    The depth channel of the layer is found by its name.
    """
    layer_only = replace(options, depth_channel=None, depth_source=None, depth_model=None)
    layer_only = replace(layer_only, never_blur=None, only_blur=None)
    return replace(layer_only, color_layer=layer, behind=(), behind_conventions=())


def file_options(options: PlateOptions, number: int) -> PlateOptions:
    """Return the options for reading file `number` of those behind the plate.

    Its channels are found by their names.
    """
    file_only = replace(
        layer_options(options, ""),
        color_layer=None,
        depth_convention=_convention_behind(options, number),
    )
    if file_only.depth_convention.facts.takes_ends:
        return file_only
    return replace(file_only, near_m=None, far_m=None)


def deep_options(options: PlateOptions) -> PlateOptions:
    """Return the options for a deep file behind the plate, without those of flat depth channels."""
    return replace(
        options,
        depth_convention=DepthConvention.AUTO,
        depth_kind=DepthKind.AUTO,
        near_m=None,
        far_m=None,
        despike=False,
        flat_depth=None,
    )


def _convention_behind(options: PlateOptions, number: int) -> DepthConvention:
    """Return the depth convention of a file behind.

    A convention that was given together with a separate depth file applies to that file only.
    """
    if options.behind_conventions:
        return options.behind_conventions[number]
    return options.depth_convention if options.depth_source is None else DepthConvention.AUTO


def with_behind(plate: Plate, behind: Sequence[Plate], names: Sequence[str] = ()) -> Plate:
    """Return the plate combined with the surfaces of other plates behind it, or in front of it.

    `names` are used in the reports; the default is the path of each plate. Each pixel is sorted by
    depth. Data windows may differ; pixels outside the plate's own data window are left out. Raises
    InputError where the display windows differ, and for plates that hold circles of confusion.
    """
    if not behind:
        return plate
    front, surfaces_behind = _surface_over(plate, plate.data_window), []
    for behind_plate in behind:
        _check_same_view(plate, behind_plate)
        surfaces_behind.append(
            _drop_shared_surfaces(_surface_over(behind_plate, plate.data_window), front)
        )
    stack = stack_surfaces(
        [front, *surfaces_behind], _is_coverage_measured(plate, front, behind, surfaces_behind)
    )
    names = names or [str(behind_plate.path) for behind_plate in behind]
    reports = tuple(
        _measure_coverage(name, behind_plate.depth.convention, surface, front, stack.depth_m)
        for name, behind_plate, surface in zip(names, behind, surfaces_behind, strict=True)
    )
    return _replace_picture(plate, stack, reports)


def _drop_shared_surfaces(behind_surface: Surface, front: Surface) -> Surface:
    """Return `behind_surface` without the pixels that show the same surface as the plate.

    Such pixels become transparent. A clean plate has the same distances as the plate beside the
    actor, but never exactly the same colors.
    """
    with np.errstate(invalid="ignore"):  # infinity minus infinity where both show the sky
        is_close = np.abs(behind_surface.depth_m - front.depth_m) <= SAME_DEPTH * front.depth_m
    is_twin = np.where(np.isinf(front.depth_m), np.isinf(behind_surface.depth_m), is_close)
    is_twin &= front.color[..., 3] >= OPAQUE
    if not is_twin.any():
        return behind_surface
    color = np.where(is_twin[..., None], np.float32(0.0), behind_surface.color)
    return replace(behind_surface, color=color)


def _is_coverage_measured(
    plate: Plate, front: Surface, behind: Sequence[Plate], surfaces_behind: Sequence[Surface]
) -> bool:
    """Return True if the coverage of every visible surface was measured, by samples or by alpha."""
    if plate.fragments is None or not plate.fragments.is_measured:
        return False
    return all(
        behind_plate.has_alpha or not _mask_in_front(surface, front).any()
        for behind_plate, surface in zip(behind, surfaces_behind, strict=True)
    )


def _measure_coverage(
    name: str, convention: DepthConvention, added: Surface, front: Surface, nearest_m: FloatImage
) -> BehindReport:
    """Return the shares of the pixels that `added` covers behind the plate and in front of it.

    `nearest_m` (H, W) is the depth of the nearest of all surfaces.
    """
    is_hidden = _mask_covered(added) & (farthest_m(added) > (1 + SAME_DEPTH) * nearest_m)
    is_seen = _mask_in_front(added, front)
    return BehindReport(name, float(is_hidden.mean()), float(is_seen.mean()), convention)


def _mask_in_front(added: Surface, front: Surface) -> NDArray[np.bool_]:
    """Return a mask (H, W) of the pixels in which `added` lies in front of `front`."""
    front_m = np.where(_mask_covered(front), front.depth_m, np.float32(np.inf))
    return _mask_covered(added) & (added.depth_m < np.float32(1 - SAME_DEPTH) * front_m)


def _mask_covered(surface: Surface) -> NDArray[np.bool_]:
    """Return a mask (H, W) of the pixels that the surface covers at least in part."""
    is_there: NDArray[np.bool_] = surface.color[..., 3] > LEAST_COVERAGE
    return is_there


def _replace_picture(plate: Plate, stack: Stacked, reports: tuple[BehindReport, ...]) -> Plate:
    """Return the plate with the composite of all surfaces; it has alpha only if it had before."""
    has_alpha = plate.has_alpha and bool((stack.color[..., 3] < 1.0).any())
    if not has_alpha:
        stack.color[..., 3] = 1.0
    infinite_count = int(np.isinf(stack.depth_m).sum())
    near_m, far_m = finite_range(stack.depth_m, infinite_count)
    depth_report = replace(plate.depth, near_m=near_m, far_m=far_m, infinite_count=infinite_count)
    merge_note = ""
    if stack.merged_pixels:
        merge_note = (
            f"{plate.path}: surfaces of the most similar blur were merged in {stack.merged_pixels} "
            f"pixels, which have up to {stack.most_in_pixel} of them."
        )
    return replace(
        plate,
        pixels=ReadPixels(stack.color, stack.depth_m),
        has_alpha=has_alpha,
        depth=depth_report,
        fragments=stack.lists,
        notes=(
            *plate.notes,
            *(report.sentence for report in reports),
            *filter(None, (merge_note,)),
        ),
        surfaces_lost=plate.surfaces_lost or merge_note,
        behind=(*plate.behind, *reports),
    )


def _require_depth_m(plate: Plate) -> FloatImage:
    """Return the depth of a plate in meters. Raises InputError if it has circles of confusion."""
    if plate.depth_m is None:
        raise InputError(
            f"{plate.path} holds circles of confusion and no distances, so it cannot be sorted "
            "with pictures behind it. Give --depth-convention and a depth channel."
        )
    return plate.depth_m


def _surface_over(plate: Plate, window: Box) -> Surface:
    """Return the plate's pixels over `window`; coverage is 0 outside the plate's data window."""
    depth_m, lists = _require_depth_m(plate), plate.fragments
    if plate.data_window == window:
        return Surface(plate.color, depth_m, lists)
    planes = [move_to_window(plate.color[..., k], plate.data_window, window, 0.0) for k in range(4)]
    depth_m = move_to_window(depth_m, plate.data_window, window, np.inf)
    lists = None if lists is None else move_lists(lists, plate.data_window, window)
    return Surface(np.stack(planes, axis=-1), depth_m, lists)


def _check_same_view(plate: Plate, behind_plate: Plate) -> None:
    """Raise InputError if the display windows of the two plates differ."""
    if plate.display_window != behind_plate.display_window:
        raise InputError(
            f"{behind_plate.path} does not show the same view as {plate.path}: its display "
            "window is "
            f"{_size_words(behind_plate.display_window)}, that of the plate "
            f"{_size_words(plate.display_window)}. Render both with the same camera and size."
        )


def _size_words(box: Box) -> str:
    return f"{box.width}x{box.height} at {box.x0}, {box.y0}"
