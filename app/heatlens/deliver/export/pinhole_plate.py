"""Make a plate from a 3D scene: its picture without a lens, overscan and hidden surfaces."""

import os
from dataclasses import replace

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.options import PinholeOptions
from heatlens.media.plate.deep.deep_write import check_deep_fits
from heatlens.media.plate.fragments import FragmentLists, pack_starts
from heatlens.media.plate.plate import Plate, ReadPixels
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu.peel import Peeled
from heatlens.render.scene_gpu.pinhole_draw import PINHOLE_VIEWS
from heatlens.render.source.pinhole import Pinhole


def pinhole_plate(
    renderer: FrameRenderer,
    shot: Shot,
    frame: int,
    options: PinholeOptions,
    path: str | os.PathLike[str],
) -> Plate:
    """Return the sharp picture of a scene at a frame as a plate, which will be written to `path`.

    Raises InputError for more overscan than is drawn, and for a deep picture that needs too much
    memory.
    """
    view = renderer.load_pinhole(shot, frame, PINHOLE_VIEWS, is_for_file=options.deep)
    if options == PinholeOptions():
        return view.plate
    margin_px = options.overscan or 0
    if isinstance(margin_px, str):
        overscan = view.overscan
        # In the pixels of the file.
        own_pixels = None if overscan is None else overscan.in_picture_pixels
        margin_px = 0 if own_pixels is None else own_pixels.needed_px(renderer.optics(shot, frame))
    if not options.deep:
        return with_overscan(view, margin_px)
    width, height = (side + 2 * margin_px for side in view.color.size)
    check_deep_fits(path, width, height)
    return with_overscan(view, margin_px, view.peeled)


def with_overscan(pinhole: Pinhole, margin_px: int, peeled: Peeled | None = None) -> Plate:
    """Return a scene's picture as a plate in memory, with `margin_px` of overscan on every side.

    `peeled` has the known surfaces behind everything drawn, as lists for each pixel. Raises
    InputError for a margin that is wider than the drawn overscan.
    """
    overscan, plate = pinhole.overscan, pinhole.plate
    available_px = 0 if overscan is None else overscan.margin_px
    if margin_px > available_px or overscan is None:
        frame = plate.display_window
        raise InputError(
            f"{plate.path}: {margin_px} pixels of overscan are too many for a picture of "
            f"{frame.width}x{frame.height}: at most {available_px}."
        )
    frame, own_pixels = plate.display_window, overscan.in_picture_pixels
    color_tx, depth_tx = own_pixels.color, own_pixels.depth
    crop_px, width = available_px - margin_px, color_tx.width
    region = Box(crop_px, crop_px, width - crop_px, color_tx.height - crop_px)
    rows, columns = slice(region.y0, region.y1), slice(region.x0, region.x1)
    color = download(color_tx)[rows, columns]
    depth_m = download(depth_tx if peeled is None else peeled.depth)[rows, columns]
    lists = None if peeled is None else _crop_lists(peeled.read(), region, width)
    window = Box(-margin_px, -margin_px, frame.width + margin_px, frame.height + margin_px)
    pixels = ReadPixels(np.ascontiguousarray(color), np.ascontiguousarray(depth_m))
    return replace(plate, pixels=pixels, data_window=window, fragments=lists)


def _crop_lists(lists: FragmentLists, region: Box, stride: int) -> FragmentLists:
    """Return the deep-sample lists of a region of the picture, whose rows have `stride` pixels."""
    first_samples = lists.begins
    pixels = np.arange(region.y0, region.y1)[:, None] * stride + np.arange(region.x0, region.x1)
    region_pixels = pixels.ravel()
    counts = first_samples[region_pixels + 1] - first_samples[region_pixels]
    starts = pack_starts(counts, lists.has_front[region_pixels])
    new_first_samples = np.cumsum(counts) - counts
    sample_indices = np.repeat(
        first_samples[region_pixels] - new_first_samples, counts
    ) + np.arange(int(counts.sum()))
    return FragmentLists(starts, lists.words[sample_indices], lists.is_measured)
