"""Deep EXR to a plate: samples are mended, sorted, merged to what a lens tells, and flattened."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from heatlens.errors import InputError
from heatlens.files.quiet import quiet_library
from heatlens.model.plate_options import DepthConvention, DepthKind, PlateOptions
from heatlens.plate.bounds import DEPTH_LEAST_M, LIGHT_MOST
from heatlens.plate.camera_header import camera_at_header
from heatlens.plate.carried import carried
from heatlens.plate.channels import Header, is_deep, list_channels
from heatlens.plate.deep_file import DeepSamples, read_deep_samples
from heatlens.plate.depth import finite_range
from heatlens.plate.depth_guess import INFINITE_FROM
from heatlens.plate.fragments import LEAST_COVERAGE, OPAQUE, FragmentLists, packed_lists
from heatlens.plate.plate import DepthReport, Plate, ReadPixels
from heatlens.plate.windows import pixel_aspect_of

SAME_SURFACE = 0.01  # of the distance: samples of a pixel within this are one surface
FRAGMENTS_MOST = 16  # of a pixel; more are merged by likeness
_ALMOST_OPAQUE = 1.0 - 1e-7  # its logarithm is finite


def read_deep_plate(path: Path, options: PlateOptions) -> Plate:
    """Read the picture that a deep file holds, with all that it tells behind it.

    Distances are Z, or the middle between Z and ZBack where a sample lets light through. Raises
    InputError as `read_deep_samples`, and for options that a deep file cannot follow.
    """
    _check_options(path, options)
    samples = read_deep_samples(path, options.color_layer)
    header = _header_of(path)
    pixels, notes = _mended(path, samples, options.scene_unit_m)
    merged, merge_notes = _merged(path, pixels, samples.counts.size)
    shape = samples.data_window.shape
    color, depth_m, lists = _flattened(merged, samples.counts.size)
    aspect, aspect_notes = pixel_aspect_of(path, header)
    has_alpha = bool((color[:, 3] < OPAQUE).any())
    if not has_alpha:
        color[:, 3] = 1.0
    near_m, far_m = _range_of(depth_m)
    count = len(merged.depth_m) / samples.counts.size
    return Plate(
        path=path,
        pixels=ReadPixels(color.reshape(*shape, 4), depth_m.reshape(shape)),
        has_alpha=has_alpha,
        data_window=samples.data_window,
        display_window=samples.display_window,
        pixel_aspect_ratio=aspect,
        camera=camera_at_header([header]),
        depth=DepthReport(
            "Z",
            DepthConvention.DISTANCE,
            DepthKind.PLANAR,
            "Deep samples hold distances.",
            near_m,
            far_m,
            int(np.isinf(depth_m).sum()),
            0,
        ),
        aovs=tuple(ref.full_name for ref in list_channels([header])),
        attributes=carried(header),
        notes=(f"{path}: {count:.2f} surfaces a pixel.", *notes, *merge_notes, *aspect_notes),
        fragments=lists,
    )


def _range_of(depth_m: NDArray[np.float32]) -> tuple[float, float]:
    return finite_range(depth_m, int(np.isinf(depth_m).sum()))


def _check_options(path: Path, options: PlateOptions) -> None:
    if options.depth_convention not in (DepthConvention.AUTO, DepthConvention.DISTANCE):
        raise InputError(
            f"{path} is a deep file, which holds distances: leave --depth-convention out."
        )
    if options.depth_kind is DepthKind.RADIAL:
        raise InputError(
            f"{path} is a deep file; heatlens takes its distances along the optical axis: leave "
            "--depth-kind out."
        )
    if options.files_beside or options.depth_channel is not None:
        raise InputError(
            f"{path} is a deep file, which holds its depth and what is behind it: leave --depth, "
            "--depth-channel and --behind out."
        )


def _header_of(path: Path) -> Header:
    """Return the header of the first deep part. Raises InputError where the library fails."""
    try:
        with quiet_library():
            parts = OpenEXR.File(str(path), header_only=True).parts
    except (RuntimeError, ValueError, KeyError, TypeError, OSError) as error:
        raise InputError(f"{path} cannot be read: its header is damaged ({error}).") from error
    headers = [part.header for part in parts]
    return next((header for header in headers if is_deep(header)), headers[0])


@dataclass(frozen=True, eq=False)
class _Fragments:
    """Fragments sorted by pixel and distance: premultiplied colour (N, 3), coverage and metres."""

    pixel: NDArray[np.int64]
    color: NDArray[np.float32]
    alpha: NDArray[np.float32]
    depth_m: NDArray[np.float32]

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> "_Fragments":
        return _Fragments(
            self.pixel[chosen], self.color[chosen], self.alpha[chosen], self.depth_m[chosen]
        )


def _mended(path: Path, samples: DeepSamples, unit_m: float) -> tuple[_Fragments, tuple[str, ...]]:
    """Return samples that are surfaces, sorted, in metres, and sentences on those that are not."""
    color, alpha = samples.color.copy(), samples.alpha.copy()
    bad = ~np.isfinite(alpha) | ~np.isfinite(color).all(axis=1) | (alpha > 1 + 1e-3) | (alpha < 0)
    np.nan_to_num(color, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
    np.nan_to_num(alpha, copy=False, nan=0.0, posinf=1.0, neginf=0.0)
    np.clip(color, -LIGHT_MOST, LIGHT_MOST, out=color)
    np.clip(alpha, 0.0, 1.0, out=alpha)
    depth_m, has_depth = _distances(samples, alpha, unit_m)
    pixel = np.repeat(np.arange(samples.counts.size), samples.counts)
    all_of_them = _Fragments(pixel, color, alpha, depth_m)
    kept = all_of_them.where(has_depth & (alpha > LEAST_COVERAGE))
    sorted_ones = kept.where(np.lexsort((kept.depth_m, kept.pixel)))
    unsorted = int((kept.depth_m != sorted_ones.depth_m).sum())
    notes = [
        (int((~has_depth).sum()), "are at no distance that can be, and were left out"),
        (int(bad.sum()), "have a colour or coverage that cannot be, and were brought into bounds"),
        (unsorted, "were not in the order of their distance"),
    ]
    size = len(alpha)
    return sorted_ones, tuple(
        f"{path}: {count} of {size} samples {said}." for count, said in notes if count
    )


def _distances(
    samples: DeepSamples, alpha: NDArray[np.float32], unit_m: float
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return metres, +inf where nothing was hit, and which samples have a distance at all."""
    z, back = samples.z, samples.back
    has_back = np.isfinite(back) & (back > z) & (alpha < OPAQUE)
    with np.errstate(invalid="ignore", over="ignore"):
        depth = np.where(has_back, z + (back - z) / 2, z)
        is_infinite = (z >= INFINITE_FROM) | np.isposinf(z)
        depth_m = np.where(is_infinite, np.inf, depth * np.float32(unit_m)).astype(np.float32)
    return depth_m, is_infinite | (depth_m >= DEPTH_LEAST_M)


