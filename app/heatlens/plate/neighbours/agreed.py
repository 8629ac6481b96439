"""Find the colour of hidden points that the neighbouring frames agree on."""

from collections.abc import Sequence

import numpy as np

from heatlens.plate.neighbours.look import Look
from heatlens.plate.neighbours.moved import Canvas, Numbers
from heatlens.plate.neighbours.moving import Moving
from heatlens.plate.neighbours.view import View, motion
from heatlens.plate.plate import FloatImage

_FULL = 0.25  # total weight of the frames from which a point is opaque; below it fades


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
    for number, (look, moving) in enumerate(looks):
        there = motion(here, look.view).moved(x, y, z)
        colors[number], is_seen, is_through = look.answers(*there)
        weights[number] = is_seen * (1 - abs(look.view.frame - here.frame) / reach)
        is_refuted |= is_through
        may_move |= is_seen & moving.holds(*there)
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
