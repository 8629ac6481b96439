"""Extend a plate beyond its frame with pixels of neighbouring frames, for the blur to use."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from heatlens.model.boxes import Box
from heatlens.plate.neighbours.hidden import APART, packed
from heatlens.plate.neighbours.moved import Arrived, Canvas
from heatlens.plate.neighbours.view import FAR_M, Flags, depth_of
from heatlens.plate.plate import FloatImage, Plate, ReadPixels


def widened(plate: Plate, nearest_first: Sequence[Arrived], border_px: int) -> Plate:
    """Return the plate with `border_px` more on every side, as the frames nearest in time show it.

    What none of them shows repeats the pixel beside it. The plate stays as it is where no frame
    shows anything outside.
    """
    data = plate.data_window
    box = Box(*(at + by * border_px for at, by in zip(_ends(data), (-1, -1, 1, 1), strict=True)))
    inside = np.s_[border_px : border_px + data.height, border_px : border_px + data.width]
    color = np.zeros((*box.shape, 4), np.float32)
    depth_m = np.zeros(box.shape, np.float32)
    is_known = np.zeros(box.shape, bool)
    color[inside], is_known[inside] = plate.color, True
    depth_m[inside] = depth_of(plate)
    corner = box.x0 - plate.display_window.x0, box.y0 - plate.display_window.y0
    for arrived in nearest_first:
        _add(arrived, Canvas(corner, depth_m), color, is_known, border_px)
    if is_known.sum() == data.width * data.height:
        return plate
    _continued(color, depth_m, is_known, inside)
    depth_m[depth_m >= FAR_M * 0.9] = np.inf
    return replace(plate, pixels=ReadPixels(color, depth_m), data_window=box)


def _ends(box: Box) -> tuple[int, int, int, int]:
    return box.x0, box.y0, box.x1, box.y1


def _add(
    arrived: Arrived, canvas: Canvas, color: FloatImage, is_known: Flags, border_px: int
) -> None:
    """Add the pixels outside the frame that are still unknown: the nearest surface of each."""
    pixels, is_over = arrived.over(canvas)
    some = np.flatnonzero(is_over & ~is_known.ravel()[pixels])
    pixel = pixels.ravel()[some]
    order = np.argsort(packed(pixel, arrived.z.ravel()[some]))
    pixel, some = pixel[order], some[order]
    first = np.flatnonzero(np.diff(pixel, prepend=-1))
    pixel, some = pixel[first], some[first]
    depth_m = canvas.front_m
    color.reshape(-1, 4)[pixel] = arrived.look.view.plate.color.reshape(-1, 4)[some]
    depth_m.ravel()[pixel] = arrived.z.ravel()[some]
    new = np.zeros(is_known.shape, bool)
    new.ravel()[pixel] = True
    _close(color, depth_m, new, is_known, border_px)
    is_known |= new


def _close(
    color: FloatImage,
    depth_m: FloatImage,
    new: Flags,
    is_known: Flags,
    border_px: int,
) -> None:
    """Close holes of one pixel between two of the same surface, in rows and then in columns."""
    edge = border_px + 1
    sides = (np.s_[:edge], np.s_[-edge:], np.s_[:, :edge], np.s_[:, -edge:])
    for side in sides:
        c, z, n, k = color[side], depth_m[side], new[side], is_known[side]
        _close_lines(c.swapaxes(0, 1), z.T, n.T, k.T)
        _close_lines(c, z, n, k)


def _close_lines(c: FloatImage, z: FloatImage, n: Flags, k: Flags) -> None:
    """Close holes between the lines before and after, see `_close`."""
    before, after = z[:-2], z[2:]
    is_hole = n[:-2] & n[2:] & ~k[1:-1] & (np.abs(before - after) < APART * before)
    is_hole &= ~n[1:-1] | (z[1:-1] > (1 + APART) * before)
    at, places = np.nonzero(is_hole)
    z[at + 1, places] = (before[at, places] + after[at, places]) / 2
    c[at + 1, places] = (c[at, places] + c[at + 2, places]) / 2
    n[at + 1, places] = True


def _continued(
    color: FloatImage, depth_m: FloatImage, is_known: Flags, inside: tuple[slice, slice]
) -> None:
    """Fill unknown pixels outside the frame from the pixels inwards, in rows, then in columns.

    Near surfaces are known farther out than far ones, so the far surface is continued.
    """
    for z, n, c, span in (
        (depth_m.T, is_known.T, color.swapaxes(0, 1), inside[1]),
        (depth_m, is_known, color, inside[0]),
    ):
        for edge, outwards in (
            (span.start, range(span.start - 1, -1, -1)),
            (span.stop - 1, range(span.stop, len(z))),
        ):
            far_m, light, has = z[edge].copy(), c[edge].copy(), n[edge].copy()
            for line in outwards:
                takes = n[line] & (~has | (z[line] > far_m * np.float32(1 - APART)))
                far_m[takes], light[takes] = z[line][takes], c[line][takes]
                has |= takes
                fills = has & ~n[line]
                z[line][fills], c[line][fills] = far_m[fills], light[fills]
                n[line] |= fills