def _merged(
    path: Path, fragments: _Fragments, pixel_count: int
) -> tuple[_Fragments, tuple[str, ...]]:
    """Return one fragment for what of a pixel no lens can tell apart, at most FRAGMENTS_MOST."""
    # The sky is a surface of its own, behind all others.
    far = np.log(np.where(np.isinf(fragments.depth_m), np.float32(1e30), fragments.depth_m))
    merged = _one_of_each(fragments, np.floor(far / SAME_SURFACE).astype(np.int64))
    counts = np.bincount(merged.pixel, minlength=pixel_count)
    is_long = counts > FRAGMENTS_MOST
    if not is_long.any():
        return merged, ()
    rank = np.arange(len(merged.pixel)) - (np.cumsum(counts) - counts)[merged.pixel]
    shorter = rank * FRAGMENTS_MOST // counts[merged.pixel]
    said = (
        f"{path}: {int(is_long.sum())} pixels have more than {FRAGMENTS_MOST} surfaces, up to "
        f"{int(counts.max())}: neighbours in depth were merged."
    )
    return _one_of_each(merged, np.where(is_long[merged.pixel], shorter, rank)), (said,)


def _one_of_each(fragments: _Fragments, key: NDArray[np.int64]) -> _Fragments:
    """Composite neighbours with the same pixel and key, near to far, to one fragment each."""
    begins = np.ones(len(key), bool)
    begins[1:] = (fragments.pixel[1:] != fragments.pixel[:-1]) | (key[1:] != key[:-1])
    if begins.all():
        return fragments
    first = np.flatnonzero(begins)
    whole = fragments.where(first)
    seen = _seen(fragments, first, np.cumsum(begins) - 1)
    weight = seen * fragments.alpha
    color = np.add.reduceat(seen[:, None] * fragments.color, first, axis=0)
    alpha = np.add.reduceat(weight, first)
    finite = np.where(np.isinf(fragments.depth_m), 0.0, fragments.depth_m)
    depth = np.add.reduceat(weight * finite, first) / np.maximum(alpha, 1e-30)
    is_single = np.diff(np.append(first, len(key))) == 1
    is_exact = is_single | np.isinf(whole.depth_m)
    return _Fragments(
        whole.pixel,
        np.where(is_single[:, None], whole.color, color).astype(np.float32),
        np.where(is_single, whole.alpha, np.where(alpha > OPAQUE, 1.0, alpha)).astype(np.float32),
        np.where(is_exact, whole.depth_m, depth).astype(np.float32),
    )


