"""Read a deep EXR as a plate: repair, sort, merge and flatten its samples."""

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.deep.deep_chunks import DeepPart
from heatlens.media.plate.deep.fragment_merge import (
    FRAGMENTS_MOST,
    DeepSamples,
    Fragments,
    in_order,
    without_volumes,
)
from heatlens.media.plate.deep.stacked import (
    SAME_SURFACE,
    ListBuilder,
    Stacked,
    stacked_over,
    window_of_all,
)
from heatlens.media.plate.depth.depth import finite_range
from heatlens.media.plate.depth.depth_guess import INFINITE_FROM
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M, LIGHT_MOST
from heatlens.media.plate.exr.exr_read import DeepChannels, deep_channels
from heatlens.media.plate.fragments import LEAST_COVERAGE, OPAQUE
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.header.channels import Header, Part, list_channels, views_of
from heatlens.media.plate.header.entries import carried
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import BehindReport, DepthReport, Plate, ReadPixels
from heatlens.media.plate.windows import box_at_header, pixel_aspect_of


def read_deep_plate(path: Path, options: PlateOptions) -> Plate:
    """Read the flattened picture of a deep file, with the surfaces behind it as fragment lists.

    The picture covers the display window too: where a deep file has no samples it is empty.
    Distances are Z; a transparent sample with a thickness is cut into slices between Z and ZBack.
    Raises InputError for a damaged file, and for options that do not apply to a deep file.
    """
    _check_options(path, options)
    headers = read_headers(path)
    channels = deep_channels(path, headers, options.color_layer, options.eye)
    header = headers[channels.part]
    part, cut = DeepPart(path, channels.part), box_at_header(header, "dataWindow")
    made, faults = _read(part, channels, options.scene_unit_m)
    display = box_at_header(header, "displayWindow")
    window = window_of_all(cut, display)
    made = stacked_over(made, cut, window)
    aspect, aspect_notes = pixel_aspect_of(path, header)
    has_alpha = bool((made.color[..., 3] < OPAQUE).any())
    if not has_alpha:
        made.color[..., 3] = 1.0
    lost = _merge_sentence(path, made)
    said = (_surfaces_sentence(path, made), *channels.color.notes, *faults.sentences(path))
    return Plate(
        path=path,
        pixels=ReadPixels(made.color, made.depth_m),
        has_alpha=has_alpha,
        data_window=window,
        display_window=display,
        pixel_aspect_ratio=aspect,
        camera=camera_at_header([header, *headers]),
        depth=_depth_report(channels, made),
        aovs=tuple(ref.full_name for ref in list_channels(headers)),
        attributes=_attributes(header, channels),
        notes=(*said, *filter(None, [lost]), *aspect_notes),
        views=views_of(headers),
        fragments=made.lists,
        surfaces_lost=lost,
        behind=() if made.lists is None else (_report(made),),
    )


def flattened_part(path: Path) -> Part:
    """Return the header and the flattened channels R, G, B, A and Z of a deep file.

    Raises InputError as `read_deep_plate` does.
    """
    headers = read_headers(path)
    channels = deep_channels(path, headers, None, None)
    made, _ = _read(DeepPart(path, channels.part), channels, 1.0)
    pixels: dict[str, NDArray[np.generic]] = {}
    pixels |= {name: made.color[..., k] for k, name in enumerate("RGBA")} | {"Z": made.depth_m}
    kept = [SimpleNamespace(name=name, xSampling=1, ySampling=1) for name in pixels]
    header = headers[channels.part] | {"channels": kept, "type": OpenEXR.scanlineimage}
    return header, pixels


def _attributes(header: Header, channels: DeepChannels) -> Header:
    view = channels.color.view
    return carried(header) | ({"view": view} if view else {})


def _depth_report(channels: DeepChannels, made: Stacked) -> DepthReport:
    infinite_count = int(np.isinf(made.depth_m).sum())
    near_m, far_m = finite_range(made.depth_m, infinite_count)
    return DepthReport(
        channel=channels.z.full_name,
        convention=DepthConvention.DISTANCE,
        kind=DepthKind.PLANAR,
        why="Deep samples hold distances.",
        near_m=near_m,
        far_m=far_m,
        infinite_count=infinite_count,
        repaired_count=0,
    )


def _report(made: Stacked) -> BehindReport:
    """Return the share of pixels with samples behind the nearest surface, as a sentence."""
    assert made.lists is not None
    counts = np.diff(made.lists.starts >> 1)
    return BehindReport("What the deep samples hold", float((counts > 0).mean()), 0.0)


def _surfaces_sentence(path: Path, made: Stacked) -> str:
    return (
        f"{path}: {made.count / made.depth_m.size:.2f} surfaces a pixel on average, at most "
        f"{made.most}."
    )


