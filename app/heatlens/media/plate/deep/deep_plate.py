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
    slice_volumes,
    sort_fragments,
)
from heatlens.media.plate.deep.stacked import (
    SAME_SURFACE,
    ListBuilder,
    Stacked,
    enclosing_window,
    move_stack,
)
from heatlens.media.plate.depth.depth import finite_range
from heatlens.media.plate.depth.raw_depth import INFINITE_FROM
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M, LIGHT_MOST
from heatlens.media.plate.exr.exr_read import DeepChannels, choose_deep_channels
from heatlens.media.plate.fragments import LEAST_COVERAGE, OPAQUE
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.header.channels import Header, Part, list_channels, views_of
from heatlens.media.plate.header.entries import attributes_to_keep
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import BehindReport, DepthReport, Plate, ReadPixels
from heatlens.media.plate.windows import pixel_aspect_of, read_header_window


def read_deep_plate(path: Path, options: PlateOptions) -> Plate:
    """Read the flattened picture of a deep file, with the surfaces behind it as fragment lists.

    The picture covers the display window too: where a deep file has no samples it is empty.
    Distances are Z; a transparent sample with a thickness is cut into slices between Z and ZBack.
    Raises InputError for a damaged file, and for options that do not apply to a deep file.
    """
    _check_options(path, options)
    headers = read_headers(path)
    channels = choose_deep_channels(path, headers, options.color_layer, options.eye)
    header = headers[channels.part]
    part, data_window = DeepPart(path, channels.part), read_header_window(header, "dataWindow")
    stack, faults = _read_stack(part, channels, options.scene_unit_m)
    display = read_header_window(header, "displayWindow")
    window = enclosing_window(data_window, display)
    stack = move_stack(stack, data_window, window)
    aspect, aspect_notes = pixel_aspect_of(path, header)
    has_alpha = bool((stack.color[..., 3] < OPAQUE).any())
    if not has_alpha:
        stack.color[..., 3] = 1.0
    merge_note = _merge_sentence(path, stack)
    notes = (_surfaces_sentence(path, stack), *channels.color.notes, *faults.sentences(path))
    return Plate(
        path=path,
        pixels=ReadPixels(stack.color, stack.depth_m),
        has_alpha=has_alpha,
        data_window=window,
        display_window=display,
        pixel_aspect_ratio=aspect,
        camera=camera_at_header([header, *headers]),
        depth=_depth_report(channels, stack),
        aovs=tuple(ref.full_name for ref in list_channels(headers)),
        attributes=_output_attributes(header, channels),
        notes=(*notes, *filter(None, [merge_note]), *aspect_notes),
        views=views_of(headers),
        fragments=stack.lists,
        surfaces_lost=merge_note,
        behind=() if stack.lists is None else (_report_hidden(stack),),
    )


def read_flattened_part(path: Path) -> Part:
    """Return the header and the flattened channels R, G, B, A and Z of a deep file.

    Raises InputError as `read_deep_plate` does.
    """
    headers = read_headers(path)
    channels = choose_deep_channels(path, headers, layer=None, eye=None)
    stack, _ = _read_stack(DeepPart(path, channels.part), channels, unit_m=1.0)
    pixels: dict[str, NDArray[np.generic]] = {}
    pixels |= {name: stack.color[..., k] for k, name in enumerate("RGBA")} | {"Z": stack.depth_m}
    channel_list = [SimpleNamespace(name=name, xSampling=1, ySampling=1) for name in pixels]
    header = headers[channels.part] | {"channels": channel_list, "type": OpenEXR.scanlineimage}
    return header, pixels


def _output_attributes(header: Header, channels: DeepChannels) -> Header:
    """Return the attributes of the header that output files keep, with the view that was read."""
    view = channels.color.view
    return attributes_to_keep(header) | ({"view": view} if view else {})


def _depth_report(channels: DeepChannels, stack: Stacked) -> DepthReport:
    """Return the report on the distances of the flattened picture."""
    infinite_count = int(np.isinf(stack.depth_m).sum())
    near_m, far_m = finite_range(stack.depth_m, infinite_count)
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


def _report_hidden(stack: Stacked) -> BehindReport:
    """Report the share of the pixels that have samples behind the nearest surface."""
    assert stack.lists is not None
    counts = np.diff(stack.lists.begins)
    return BehindReport("What the deep samples hold", float((counts > 0).mean()), 0.0)


def _surfaces_sentence(path: Path, stack: Stacked) -> str:
    """Return a sentence on the mean and the greatest number of surfaces of a pixel."""
    return (
        f"{path}: {stack.surface_count / stack.depth_m.size:.2f} surfaces a pixel on average, at "
        "most "
        f"{stack.most_in_pixel}."
    )


def _merge_sentence(path: Path, stack: Stacked) -> str:
    """Return a sentence on the pixels whose fragments were merged; "" if there are none."""
    if not stack.merged_pixels:
        return ""
    return (
        f"{path}: {stack.merged_pixels} pixels have more than {FRAGMENTS_MOST} surfaces, up to "
        f"{stack.most_in_pixel}: those of the most similar blur were merged."
    )