def _seen(
    fragments: _Fragments, first: NDArray[np.int64], group: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return what of its group is still seen at each fragment: the product of 1 - alpha so far."""
    passed = np.log1p(-np.minimum(fragments.alpha.astype(np.float64), _ALMOST_OPAQUE))
    so_far = np.cumsum(passed) - passed
    return np.asarray(np.exp(so_far - so_far[first][group]), np.float64)


def _flattened(
    fragments: _Fragments, pixel_count: int
) -> tuple[NDArray[np.float32], NDArray[np.float32], FragmentLists | None]:
    """Return premultiplied RGBA (P, 4), the nearest metres (P,), and the lists."""
    pixel = fragments.pixel
    counts = np.bincount(pixel, minlength=pixel_count)
    starts = np.cumsum(counts) - counts
    rank = np.arange(len(pixel)) - starts[pixel]
    color = np.zeros((pixel_count, 4), np.float32)
    for step in range(int(counts.max(initial=0))):
        here = np.flatnonzero(rank == step)
        at = pixel[here]
        seen = 1.0 - color[at, 3:]
        color[at, :3] += seen * fragments.color[here]
        color[at, 3:] += seen * fragments.alpha[here][:, None]
    depth_m = np.full(pixel_count, np.inf, np.float32)
    has_any = counts > 0
    depth_m[has_any] = fragments.depth_m[starts[has_any]]
    is_opaque = np.zeros(pixel_count, bool)
    is_opaque[has_any] = fragments.alpha[starts[has_any]] >= OPAQUE
    has_front = ~is_opaque & (counts > 1)
    is_listed = ((rank > 0) | has_front[pixel]) & (counts[pixel] > 1)
    if not is_listed.any():
        return color, depth_m, None
    listed = fragments.where(is_listed)
    rgba = np.concatenate([listed.color / listed.alpha[:, None], listed.alpha[:, None]], axis=1)
    list_counts = np.bincount(listed.pixel, minlength=pixel_count)
    is_measured = bool((fragments.alpha < OPAQUE).any())
    return color, depth_m, packed_lists(list_counts, has_front, rgba, listed.depth_m, is_measured)
