"""Few keys for a focus that was recorded frame by frame, within a tolerance in dioptres.

A recording becomes cubic pieces, each as long as the tolerance allows. A piece begins and ends on
samples and never goes beyond them: the slopes at its ends are found by least squares, within the
bounds that keep a cubic monotone (F. N. Fritsch and R. E. Carlson, "Monotone Piecewise Cubic
Interpolation", 1980). So the curve overshoots only where the hand did.

`linear_keys` meets a value which is known at every frame with the fewest keys.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale, hermite

Samples = Sequence[tuple[float, float]]  # (frame, focus distance in meters), by frame

# A handle of a third of the piece makes a Bezier the plain cubic with that slope at its end.
_THIRD_PERCENT = 100 / 3
_STEEPEST = 3.0  # times the chord; a cubic with smaller slopes stays within the range of its ends
_SWEEPS = 12  # over both slopes in turn; each more than halves the remaining error
_ROUNDING = 1e-9  # difference between two ways to compute a cubic, relative and in dioptres
# Relative difference of a value that was rounded to float32 twice.
_FLOAT32_ROUNDING = 2e-7


def reduce_keys(
    samples: Iterable[tuple[float, float]],
    tolerance_dioptres: float,
    scale: Scale = Scale.RECIPROCAL,
    eases: bool = False,
) -> tuple[Key, ...]:
    """Return few keys of the focus that pass every sample within a tolerance.

    `samples` are pairs of a frame and a focus distance in meters, which may be infinite. They may
    come in any order, and of several at one frame the last one counts. `scale` is that of the
    curve which the keys are for. The first and the last sample are kept as they are, unless all
    samples lie within the tolerance of the first: then that is the only key. With `eases` the
    curve begins and ends without slope. Without samples there are no keys. Raises InputError for a
    tolerance below 0, and for distances outside the scale.
    """
    if not tolerance_dioptres >= 0:
        raise InputError(f"A tolerance must be 0 or more dioptres, got {tolerance_dioptres:g}.")
    recording = _Recording(sorted(dict(samples).items()), tolerance_dioptres, scale, eases)
    if not recording.samples:
        return ()
    if recording.is_still:
        frame, distance_m = recording.samples[0]
        return (Key(frame, distance_m),)
    return recording.keys_of(_smooth_joints(recording, recording.fit_pieces()))


@dataclass(frozen=True, slots=True)
class _Piece:
    """A cubic from one sample to another, by their indices, and its slopes per frame at both."""

    start: int
    end: int
    slope_out: float
    slope_in: float


@dataclass(frozen=True)
class _Recording:
    """The samples in the order of their frames, and the tolerance of the curve."""

    samples: Samples
    tolerance: float
    scale: Scale
    eases: bool = False

    @property
    def is_still(self) -> bool:
        """True if the first sample represents all of them."""
        first = self.samples[0][1]
        return all(self._is_near(distance_m, first) for _, distance_m in self.samples)

    def _is_near(self, distance_m: float, other_m: float) -> bool:
        """Return True if two distances differ by at most the tolerance, in dioptres."""
        dioptres, other_dioptres = (Scale.RECIPROCAL.position_of(m) for m in (distance_m, other_m))
        return abs(dioptres - other_dioptres) <= self.tolerance + _ROUNDING * max(
            dioptres, other_dioptres
        )

    def fit_pieces(self) -> list[_Piece]:
        """Return pieces from the first sample to the last, each about as long as it can be."""
        chain: list[_Piece] = []
        start, last = 0, len(self.samples) - 1
        while start < last:
            chain.append(self._find_long_piece(start, last))
            start = chain[-1].end
        return chain

    # A longer piece may fit where a shorter one does not, so this one is not always the longest.
    # But the number of fits grows with the logarithm of its length, where trying each length would
    # fit as many pieces as there are samples.
    def _find_long_piece(self, start: int, last: int) -> _Piece:
        """Return a long piece from `start`, found by doubling its length, then by bisection."""
        # Lengths in samples: `reach` is tried next, and a piece of `too_long` did not fit.
        longest, reach = self.fit_piece(start, start + 1), 2
        too_long = last - start + 1
        while reach < too_long:
            piece = self.fit_piece(start, start + reach)
            if self.meets_tolerance(piece):
                longest = piece
                reach = min(2 * reach, last - start) if reach < last - start else too_long
            else:
                too_long = reach
        low = longest.end - start
        while too_long - low > 1:
            piece = self.fit_piece(start, start + (low + too_long) // 2)
            if self.meets_tolerance(piece):
                longest, low = piece, piece.end - start
            else:
                too_long = piece.end - start
        return longest

    # Both slopes at once are a problem of two unknowns in a box. Sweeping over one and then the
    # other meets the bounds by clamping alone, and needs neither cases nor a solver.
    def fit_piece(self, start: int, end: int) -> _Piece:
        """Return the monotone cubic between two samples that is nearest to those in between."""
        frames, rise, rows = self._least_squares_rows(start, end)
        # The sums of the normal equations: s of both slopes with each other, t with the samples.
        pairs = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2))
        s00, s01, s11, t0, t1 = (sum(row[i] * row[j] for row in rows) for i, j in pairs)
        are_slopes_free = start > 0 or not self.eases, end < len(self.samples) - 1 or not self.eases
        slope_out, slope_in = (
            rise if is_free else 0.0 for is_free in are_slopes_free
        )  # a straight line
        for _ in range(_SWEEPS if rows and rise else 0):
            if are_slopes_free[0]:
                slope_out = _clamp_slope((t0 - s01 * slope_in) / s00, rise)
            if are_slopes_free[1]:
                slope_in = _clamp_slope((t1 - s01 * slope_out) / s11, rise)
        return _Piece(start, end, slope_out / frames, slope_in / frames)

    def _least_squares_rows(
        self, start: int, end: int
    ) -> tuple[float, float, list[tuple[float, float, float]]]:
        """Return the frames of a piece, its rise, and a row for each sample inside.

        A row has the weights of both slopes, and the distance of the sample from a cubic with
        slopes of 0.
        """
        (first, first_m), (last, last_m) = self.samples[start], self.samples[end]
        start_position, frames = self.scale.position_of(first_m), last - first
        rise, rows = self.scale.position_of(last_m) - start_position, []
        for frame, distance_m in self.samples[start + 1 : end]:
            u = (frame - first) / frames
            difference = (
                self.scale.position_of(distance_m) - start_position - rise * u * u * (3.0 - 2.0 * u)
            )
            rows.append((u * (1.0 - u) ** 2, -u * u * (1.0 - u), difference))
        return frames, rise, rows

    def meets_tolerance(self, piece: _Piece) -> bool:
        """Return True if the piece is within the tolerance of every sample."""
        (first, first_m), (last, last_m) = self.samples[piece.start], self.samples[piece.end]
        end_positions = self.scale.position_of(first_m), self.scale.position_of(last_m)
        frames = last - first
        rises = piece.slope_out * frames, piece.slope_in * frames
        return all(
            self._is_near(
                self.scale.value_at(hermite((frame - first) / frames, end_positions, rises)),
                distance_m,
            )
            for frame, distance_m in self.samples[piece.start + 1 : piece.end]
        )

    def is_monotone(self, piece: _Piece) -> bool:
        """Return True if both slopes keep the cubic within the range of its ends."""
        frames, rise, _ = self._least_squares_rows(piece.start, piece.end)
        slopes = piece.slope_out * frames, piece.slope_in * frames
        return all(slope == _clamp_slope(slope, rise) for slope in slopes)

    def keys_of(self, pieces: Sequence[_Piece]) -> tuple[Key, ...]:
        """Return a key for each end of a piece, whose handles have the slopes of the pieces."""
        slopes_in = [0.0, *(piece.slope_in for piece in pieces)]
        slopes_out = [*(piece.slope_out for piece in pieces), 0.0]
        sample_indices = [pieces[0].start, *(piece.end for piece in pieces)]
        return tuple(
            Key(
                *self.samples[index],
                Interpolation.BEZIER,
                Ease(_THIRD_PERCENT, slope_out),
                Ease(_THIRD_PERCENT, slope_in),
            )
            for index, slope_out, slope_in in zip(
                sample_indices, slopes_out, slopes_in, strict=True
            )
        )


def _clamp_slope(slope: float, rise: float) -> float:
    """Return the slope, limited so that the cubic over a piece stays monotone.

    `slope` and `rise` are both for the whole piece, on the scale of the curve.
    """
    low, high = sorted((0.0, _STEEPEST * rise))
    return min(max(slope, low), high)


# Pieces are fitted one by one, so that slopes differ where two meet. Common slopes are tried, the
# mean of both first. A corner stays where each would exceed the tolerance or the range of the keys.
def _smooth_joints(recording: _Recording, pieces: list[_Piece]) -> list[_Piece]:
    """Return the pieces without corners between them, where the tolerance allows it."""
    smooth_pieces = list(pieces)
    for index, (before, after) in enumerate(pairwise(pieces)):
        before, next_slope = smooth_pieces[index], after.slope_out
        for slope in ((before.slope_in + next_slope) / 2, before.slope_in, next_slope, 0.0):
            new_pair = replace(before, slope_in=slope), replace(after, slope_out=slope)
            if all(recording.is_monotone(p) and recording.meets_tolerance(p) for p in new_pair):
                smooth_pieces[index : index + 2] = new_pair
                break
    return smooth_pieces


# One pass over the track is enough: each frame that the line passes narrows the range of allowed
# slopes, `lowest` to `highest`, and nothing else has to be kept of it.
def linear_keys(frames: tuple[int, ...], track: tuple[float, ...], scale: Scale) -> tuple[Key, ...]:
    """Return the fewest keys that reproduce the track at every frame; none for a constant track.

    A key is left out if it lies on the straight line between its neighbors on `scale`: the line
    from the last key to the next has to pass every frame in between within the precision of
    float32.
    """
    if len(set(track)) < 2:
        return ()
    positions = [scale.position_of(value) for value in track]
    key_indices = [0]
    lowest, highest = -math.inf, math.inf  # slopes from the last key that pass every frame since
    for index in range(1, len(frames)):
        slope, frame_count = _slope(frames, positions, key_indices[-1], index)
        if not lowest <= slope <= highest:
            key_indices.append(index - 1)
            lowest, highest = -math.inf, math.inf
            slope, frame_count = _slope(frames, positions, index - 1, index)
        tolerance = _rounding_tolerance(track[index], scale) / frame_count
        lowest, highest = max(lowest, slope - tolerance), min(highest, slope + tolerance)
    key_indices.append(len(frames) - 1)
    return tuple(Key(frames[chosen], track[chosen], Interpolation.LINEAR) for chosen in key_indices)


def _slope(
    frames: tuple[int, ...], positions: list[float], start: int, end: int
) -> tuple[float, int]:
    """Return the slope per frame between two indices of the track, and the frames in between."""
    count = frames[end] - frames[start]
    return (positions[end] - positions[start]) / count, count


def _rounding_tolerance(value: float, scale: Scale) -> float:
    """Return the largest difference on the scale that rounds to the same float32 value."""
    return _FLOAT32_ROUNDING * abs(scale.slope_at(value) * value) if math.isfinite(value) else 0.0


def trim_still_ends(samples: Samples, tolerance_dioptres: float) -> Samples:
    """Return the samples without the frames at both ends at which the focus does not move.

    Each sample that is left out lies within the tolerance of the first or the last that stays.
    """
    dioptres = [Scale.RECIPROCAL.position_of(distance_m) for _, distance_m in samples]
    start = _last_still_index(dioptres, tolerance_dioptres)
    end = len(dioptres) - 1 - _last_still_index(dioptres[::-1], tolerance_dioptres)
    return samples[start : end + 1] if start < end else samples


def _last_still_index(dioptres: Sequence[float], tolerance: float) -> int:
    """Return the last index whose value lies within the tolerance of all values before it."""
    low, high = dioptres[0], dioptres[0]
    last_index = 0
    for index, value in enumerate(dioptres):
        low, high = min(low, value), max(high, value)
        if max(high - value, value - low) <= tolerance:
            last_index = index
    return last_index
