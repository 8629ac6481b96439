"""Make a plate of a scene's picture without a lens, with overscan and the surfaces behind it."""

import os
from dataclasses import dataclass, replace

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.deep.deep_write import check_deep_fits
from heatlens.media.plate.fragments import FragmentLists
from heatlens.media.plate.plate import Plate, ReadPixels
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.scene_gpu.peel import Peeled
from heatlens.render.scene_gpu.pinhole_draw import PINHOLE_VIEWS
from heatlens.render.source.pinhole import Pinhole

AUTO = "auto"


@dataclass(frozen=True)
class PinholeOptions:
    """The options of a plate of a scene.

    overscan  pixels on every side; `AUTO` for as many as the lens needs; None for no overscan
    deep      True to include the surfaces behind the picture
    """

    overscan: int | str | None = None
    deep: bool = False


def pinhole_plate(
    renderer: FrameRenderer,
    shot: Shot,
    frame: int,
    options: PinholeOptions,
    path: str | os.PathLike[str],
) -> Plate:
    """Return the scene's picture at a frame, which will be written to `path`.

    Raises InputError for more overscan than is drawn, and for a deep picture that needs too much
    memory.
    """
    loaded = renderer.look(shot, frame, PINHOLE_VIEWS, is_for_file=options.deep)
    if options == PinholeOptions():
        return loaded.plate
    margin_px = options.overscan or 0
    if isinstance(margin_px, str):
        overscan = loaded.overscan
        own = None if overscan is None else overscan.in_own_pixels  # in the pixels of the file
        margin_px = 0 if own is None else own.needed_px(renderer.optics(shot, frame))
    if not options.deep:
        return with_overscan(loaded, margin_px)
    width, height = (side + 2 * margin_px for side in loaded.color.size)
    check_deep_fits(path, width, height)
    return with_overscan(loaded, margin_px, loaded.peeled)


def with_overscan(pinhole: Pinhole, margin_px: int, peeled: Peeled | None = None) -> Plate:
    """Return a scene's picture in memory, with a margin on every side.

    `peeled` has the known surfaces behind everything drawn, pixel by pixel. Raises InputError for a
    margin that is wider than what was drawn.
    """
    overscan, plate = pinhole.overscan, pinhole.plate
    most = 0 if overscan is None else overscan.margin_px
    if margin_px > most or overscan is None:
        frame = plate.display_window
        raise InputError(
            f"{plate.path}: {margin_px} pixels of overscan are too many for a picture of "
            f"{frame.width}x{frame.height}: at most {most}."
        )
    frame, own = plate.display_window, overscan.in_own_pixels
    color_tx, depth_tx = own.color, own.depth
    cut, width = most - margin_px, color_tx.width
    part = Box(cut, cut, width - cut, color_tx.height - cut)
    rows, columns = slice(part.y0, part.y1), slice(part.x0, part.x1)
    color = download(color_tx)[rows, columns]
    depth_m = download(depth_tx if peeled is None else peeled.depth)[rows, columns]
    lists = None if peeled is None else _cut(peeled.read(), part, width)
    window = Box(-margin_px, -margin_px, frame.width + margin_px, frame.height + margin_px)
    pixels = ReadPixels(np.ascontiguousarray(color), np.ascontiguousarray(depth_m))
    return replace(plate, pixels=pixels, data_window=window, fragments=lists)


def _cut(lists: FragmentLists, part: Box, stride: int) -> FragmentLists:
    """Return the lists for a part of the picture; rows of the picture have `stride` pixels."""
    begins = (lists.starts >> 1).astype(np.int64)
    pixels = np.arange(part.y0, part.y1)[:, None] * stride + np.arange(part.x0, part.x1)
    chosen = pixels.ravel()
    counts = begins[chosen + 1] - begins[chosen]
    starts = np.zeros(len(chosen) + 1, np.uint32)
    starts[1:] = 2 * np.cumsum(counts)
    starts[:-1] += lists.starts[chosen] & 1
    first = np.cumsum(counts) - counts
    at = np.repeat(begins[chosen] - first, counts) + np.arange(int(counts.sum()))
    return FragmentLists(starts, lists.words[at], lists.is_measured)