def _check_options(path: Path, options: PlateOptions) -> None:
    """Raise InputError for options that do not apply to a deep file."""
    if options.depth_convention not in (DepthConvention.AUTO, DepthConvention.DISTANCE):
        raise InputError(
            f"{path} is a deep file, which holds distances: leave --depth-convention out."
        )
    if options.depth_kind is DepthKind.RADIAL:
        raise InputError(
            f"{path} is a deep file; heatlens takes its distances along the optical axis: leave "
            "--depth-kind out."
        )
    depth_options = (options.depth_source, options.depth_channel, options.depth_model)
    if any(option is not None for option in depth_options):
        raise InputError(
            f"{path} is a deep file, which holds its depth: leave --depth, --depth-channel and "
            "--depth-model out."
        )
    if options.despike:
        raise InputError(
            f"{path} is a deep file, whose samples are taken as they are: denoise it where it is "
            "rendered, and leave --despike out."
        )


def _read_stack(part: DeepPart, channels: DeepChannels, unit_m: float) -> tuple[Stacked, "_Faults"]:
    """Return the picture with its fragment lists, and counts of faulty samples."""
    (height, width), numbers = part.shape, [part.channel_numbers[name] for name in channels.names]
    builder, faults, has_transparent = ListBuilder(height, width, SAME_SURFACE), _Faults(), False
    for band in part.bands(numbers):
        columns = [band.values[number] for number in numbers]
        samples = DeepSamples(
            pixel=np.repeat(np.arange(band.counts.size), band.counts),
            color=np.stack(columns[:3], axis=1),
            alpha=columns[3],
            z=columns[4],
            back=columns[5] if len(columns) > 5 else columns[4].copy(),
        )
        fragments = _repair_samples(samples, unit_m, faults)
        has_transparent |= bool((fragments.alpha < OPAQUE).any())
        builder.add(band.first_row, band.first_row + band.counts.size // width, fragments)
    return builder.finish(is_measured=has_transparent), faults


@dataclass
class _Faults:
    """Counts of samples that had to be repaired, sorted or sliced."""

    sample_count: int = 0
    without_distance: int = 0
    clamped: int = 0
    unsorted: int = 0
    sliced: int = 0

    def sentences(self, path: Path) -> tuple[str, ...]:
        """Return a sentence for each kind of fault that occurred."""
        kinds = (
            (self.without_distance, "have an impossible distance and were left out"),
            (self.clamped, "have an impossible colour or coverage and were clamped"),
            (self.unsorted, "were not sorted by distance"),
            (self.sliced, "are thick and let light through, and were cut into slices"),
        )
        return tuple(
            f"{path}: {count} of {self.sample_count} samples {words}."
            for count, words in kinds
            if count
        )


def _repair_samples(samples: DeepSamples, unit_m: float, faults: _Faults) -> Fragments:
    """Return the usable samples as fragments, sorted and in meters; count faults in `faults`."""
    color, alpha = samples.color, samples.alpha
    is_good = np.isfinite(color).all(axis=1) & (alpha >= 0) & (alpha <= 1 + 1e-3)
    is_good &= np.abs(color).max(axis=1, initial=0.0) <= LIGHT_MOST
    if not is_good.all():
        bad_colors = color[~is_good]
        np.nan_to_num(bad_colors, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
        color[~is_good] = np.clip(bad_colors, -LIGHT_MOST, LIGHT_MOST)
        np.nan_to_num(alpha, copy=False, nan=0.0, posinf=1.0, neginf=0.0)
    np.clip(alpha, 0.0, 1.0, out=alpha)
    has_depth = _settle_distances(samples, unit_m)
    faults.sample_count += len(alpha)
    faults.without_distance += int((~has_depth).sum())
    faults.clamped += int((~is_good).sum())
    is_usable = has_depth & (alpha > LEAST_COVERAGE)
    samples = samples if is_usable.all() else samples.select(is_usable)
    faults.unsorted += _unsorted_count(samples)
    fragments, sliced_count = slice_volumes(samples)
    faults.sliced += sliced_count
    return sort_fragments(fragments)


def _settle_distances(samples: DeepSamples, unit_m: float) -> NDArray[np.bool_]:
    """Convert `z` and `back` of the samples to meters in place, infinite where nothing was hit.

    Returns a mask of the samples that have a valid distance. A sample that begins behind the camera
    is cut off at the lens.
    """
    z, back = samples.z, samples.back
    with np.errstate(invalid="ignore"):
        np.minimum(back, np.float32(INFINITE_FROM), out=back)
        is_thin = ~np.isfinite(back) | ~(back > z) | (samples.alpha >= OPAQUE)
        z[z >= INFINITE_FROM] = np.inf
    back[is_thin] = z[is_thin]
    np.maximum(z, 0.0, out=z, where=~is_thin)
    for distances in (z, back):
        distances *= np.float32(unit_m)
    has_depth: NDArray[np.bool_] = back >= DEPTH_LEAST_M
    return has_depth


def _unsorted_count(samples: DeepSamples) -> int:
    """Return how many samples are at another position after sorting each pixel by distance."""
    is_same_pixel = samples.pixel[1:] == samples.pixel[:-1]
    if not (is_same_pixel & (samples.z[1:] < samples.z[:-1])).any():
        return 0
    order = np.lexsort((samples.z, samples.pixel))
    return int((samples.z != samples.z[order]).sum())
