"""What the neighbouring frames of a sequence know of a frame: hidden surfaces and the border."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.behind import with_behind
from heatlens.plate.neighbours.look import Look, look_of
from heatlens.plate.neighbours.moved import Canvas, canvas_of, hidden_points, surfaces
from heatlens.plate.neighbours.view import FAR_M, View, motion
from heatlens.plate.plate import FloatImage, Plate, ReadPixels

MOST = 2  # surfaces behind each other


@dataclass(frozen=True, eq=False)
class Found:
    """A plate with what its neighbours know.

    plate        with the found surfaces behind the picture, and the border
    hidden_part  share that was found of the pixels that near silhouettes could hide, 0..1
    frames       the frames that were used
    left_out     the frames that were not, each with a sentence that says why
    """

    plate: Plate
    hidden_part: float
    frames: tuple[int, ...]
    left_out: tuple[tuple[int, str], ...] = ()


def with_neighbours(view: View, others: Sequence[View], border_px: int = 0) -> Found:
    """Return the plate of `view` with what the other frames show behind its surfaces.

    `others` may come in any order. A plate that holds circles of confusion finds nothing.
    """
    usable, left_out = _usable(view, others)
    if not usable:
        return Found(view.plate, 0.0, (), left_out)
    looks = [look_of(other) for other in usable]
    canvas = canvas_of(view, 0)
    points = np.concatenate([hidden_points(canvas, view, look) for look in looks])
    pixel, z, order = surfaces(points, MOST)
    color = _agreed(view, looks, canvas, pixel, z)
    is_found = color[:, 3] > 0
    pixel, z, order, color = pixel[is_found], z[is_found], order[is_found], color[is_found]
    layers = [
        _layer(view.plate, canvas, pixel[order == k], z[order == k], color[order == k])
        for k in range(MOST)
        if (order == k).any()
    ]
    plate = view.plate
    if layers:
        together = with_behind(layers[0], layers[1:])
        plate = with_behind(plate, [together], ["What neighbouring frames show"])
    part = len(np.unique(pixel)) / max(1, canvas.front_m.size)
    return Found(plate, part, tuple(look.view.frame for look in looks), left_out)


def _usable(view: View, others: Sequence[View]) -> tuple[list[View], tuple[tuple[int, str], ...]]:
    usable, left_out = [], []
    for other in sorted(others, key=lambda it: it.frame):
        reason = _reason_against(view, other)
        if reason:
            left_out.append((other.frame, reason))
        else:
            usable.append(other)
    return usable, tuple(left_out)


def _reason_against(view: View, other: View) -> str:
    """Return why a frame cannot be used; empty if it can."""
    if not (view.plate.has_distances and other.plate.has_distances):
        return "it holds circles of confusion and no distances."
    mine, its = view.plate.display_window, other.plate.display_window
    if mine.shape != its.shape:
        return f"it is {its.width}x{its.height}, this frame {mine.width}x{mine.height}."
    return ""


def _agreed(
    view: View, looks: Sequence[Look], canvas: Canvas, pixel: NDArray[np.int64], z: FloatImage
) -> FloatImage:
    """Return the colour (N, 4) on which the frames agree at each point; alpha 0 for none."""
    row, column = np.divmod(pixel, canvas.width)
    x = (column + (canvas.box.x0 + 0.5)).astype(np.float32)
    y = (row + (canvas.box.y0 + 0.5)).astype(np.float32)
    reach = max(abs(look.view.frame - view.frame) for look in looks) + 1
    colors = np.zeros((len(looks), len(pixel), 4), np.float32)
    weights = np.zeros((len(looks), len(pixel)), np.float32)
    is_through = np.zeros(len(pixel), bool)
    for number, look in enumerate(looks):
        colors[number], is_seen, through = look.answers(*motion(view, look.view).moved(x, y, z))
        weights[number] = is_seen * (1 - abs(look.view.frame - view.frame) / reach)
        is_through |= through
    color = middle_half(colors, weights)
    color[is_through | (weights.sum(0) == 0)] = 0
    return color


def middle_half(values: FloatImage, weights: FloatImage) -> FloatImage:
    """Return the mean of the middle half of values (K, N, C) by their weights (K, N).

    Unlike a median it follows the weights smoothly, and as a median it leaves outliers out.
    """
    order = np.argsort(values, axis=0)
    total = np.maximum(weights.sum(0), np.float32(1e-9))
    share = np.take_along_axis(
        np.broadcast_to((weights / total)[..., None], values.shape), order, 0
    )
    end = np.cumsum(share, axis=0)
    inner = np.minimum(end, 0.75) - np.maximum(end - share, 0.25)
    inner = np.maximum(inner, 0).astype(np.float32)
    sums = (np.take_along_axis(values, order, 0) * inner).sum(0)
    middle: FloatImage = sums / np.maximum(inner.sum(0), np.float32(1e-9))
    return middle


def _layer(
    plate: Plate, canvas: Canvas, pixel: NDArray[np.int64], z: FloatImage, color: FloatImage
) -> Plate:
    """Return a plate that shows these points alone."""
    rgba = np.zeros((canvas.front_m.size, 4), np.float32)
    depth_m = np.full(canvas.front_m.size, np.inf, np.float32)
    rgba[pixel] = color
    depth_m[pixel] = np.where(z >= FAR_M * 0.9, np.float32(np.inf), z)
    shape = canvas.front_m.shape
    pixels = ReadPixels(rgba.reshape(*shape, 4), depth_m.reshape(shape))
    return replace(plate, pixels=pixels, has_alpha=True, fragments=None, behind=(), notes=())
