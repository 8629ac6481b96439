"""Collect surfaces behind the visible one, and pixels outside the frame, from neighboring frames.

Points of neighboring frames behind the visible surface are sorted by surface. A plate gets a
border of pixels from neighboring frames, because the blur mixes them into the picture.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.media.plate.neighbours.moved import Canvas, MovedFrame, Numbers
from heatlens.media.plate.neighbours.nearby import (
    BLOCK,
    filter_three_by_three,
    filter_within,
    reduce_blocks,
)
from heatlens.media.plate.neighbours.view import FAR_M, MIXED, Flags, depth_of
from heatlens.media.plate.plate import FloatImage, Plate, ReadPixels

SEPARATE = 0.03  # relative depth difference between two separate surfaces
_BAND = 1 / 40  # share of the width inside near silhouettes: about what wide discs uncover
_LEAST_SHARE = 0.04  # a point counts for a pixel of which it covers at least this share
Points = NDArray[np.uint64]  # pixel of the canvas in the upper half, depth in the lower half


def hidden_points(
    canvas: Canvas, moved_frame: MovedFrame, pixel: Numbers, is_over: Flags
) -> Points:
    """Return the points of a frame behind the canvas; each counts for the four pixels around it.

    `pixel` and `is_over` are the results of `MovedFrame.pixels_on`.
    """
    least_m = canvas.nearest_m * np.float32(1 + SEPARATE)
    hidden = np.flatnonzero(
        is_over & moved_frame.neighbor.is_clean & (moved_frame.z > least_m.ravel()[pixel])
    )
    left, top = canvas.corner
    x = moved_frame.x.ravel()[hidden] - np.float32(left + 0.5)
    y = moved_frame.y.ravel()[hidden] - np.float32(top + 0.5)
    z = moved_frame.z.ravel()[hidden]
    steps = ((0, 0), (1, 0), (0, 1), (1, 1))
    return np.concatenate([_points_in_pixel(canvas, x, y, z, *step) for step in steps])


def _points_in_pixel(
    canvas: Canvas, x: FloatImage, y: FloatImage, z: FloatImage, right: int, down: int
) -> Points:
    """Return the points behind the visible surface, each in one of the four pixels around it.

    `right` and `down` (0 or 1) choose which of the four pixels.
    """
    column, row = np.floor(x) + right, np.floor(y) + down
    is_inside = (column >= 0) & (column < canvas.width) & (row >= 0)
    is_inside &= row < canvas.front_m.shape[0]
    share = (1 - np.abs(x - column)) * (1 - np.abs(y - row))
    pixel = np.where(is_inside, row * canvas.width + column, 0).astype(np.int64)
    is_behind = z > canvas.front_m.ravel()[pixel] * np.float32(1 + SEPARATE)
    is_used = is_inside & is_behind & (share > _LEAST_SHARE)
    return pack_points(pixel[is_used], z[is_used])


# One sort of whole numbers orders points by pixel and by depth at once, because a float32 above 0
# sorts as its bits do. Two keys would need a stable sort of each.
def pack_points(pixel: NDArray[np.integer], z: FloatImage) -> Points:
    """Combine pixel and depth in one number that sorts by pixel, then by depth."""
    bits = np.ascontiguousarray(z, np.float32).view(np.uint32).astype(np.uint64)
    return (pixel.astype(np.uint64) << np.uint64(32)) | bits


def split_into_surfaces(points: Points, layers_most: int) -> list[tuple[Numbers, FloatImage]]:
    """Return the pixels and depths of the nearest surface of each pixel, of the next, and so on.

    Points of a pixel within `SEPARATE` of the nearest one are one surface, at their mean depth.
    """
    points = np.sort(points)
    pixel = (points >> np.uint64(32)).astype(np.int32)
    z = points.astype(np.uint32).view(np.float32)
    layers: list[tuple[Numbers, FloatImage]] = []
    while len(pixel) and len(layers) < layers_most:
        begins = np.flatnonzero(np.append(True, pixel[1:] != pixel[:-1]))
        counts = np.diff(begins, append=len(pixel))
        is_first = z <= np.repeat(z[begins] * np.float32(1 + SEPARATE), counts)
        sums = np.add.reduceat(np.where(is_first, z, 0), begins, dtype=np.float64)
        number = np.add.reduceat(is_first, begins, dtype=np.int64)
        layers.append((pixel[begins], (sums / number).astype(np.float32)))
        pixel, z = pixel[~is_first], z[~is_first]
    return layers


def mask_hiding_pixels(front_m: FloatImage) -> Flags:
    """Return a mask of the pixels that hide something a lens could see: inside near silhouettes.

    The mask has one value for each block of pixels.
    """
    is_silhouette = filter_three_by_three(front_m, np.maximum) > front_m * np.float32(MIXED)
    silhouette_m = reduce_blocks(np.where(is_silhouette, front_m, np.float32(0)), np.maximum)
    reach = max(1, round(_BAND * front_m.shape[1] / BLOCK))
    is_inside: Flags = front_m[::BLOCK, ::BLOCK] <= filter_within(
        silhouette_m, reach, np.maximum
    ) * (1 + SEPARATE)
    return is_inside


# Surfaces outside the frame blur into the picture: without a border they made 8 % of the remaining
# error. The plate keeps the border apart from its own pixels, because the picture must have the
# size of its file. A border of 1/48 of the width was as good as one three times as wide.
def add_border(plate: Plate, nearest_first: Sequence[MovedFrame], border_px: int) -> Plate:
    """Return the plate with `border_px` more on every side, from the frames nearest in time.

    A border pixel that no frame shows repeats the pixel next to it. The plate stays as it is if no
    frame shows anything outside.
    """
    data = plate.data_window
    box = Box(
        *(
            coordinate + direction * border_px
            for coordinate, direction in zip(data.corners, (-1, -1, 1, 1), strict=True)
        )
    )
    inside = np.s_[border_px : border_px + data.height, border_px : border_px + data.width]
    color = np.zeros((*box.shape, 4), np.float32)
    depth_m = np.zeros(box.shape, np.float32)
    is_known = np.zeros(box.shape, bool)
    color[inside], is_known[inside] = plate.color, True
    depth_m[inside] = depth_of(plate)
    corner = box.relative_to(plate.display_window).corner
    for moved_frame in nearest_first:
        _add_outside_pixels(moved_frame, Canvas(corner, depth_m), color, is_known, border_px)
    if is_known.sum() == data.width * data.height:
        return plate
    _extend_outwards(color, depth_m, is_known, inside)
    depth_m[depth_m >= FAR_M * 0.9] = np.inf
    return replace(plate, pixels=ReadPixels(color, depth_m), data_window=box)


def _add_outside_pixels(
    moved_frame: MovedFrame, canvas: Canvas, color: FloatImage, is_known: Flags, border_px: int
) -> None:
    """Add the pixels of the moved frame that lie outside the picture and are still unknown.

    Where several fall on one pixel, the nearest surface is added. `color`, `is_known` and the depth
    of the canvas are changed in place.
    """
    pixels, is_over = moved_frame.pixels_on(canvas)
    source = np.flatnonzero(is_over & ~is_known.ravel()[pixels])
    pixel = pixels.ravel()[source]
    order = np.argsort(pack_points(pixel, moved_frame.z.ravel()[source]))
    pixel, source = pixel[order], source[order]
    first = np.flatnonzero(np.diff(pixel, prepend=-1))
    pixel, source = pixel[first], source[first]
    depth_m = canvas.front_m
    color.reshape(-1, 4)[pixel] = moved_frame.neighbor.view.plate.color.reshape(-1, 4)[source]
    depth_m.ravel()[pixel] = moved_frame.z.ravel()[source]
    is_new = np.zeros(is_known.shape, bool)
    is_new.ravel()[pixel] = True
    _close_holes(color, depth_m, is_new, is_known, border_px)
    is_known |= is_new


def _close_holes(
    color: FloatImage, depth_m: FloatImage, is_new: Flags, is_known: Flags, border_px: int
) -> None:
    """Close holes of one pixel between two pixels of one surface, in rows and then in columns.

    Only the border and the pixels next to it are searched.
    """
    edge = border_px + 1
    sides = (np.s_[:edge], np.s_[-edge:], np.s_[:, :edge], np.s_[:, -edge:])
    for side in sides:
        side_color = color[side]
        side_depth_m = depth_m[side]
        side_is_new = is_new[side]
        side_is_known = is_known[side]
        _close_holes_between_lines(
            side_color.swapaxes(0, 1), side_depth_m.T, side_is_new.T, side_is_known.T
        )
        _close_holes_between_lines(side_color, side_depth_m, side_is_new, side_is_known)


def _close_holes_between_lines(
    color: FloatImage, depth_m: FloatImage, is_new: Flags, is_known: Flags
) -> None:
    """Close holes in the lines of the first axis, from the lines before and after each one.

    It is as `_close_holes` describes; all arrays but `is_known` are changed in place.
    """
    before, after = depth_m[:-2], depth_m[2:]
    is_hole = (
        is_new[:-2] & is_new[2:] & ~is_known[1:-1] & (np.abs(before - after) < SEPARATE * before)
    )
    is_hole &= ~is_new[1:-1] | (depth_m[1:-1] > (1 + SEPARATE) * before)
    line, position = np.nonzero(is_hole)
    depth_m[line + 1, position] = (before[line, position] + after[line, position]) / 2
    color[line + 1, position] = (color[line, position] + color[line + 2, position]) / 2
    is_new[line + 1, position] = True


def _extend_outwards(
    color: FloatImage, depth_m: FloatImage, is_known: Flags, inside: tuple[slice, slice]
) -> None:
    """Fill unknown pixels outside the frame from those next to them inside, in rows, then columns.

    Near surfaces are known farther out than far ones, so the far surface is continued.
    """
    for lines_m, lines_known, lines_color, span in (
        (depth_m.T, is_known.T, color.swapaxes(0, 1), inside[1]),
        (depth_m, is_known, color, inside[0]),
    ):
        for edge, outwards in (
            (span.start, range(span.start - 1, -1, -1)),
            (span.stop - 1, range(span.stop, len(lines_m))),
        ):
            far_m = lines_m[edge].copy()
            far_color = lines_color[edge].copy()
            has_value = lines_known[edge].copy()
            for line in outwards:
                is_farther = lines_known[line] & (
                    ~has_value | (lines_m[line] > far_m * np.float32(1 - SEPARATE))
                )
                far_m[is_farther], far_color[is_farther] = (
                    lines_m[line][is_farther],
                    lines_color[line][is_farther],
                )
                has_value |= is_farther
                is_filled = has_value & ~lines_known[line]
                lines_m[line][is_filled], lines_color[line][is_filled] = (
                    far_m[is_filled],
                    far_color[is_filled],
                )
                lines_known[line] |= is_filled
