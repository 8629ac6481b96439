"""Fragment lists: the surfaces along the ray of each pixel, near to far, where they are known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatImage = NDArray[np.float32]
OPAQUE = 0.9995  # a coverage from this on hides what is behind it
LEAST_COVERAGE = 1e-4  # a fragment with less than this is none
SAME_DEPTH = 1e-3  # of the distance: what is so close behind an opaque surface is the same one
_HALF_MAX = 65504.0


@dataclass(frozen=True, eq=False)
class FragmentLists:
    """What is known along the rays of a plate's pixels, packed as the shaders read it.

    starts       (H * W + 1,) uint32: twice the number of the pixel's first fragment, plus 1 where
                 its list begins with what the pixel shows instead of what is behind that
    words        (N, 3) uint32: red and green, blue and coverage as pairs of halfs, and the dioptres
                 as a float32; colours are not multiplied by the coverage
    is_measured  the coverage of everything in front was measured, so that silhouettes of the flat
                 picture need no guess
    """

    starts: NDArray[np.uint32]
    words: NDArray[np.uint32]
    is_measured: bool = False

    @property
    def count(self) -> int:
        """How many fragments there are."""
        return len(self.words)

    @property
    def color(self) -> NDArray[np.float16]:
        """(N, 3), not multiplied by the coverage."""
        return self._halves[:, :3]

    @property
    def coverage(self) -> NDArray[np.float16]:
        """(N,) part of the pixel, 0..1."""
        return self._halves[:, 3]

    @property
    def dioptres(self) -> NDArray[np.float32]:
        """(N,) one over the planar distance in metres; 0 where nothing was hit."""
        return np.ascontiguousarray(self.words[:, 2]).view(np.float32)

    @property
    def _halves(self) -> NDArray[np.float16]:
        return np.ascontiguousarray(self.words[:, :2]).view(np.float16)


def packed_lists(
    counts: NDArray[np.int64],
    has_front: NDArray[np.bool_],
    rgba: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    is_measured: bool = False,
) -> FragmentLists:
    """Pack the fragments of all pixels, each pixel's near to far.

    `counts` and `has_front` are (H * W,); `rgba` (N, 4), straight colour and coverage, and
    `depth_m` (N,) hold the fragments of one pixel after those of the pixel before.
    """
    starts = np.zeros(counts.size + 1, np.uint32)
    starts[1:] = 2 * np.cumsum(counts)
    starts[:-1] += has_front
    words = np.empty((len(depth_m), 3), np.uint32)
    words[:, :2] = np.minimum(rgba, _HALF_MAX).astype(np.float16).view(np.uint32)
    words[:, 2] = (np.float32(1.0) / depth_m).view(np.uint32)
    return FragmentLists(starts, words, is_measured)


@dataclass(frozen=True, eq=False)
class Surface:
    """One picture of a stack: premultiplied RGBA (H, W, 4) and metres (H, W)."""

    color: FloatImage
    depth_m: FloatImage


@dataclass(frozen=True, eq=False)
class Stacked:
    """Several surfaces as one plate.

    color    (H, W, 4) premultiplied, what the pinhole shows
    depth_m  (H, W) of the nearest fragment
    lists    None where no pixel has a second surface
    """

    color: FloatImage
    depth_m: FloatImage
    lists: FragmentLists | None


def stacked(surfaces: Sequence[Surface]) -> Stacked:
    """Put surfaces of one size behind each other, each pixel by its own depths.

    Their order does not matter. Where an opaque surface is in front, the list holds what is behind
    it; where the first one covers a part of the pixel only, the list holds all of them.
    """
    shape = surfaces[0].depth_m.shape
    layers = _sorted(surfaces)
    color, alpha, depth, valid = layers
    shown = _over(color, alpha)
    first_depth = np.where(valid[0], depth[0], np.float32(np.inf))
    is_opaque = valid[0] & (alpha[0] >= OPAQUE)
    has_front = ~is_opaque & (valid.sum(axis=0) > 1)
    listed = valid.copy()
    listed[0] &= has_front
    lists = _packed_lists(layers, listed, has_front) if listed.any() else None
    return Stacked(shown.reshape(*shape, 4), first_depth.reshape(shape), lists)


_Layers = tuple[FloatImage, FloatImage, FloatImage, NDArray[np.bool_]]


def _sorted(surfaces: Sequence[Surface]) -> _Layers:
    """Return premultiplied rgb (M, P, 3), coverage, depth and validity (M, P), near to far."""
    alpha = np.stack([s.color[..., 3].ravel() for s in surfaces])
    depth = np.stack([s.depth_m.ravel() for s in surfaces])
    valid = alpha > LEAST_COVERAGE
    # lexsort keeps the order of equals; surfaces that are not there come last, also at infinity
    order = np.lexsort((np.where(valid, depth, np.inf), ~valid), axis=0)
    alpha, depth = (np.take_along_axis(a, order, axis=0) for a in (alpha, depth))
    valid = np.take_along_axis(valid, order, axis=0)
    color = np.stack([s.color[..., :3].reshape(-1, 3) for s in surfaces])
    color = np.take_along_axis(color, order[..., None], axis=0)
    _drop_hidden_twins(alpha, depth, valid)
    return color, np.clip(alpha, 0.0, 1.0), depth, valid


def _drop_hidden_twins(alpha: FloatImage, depth: FloatImage, valid: NDArray[np.bool_]) -> None:
    """Leave out what lies in an opaque surface or behind the sky: no lens can tell it."""
    opaque_m = np.where(valid[0] & (alpha[0] >= OPAQUE), depth[0], np.float32(np.nan))
    for m in range(1, len(depth)):
        with np.errstate(invalid="ignore"):  # the sky behind the sky
            is_behind = depth[m] - opaque_m > SAME_DEPTH * depth[m]
        valid[m] &= is_behind | np.isnan(opaque_m)
        opaque_m = np.where(valid[m] & (alpha[m] >= OPAQUE), depth[m], opaque_m)


def _over(color: FloatImage, alpha: FloatImage) -> FloatImage:
    """Return premultiplied RGBA (P, 4) of the layers over each other."""
    shown = np.zeros((color.shape[1], 4), np.float32)
    for m in range(len(color)):
        seen = 1.0 - shown[:, 3:]
        shown[:, :3] += seen * color[m]
        shown[:, 3:] += seen * alpha[m][:, None]
    return shown


def _packed_lists(
    layers: _Layers, listed: NDArray[np.bool_], has_front: NDArray[np.bool_]
) -> FragmentLists:
    color, alpha, depth, _ = layers
    counts = listed.sum(axis=0)
    next_free = np.cumsum(counts) - counts
    rgba, depth_m = np.empty((counts.sum(), 4), np.float32), np.empty(counts.sum(), np.float32)
    for m in range(len(depth)):
        here = np.flatnonzero(listed[m])
        at, cover = next_free[here], alpha[m][here][:, None]
        rgba[at, :3], rgba[at, 3:] = color[m][here] / cover, cover
        depth_m[at] = depth[m][here]
        next_free[here] += 1
    return packed_lists(counts, has_front, rgba, depth_m)
