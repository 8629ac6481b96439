"""Find the hidden surfaces and the border of a frame in the neighbouring frames.

The colour of a hidden point is the one that these frames agree on.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.media.plate.behind import with_behind
from heatlens.media.plate.deep.stacked import lists_over
from heatlens.media.plate.mattes.cutout import with_cutout_of
from heatlens.media.plate.neighbours.moved import (
    Arrived,
    Canvas,
    Moving,
    Numbers,
    arrived_in,
    canvas_of,
    moved_here,
    moving,
)
from heatlens.media.plate.neighbours.nearby import BLOCK
from heatlens.media.plate.neighbours.trust import doubt, size_reason
from heatlens.media.plate.neighbours.unseen import (
    APART,
    could_be_seen,
    hidden_points,
    surfaces,
    widened,
)
from heatlens.media.plate.neighbours.view import FAR_M, Flags, Look, View, look_of, motion
from heatlens.media.plate.plate import FloatImage, Plate, ReadPixels

_NAMES = ("What neighbouring frames show", "What they show behind that")
_TRIED = 4  # candidates; some are rejected later
_FULL = 0.25  # total weight of the frames from which a point is opaque; below it fades


@dataclass(frozen=True, eq=False)
class Found:
    """A plate with the surfaces found in its neighbours.

    plate        with the found surfaces behind the picture, and the border in `Plate.beyond`
    hidden_part  share that was found of the pixels that near silhouettes could hide, 0..1
    frames       the frames that were used
    left_out     the frames that were not, each with a sentence that says why
    layers       plates of the found surfaces alone: the nearest of each pixel, then the next
    """

    plate: Plate
    hidden_part: float
    frames: tuple[int, ...]
    left_out: tuple[tuple[int, str], ...] = ()
    layers: tuple[Plate, ...] = ()


# A silhouette hides in one frame what the next one shows. One neighbour on either side was worth
# more than all that was tried on one plate alone: a fence went from FLIP .110 to .085, and four to
# .081. Frames are worth what they uncover, so they are chosen by parallax, few and far enough
# apart.
def with_neighbours(view: View, others: Sequence[View], border_px: int = 0) -> Found:
    """Return the plate of `view` with what the other frames show behind its surfaces.

    `others` may come in any order. A plate that holds circles of confusion finds nothing.
    """
    moved, left_out = _usable(view, others)
    if not moved:
        return Found(view.plate, 0.0, (), left_out)
    plate, view = view.plate, _widened(view, moved, border_px)
    canvas = canvas_of(view)
    layers = _layers(view, moved, canvas)
    wide = view.plate
    if layers:
        made = with_behind(wide, layers, _NAMES[: len(layers)])
        wide = replace(made, notes=plate.notes)
    frames = tuple(arrived.look.view.frame for arrived in moved)
    part = _found_part(canvas, layers, plate.data_window)
    return Found(_framed(plate, wide), part, frames, left_out, tuple(layers))


def _usable(
    view: View, others: Sequence[View]
) -> tuple[list[Arrived], tuple[tuple[int, str], ...]]:
    """Return the usable frames, moved into this view, and a reason for each of the others."""
    usable, left_out, canvas = [], [], None
    for other in sorted(others, key=lambda it: it.frame):
        reason = size_reason(view, other)
        if not reason:
            arrived = arrived_in(view, look_of(other))
            canvas = canvas or canvas_of(view)
            reason = doubt(view, arrived, canvas)
        if reason:
            left_out.append((other.frame, reason))
        else:
            usable.append(arrived)
    return usable, tuple(left_out)


def _widened(view: View, moved: Sequence[Arrived], border_px: int) -> View:
    if not border_px:
        return view
    nearest_first = sorted(moved, key=lambda it: abs(it.look.view.frame - view.frame))
    return replace(view, plate=widened(view.plate, nearest_first, border_px))


def _layers(view: View, moved: Sequence[Arrived], canvas: Canvas) -> list[Plate]:
    """Return plates of the found surfaces alone: the nearest of each pixel, and the next."""
    points, looks = [], []
    for arrived in moved:
        place = arrived.over(canvas)
        points.append(hidden_points(canvas, arrived, *place))
        looks.append((arrived.look, moving(canvas, arrived, *place)))
    goes_on_m = moved_here(view, [look for look, _ in looks], canvas)
    count = np.zeros(canvas.front_m.size, np.int8)
    colors = np.zeros((len(_NAMES), canvas.front_m.size, 4), np.float32)
    depths = np.full((len(_NAMES), canvas.front_m.size), np.inf, np.float32)
    for pixel, z in surfaces(np.concatenate(points), _TRIED):
        color = agreed(view, looks, canvas, pixel, z)
        is_found = (color[:, 3] > 0) & (count[pixel] < len(_NAMES))
        is_found &= ~_is_hidden_twice(canvas, goes_on_m, pixel, z)
        pixel, z = pixel[is_found], z[is_found]
        colors[count[pixel], pixel] = color[is_found]
        depths[count[pixel], pixel] = np.where(z >= FAR_M * 0.9, np.float32(np.inf), z)
        count[pixel] += 1
    shape = canvas.front_m.shape
    return [
        _alone(view.plate, color.reshape(*shape, 4), depth_m.reshape(shape))
        for color, depth_m in zip(colors, depths, strict=True)
        if color[:, 3].any()
    ]


# Where a walker is partly hidden, the frames around show the wall behind him, because he has gone
# on: its colour was put into the edge before him. Keeping his surroundings free took a dolly along
# a street from FLIP .0273 to .0262.
def _is_hidden_twice(canvas: Canvas, goes_on_m: FloatImage, pixel: Numbers, z: FloatImage) -> Flags:
    """Return where a moving object may lie between the visible surface and a point."""
    row, column = np.divmod(pixel, canvas.width)
    between_m = goes_on_m[row // BLOCK, column // BLOCK]
    is_behind_front = between_m > canvas.front_m.ravel()[pixel] * (1 + APART)
    hidden: Flags = is_behind_front & (between_m * (1 + APART) < z)
    return hidden


def _found_part(canvas: Canvas, layers: Sequence[Plate], framed: Box) -> float:
    """Return the share of hidden pixels that was found, without the new border."""
    if not layers:
        return 0.0
    window = layers[0].data_window
    rows = slice(framed.y0 - window.y0, framed.y1 - window.y0)
    columns = slice(framed.x0 - window.x0, framed.x1 - window.x0)
    asked = could_be_seen(canvas.front_m[rows, columns])
    is_found = layers[0].color[rows, columns][::BLOCK, ::BLOCK, 3] > 0
    return float(is_found[asked].mean()) if asked.any() else 0.0


def _framed(plate: Plate, wide: Plate) -> Plate:
    """Return the plate with the surfaces found behind it; the border stays in `Plate.beyond`."""
    window = plate.data_window
    if wide.data_window == window:
        return wide
    lists = wide.fragments
    if lists is not None:
        lists = lists_over(lists, wide.data_window, window)
    return replace(plate, fragments=lists, behind=wide.behind, beyond=with_cutout_of(plate, wide))


def _alone(plate: Plate, color: FloatImage, depth_m: FloatImage) -> Plate:
    pixels = ReadPixels(color, depth_m)
    return replace(plate, pixels=pixels, has_alpha=True, fragments=None, behind=(), notes=())


# Without a test of agreement a rolling ball stood where it no longer is, and two neighbours gave a
# worse picture than one (37.6 dB in place of 38.6). A frame that sees through a point is proof that
# nothing is there; a frame that shows it is none while it is alone.
def agreed(
    here: View,
    looks: Sequence[tuple[Look, Moving]],
    canvas: Canvas,
    pixel: Numbers,
    z: FloatImage,
) -> FloatImage:
    """Return the colour (N, 4) at each point; alpha is 0 where it is unknown.

    A frame that sees through a point shows that nothing is there. A point seen by one frame only is
    used unless it is close to something that moved. The weight of a frame falls to zero with its
    distance in time, so that nothing pops when a frame enters or leaves the set.
    """
    x, y = canvas.middles(pixel)
    reach = max(abs(look.view.frame - here.frame) for look, _ in looks) + 1
    colors = np.zeros((len(looks), len(pixel), 4), np.float32)
    weights = np.zeros((len(looks), len(pixel)), np.float32)
    is_refuted = np.zeros(len(pixel), bool)
    may_move = np.zeros(len(pixel), bool)
    for number, (look, mover) in enumerate(looks):
        there = motion(here, look.view).moved(x, y, z)
        colors[number], is_seen, is_through = look.answers(*there)
        weights[number] = is_seen * (1 - abs(look.view.frame - here.frame) / reach)
        is_refuted |= is_through
        may_move |= is_seen & mover.holds(*there)
    seen_by = (weights > 0).sum(0)
    color = middle_half(colors, weights)
    color *= np.minimum(weights.sum(0) / np.float32(_FULL), 1)[:, None]
    color[is_refuted | (seen_by == 0) | ((seen_by == 1) & may_move)] = 0
    return color


def middle_half(colors: FloatImage, weights: FloatImage) -> FloatImage:
    """Return the mean of the middle half of colours (K, N, C), sorted by brightness.

    Their weights (K, N) decide where the middle is. Unlike a median, the mean changes smoothly with
    the weights; like a median, it ignores outliers.
    """
    light = np.ascontiguousarray(colors[..., :3].sum(-1).T)
    order = np.argsort(light, axis=1)
    share = weights.T / np.maximum(weights.sum(0), np.float32(1e-9))[:, None]
    sorted_share = np.take_along_axis(share, order, 1)
    end = np.cumsum(sorted_share, axis=1)
    inner = np.minimum(end, np.float32(0.75))
    inner -= np.maximum(end - sorted_share, np.float32(0.25))
    np.put_along_axis(share, order, np.maximum(inner, 0), 1)
    share /= np.maximum(share.sum(1), np.float32(1e-9))[:, None]
    middle: FloatImage = np.einsum("knc,nk->nc", colors, share)
    return middle