def _merge_sentence(path: Path, made: Stacked) -> str:
    """Return a sentence on fragments merged to save room; "" if none were."""
    if not made.shortened:
        return ""
    return (
        f"{path}: {made.shortened} pixels have more than {FRAGMENTS_MOST} surfaces, up to "
        f"{made.most}: those of the most similar blur were merged."
    )


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
    given = (options.depth_source, options.depth_channel, options.depth_model)
    if any(one is not None for one in given):
        raise InputError(
            f"{path} is a deep file, which holds its depth: leave --depth, --depth-channel and "
            "--depth-model out."
        )
    if options.despike:
        raise InputError(
            f"{path} is a deep file, whose samples are taken as they are: denoise it where it is "
            "rendered, and leave --despike out."
        )


def _read(part: DeepPart, channels: DeepChannels, unit_m: float) -> tuple[Stacked, "_Faults"]:
    """Return the picture with its fragment lists, and counts of faulty samples."""
    (height, width), numbers = part.shape, [part.numbers[name] for name in channels.names]
    made, faults, has_cover = ListBuilder(height, width, SAME_SURFACE), _Faults(), False
    for band in part.bands(numbers):
        columns = [band.values[number] for number in numbers]
        samples = DeepSamples(
            pixel=np.repeat(np.arange(band.counts.size), band.counts),
            color=np.stack(columns[:3], axis=1),
            alpha=columns[3],
            z=columns[4],
            back=columns[5] if len(columns) > 5 else columns[4].copy(),
        )
        fragments = _mended(samples, unit_m, faults)
        has_cover |= bool((fragments.alpha < OPAQUE).any())
        made.add(band.first_row, band.first_row + band.counts.size // width, fragments)
    return made.stacked(is_measured=has_cover), faults


@dataclass
class _Faults:
    """Counts of samples that had to be repaired, sorted or sliced."""

    size: int = 0
    nowhere: int = 0
    beyond: int = 0
    unsorted: int = 0
    cut: int = 0

    def sentences(self, path: Path) -> tuple[str, ...]:
        """Return a sentence for each kind of fault that occurred."""
        kinds = (
            (self.nowhere, "have an impossible distance and were left out"),
            (self.beyond, "have an impossible colour or coverage and were clamped"),
            (self.unsorted, "were not sorted by distance"),
            (self.cut, "are thick and let light through, and were cut into slices"),
        )
        return tuple(f"{path}: {n} of {self.size} samples {words}." for n, words in kinds if n)


def _mended(samples: DeepSamples, unit_m: float, faults: _Faults) -> Fragments:
    """Return the valid samples, sorted and in metres; count the others in `faults`."""
    color, alpha = samples.color, samples.alpha
    is_good = np.isfinite(color).all(axis=1) & (alpha >= 0) & (alpha <= 1 + 1e-3)
    is_good &= np.abs(color).max(axis=1, initial=0.0) <= LIGHT_MOST
    if not is_good.all():
        bad = color[~is_good]
        np.nan_to_num(bad, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
        color[~is_good] = np.clip(bad, -LIGHT_MOST, LIGHT_MOST)
        np.nan_to_num(alpha, copy=False, nan=0.0, posinf=1.0, neginf=0.0)
    np.clip(alpha, 0.0, 1.0, out=alpha)
    has_depth = _settle_distances(samples, unit_m)
    faults.size += len(alpha)
    faults.nowhere += int((~has_depth).sum())
    faults.beyond += int((~is_good).sum())
    usable = has_depth & (alpha > LEAST_COVERAGE)
    samples = samples if usable.all() else samples.where(usable)
    faults.unsorted += _unsorted_count(samples)
    fragments, cut = without_volumes(samples)
    faults.cut += cut
    return in_order(fragments)


def _settle_distances(samples: DeepSamples, unit_m: float) -> NDArray[np.bool_]:
    """Convert both ends of the samples to metres in place, infinite where nothing was hit.

    Return a mask of the samples that have a valid distance. A sample that begins behind the camera
    is cut off at the lens.
    """
    z, back = samples.z, samples.back
    with np.errstate(invalid="ignore"):
        np.minimum(back, np.float32(INFINITE_FROM), out=back)
        is_thin = ~np.isfinite(back) | ~(back > z) | (samples.alpha >= OPAQUE)
        z[z >= INFINITE_FROM] = np.inf
    back[is_thin] = z[is_thin]
    np.maximum(z, 0.0, out=z, where=~is_thin)
    for ends in (z, back):
        ends *= np.float32(unit_m)
    has_depth: NDArray[np.bool_] = back >= DEPTH_LEAST_M
    return has_depth


def _unsorted_count(samples: DeepSamples) -> int:
    """Return how many samples change their place when each pixel is sorted."""
    same = samples.pixel[1:] == samples.pixel[:-1]
    if not (same & (samples.z[1:] < samples.z[:-1])).any():
        return 0
    order = np.lexsort((samples.z, samples.pixel))
    return int((samples.z != samples.z[order]).sum())
