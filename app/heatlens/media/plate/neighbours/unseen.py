"""Collect what a frame does not show: surfaces behind the visible one, and pixels beyond its frame.

Points of neighbouring frames behind the visible surface are sorted by surface. A plate is extended
beyond its frame with pixels of neighbouring frames, for the blur to use.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.media.plate.neighbours.moved import Arrived, Canvas, Numbers
from heatlens.media.plate.neighbours.nearby import BLOCK, around, blocks, of_nine
from heatlens.media.plate.neighbours.view import FAR_M, MIXED, Flags, depth_of
from heatlens.media.plate.plate import FloatImage, Plate, ReadPixels

APART = 0.03  # relative depth difference between two separate surfaces
_BAND = 1 / 40  # share of the width, inside near silhouettes: about what wide discs uncover
_LEAST_SHARE = 0.04  # share of a pixel that a moved pixel covers
Points = NDArray[np.uint64]  # pixel of the canvas in the upper half, depth in the lower half


def hidden_points(canvas: Canvas, arrived: Arrived, pixel: Numbers, is_over: Flags) -> Points:
    """Return the points of a frame behind the canvas, each in the four pixels around it.

    `pixel` and `is_over` are the results of `Arrived.over`.
    """
    least_m = canvas.nearest_m * np.float32(1 + APART)
    some = np.flatnonzero(is_over & arrived.look.is_clean & (arrived.z > least_m.ravel()[pixel]))
    left, top = canvas.corner
    x = arrived.x.ravel()[some] - np.float32(left + 0.5)
    y = arrived.y.ravel()[some] - np.float32(top + 0.5)
    z = arrived.z.ravel()[some]
    steps = ((0, 0), (1, 0), (0, 1), (1, 1))
    return np.concatenate([_beside(canvas, x, y, z, *step) for step in steps])


def _beside(
    canvas: Canvas, x: FloatImage, y: FloatImage, z: FloatImage, right: int, down: int
) -> Points:
    """Return the points that lie behind the visible surface, in one of the four pixels."""
    column, row = np.floor(x) + right, np.floor(y) + down
    is_inside = (column >= 0) & (column < canvas.width) & (row >= 0)
    is_inside &= row < canvas.front_m.shape[0]
    share = (1 - np.abs(x - column)) * (1 - np.abs(y - row))
    pixel = np.where(is_inside, row * canvas.width + column, 0).astype(np.int64)
    is_behind = z > canvas.front_m.ravel()[pixel] * np.float32(1 + APART)
    some = is_inside & is_behind & (share > _LEAST_SHARE)
    return packed(pixel[some], z[some])


# A float32 above 0 sorts as its bits do, so one sort of whole numbers orders points by pixel and by
# depth at once, where two keys would need a stable sort of each.
def packed(pixel: NDArray[np.integer], z: FloatImage) -> Points:
    """Combine pixel and depth in one number that sorts by pixel, then by depth."""
    bits = np.ascontiguousarray(z, np.float32).view(np.uint32).astype(np.uint64)
    return (pixel.astype(np.uint64) << np.uint64(32)) | bits


def surfaces(points: Points, most: int) -> list[tuple[Numbers, FloatImage]]:
    """Return the pixels and depths of the nearest surface of each pixel, of the next, and so on.

    Points of a pixel within `APART` of the nearest of them are one surface, with their mean depth.
    """
    points = np.sort(points)
    pixel = (points >> np.uint64(32)).astype(np.int32)
    z = points.astype(np.uint32).view(np.float32)
    layers: list[tuple[Numbers, FloatImage]] = []
    while len(pixel) and len(layers) < most:
        begins = np.flatnonzero(np.append(True, pixel[1:] != pixel[:-1]))
        counts = np.diff(begins, append=len(pixel))
        is_first = z <= np.repeat(z[begins] * np.float32(1 + APART), counts)
        sums = np.add.reduceat(np.where(is_first, z, 0), begins, dtype=np.float64)
        number = np.add.reduceat(is_first, begins, dtype=np.int64)
        layers.append((pixel[begins], (sums / number).astype(np.float32)))
        pixel, z = pixel[~is_first], z[~is_first]
    return layers


def could_be_seen(front_m: FloatImage) -> Flags:
    """Return which pixels hide something that a lens could see: those inside near silhouettes.

    One of each block of pixels is told.
    """
    is_rim = of_nine(front_m, np.maximum) > front_m * np.float32(MIXED)
    rim_m = blocks(np.where(is_rim, front_m, np.float32(0)), np.maximum)
    reach = max(1, round(_BAND * front_m.shape[1] / BLOCK))
    inside: Flags = front_m[::BLOCK, ::BLOCK] <= around(rim_m, reach, np.maximum) * (1 + APART)
    return inside


# The border was 8 % of the error that was left: what lies outside the frame blurs in. A plate keeps
# it beside its own pixels, so that the picture has the size of its file. A border of 1/48 of the
# width was as good as one three times as wide.
def widened(plate: Plate, nearest_first: Sequence[Arrived], border_px: int) -> Plate:
    """Return the plate with `border_px` more on every side, as the frames nearest in time show it.

    What none of them shows repeats the pixel beside it. The plate stays as it is where no frame
    shows anything outside.
    """
    data = plate.data_window
    box = Box(*(at + by * border_px for at, by in zip(data.corners, (-1, -1, 1, 1), strict=True)))
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
