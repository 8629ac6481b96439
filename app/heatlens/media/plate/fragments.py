"""Fragment lists: the known surfaces along the ray of each pixel, near to far."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatImage = NDArray[np.float32]
OPAQUE = 0.9995  # a surface of this coverage or more hides everything behind it
LEAST_COVERAGE = 1e-4  # a fragment with less coverage is left out
SAME_DEPTH = 1e-3  # relative distance within which anything behind an opaque surface is part of it
_HALF_MAX = 65504.0


@dataclass(frozen=True, eq=False)
class FragmentLists:
    """The known surfaces along the rays of a plate's pixels, packed as the shaders read them.

    starts       (H * W + 1,) uint32: twice the index of the pixel's first fragment in `words`, plus
                 1 if its list begins with the visible surface instead of the one behind it
    words        (N, 3) uint32: red and green, blue and coverage as pairs of halfs, and the dioptres
                 as a float32; colors are not multiplied by the coverage
    is_measured  whether the coverage of everything in front was measured, by samples or by alpha;
                 then it need not be guessed at the silhouettes of the flat picture
    """

    starts: NDArray[np.uint32]
    words: NDArray[np.uint32]
    is_measured: bool = False

    @property
    def count(self) -> int:
        """The number of fragments."""
        return len(self.words)

    @property
    def begins(self) -> NDArray[np.int64]:
        """The index (H * W + 1,) of the first fragment of each pixel, and `count` at the end."""
        return unpack_starts(self.starts)[0]

    @property
    def has_front(self) -> NDArray[np.bool_]:
        """Whether the list (H * W,) of each pixel begins with the visible surface."""
        return unpack_starts(self.starts)[1]

    @property
    def nbytes(self) -> int:
        """The memory of the lists in bytes."""
        return self.starts.nbytes + self.words.nbytes

    @property
    def color(self) -> NDArray[np.float16]:
        """The colors (N, 3), not multiplied by the coverage."""
        return self._halves[:, :3]

    @property
    def coverage(self) -> NDArray[np.float16]:
        """The share (N,) of the pixel that each fragment covers, 0..1."""
        return self._halves[:, 3]

    def scale_light(self, scale: float) -> "FragmentLists":
        """Return the lists with their light multiplied by `scale`; coverage and depth stay."""
        if scale == 1.0:
            return self
        words = self.words.copy()
        words[:, :2].view(np.float16)[:, :3] *= np.float16(scale)
        return replace(self, words=words)

    @property
    def dioptres(self) -> NDArray[np.float32]:
        """The dioptres (N,): 1 / planar distance in meters, 0 where nothing was hit."""
        return np.ascontiguousarray(self.words[:, 2]).view(np.float32)

    @property
    def _halves(self) -> NDArray[np.float16]:
        """The colors and the coverage, (N, 4)."""
        return np.ascontiguousarray(self.words[:, :2]).view(np.float16)


def pack_starts(counts: NDArray[np.int64], has_front: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """Return `FragmentLists.starts` from the number of fragments of each pixel.

    `has_front` marks the pixels whose list begins with the visible surface.
    """
    starts = np.zeros(counts.size + 1, np.uint32)
    starts[1:] = 2 * np.cumsum(counts)
    starts[:-1] += has_front
    return starts


def unpack_starts(starts: NDArray[np.uint32]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return `begins` (n + 1,) and `has_front` (n,), the lowest bit, from packed starts."""
    return (starts >> 1).astype(np.int64), (starts[:-1] & 1).astype(bool)


def pack_words(rgba: NDArray[np.float32], depth_m: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return `FragmentLists.words` for straight colors with coverage, and depths in meters."""
    words = np.empty((len(depth_m), 3), np.uint32)
    words[:, :2] = np.clip(rgba, -_HALF_MAX, _HALF_MAX).astype(np.float16).view(np.uint32)
    words[:, 2] = (np.float32(1.0) / depth_m).view(np.uint32)
    return words
