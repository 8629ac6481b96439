"""Interpolate the values of a glTF animation between its keys."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.scene import Array

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class ValueTrack:
    """Values over time.

    times_s  (K,) in ascending order
    values   (K, n); (K, 3, n) for a cubic: tangent in, value, tangent out
    kind     LINEAR, STEP or CUBICSPLINE
    is_animated  True if an animation has the track; False for the default track of a node at rest
    """

    times_s: Array
    values: Array
    kind: str = "LINEAR"
    is_rotation: bool = False
    is_animated: bool = True

    def sample(self, times_s: Array) -> Array:
        """Return (T, n) values at T times, constant before the first and after the last key."""
        if len(self.times_s) == 1:
            only_value = self.values[0, 1] if self.kind == "CUBICSPLINE" else self.values[0]
            return np.tile(only_value, (len(times_s), 1))
        inner = np.clip(times_s, self.times_s[0], self.times_s[-1])
        after = np.searchsorted(self.times_s, inner, side="right")
        before = np.clip(after - 1, 0, max(len(self.times_s) - 2, 0))
        after = np.minimum(before + 1, len(self.times_s) - 1)
        span = self.times_s[after] - self.times_s[before]
        share = np.where(span > 0, (inner - self.times_s[before]) / np.where(span > 0, span, 1), 1)
        return np.asarray(
            INTERPOLATIONS[self.kind](self, before, after, span[:, None], share[:, None]),
            np.float64,
        )


def _interpolate_step(
    track: ValueTrack, before: Indices, after: Indices, span: Array, share: Array
) -> Array:
    """Return the value of the key before each time, which holds until the next key."""
    return np.where(share < 1, track.values[before], track.values[after])


def _interpolate_linear(
    track: ValueTrack, before: Indices, after: Indices, span: Array, share: Array
) -> Array:
    """Interpolate linearly between two keys; rotations go along the arc between two quaternions."""
    a, b = track.values[before], track.values[after]
    if not track.is_rotation:
        return np.asarray(a + (b - a) * share)
    return _slerp(a, b, share)


def _interpolate_cubic(
    track: ValueTrack, before: Indices, after: Indices, span: Array, share: Array
) -> Array:
    """Interpolate by the cubic spline of glTF 2.0, appendix C.5."""
    t = share
    a, tangent_out = track.values[before, 1], track.values[before, 2]
    tangent_in, b = track.values[after, 0], track.values[after, 1]
    return np.asarray(
        (2 * t**3 - 3 * t**2 + 1) * a
        + span * (t**3 - 2 * t**2 + t) * tangent_out
        + (3 * t**2 - 2 * t**3) * b
        + span * (t**3 - t**2) * tangent_in
    )


def _slerp(a: Array, b: Array, share: Array) -> Array:
    """Interpolate quaternions along the shorter arc, linearly if both ends are nearly equal.

    Source: Shoemake 1985.
    """
    cosine = np.sum(a * b, axis=1, keepdims=True)
    b, cosine = np.where(cosine < 0, -b, b), np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    is_near = sine < 1e-6
    safe_sine = np.where(is_near, 1.0, sine)
    first = np.where(is_near, 1 - share, np.sin((1 - share) * angle) / safe_sine)
    last = np.where(is_near, share, np.sin(share * angle) / safe_sine)
    return np.asarray(first * a + last * b)


INTERPOLATIONS: Mapping[str, Callable[[ValueTrack, Indices, Indices, Array, Array], Array]] = {
    "STEP": _interpolate_step,
    "LINEAR": _interpolate_linear,
    "CUBICSPLINE": _interpolate_cubic,
}
