"""Keyframes of one parameter: a value that moves over frames. Editing a curve makes a new one."""

from bisect import bisect_right
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from itertools import pairwise

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves import key_edits
from heatlens.core.model.curves.frames import check_frame
from heatlens.core.model.curves.interpolation import (
    Ease,
    Interpolation,
    Scale,
    bezier,
    hermite,
    monotone_slope,
)

# Half of it, so that keys moved together stay apart although sums are rounded.
_FRAMES_APART = key_edits.SAME_FRAME / 2


@dataclass(frozen=True, slots=True)
class Key:
    """A value that a curve passes through exactly.

    frame          may lie between two frames
    value          in the parameter's own unit: meters, not dioptres
    interpolation  of the segment after this key
    ease_out       handle into the segment after it, if that is a Bezier
    ease_in        handle into the segment before it, if that is one
    """

    frame: float
    value: float
    interpolation: Interpolation = Interpolation.SMOOTH
    ease_out: Ease = field(default_factory=Ease)
    ease_in: Ease = field(default_factory=Ease)

    def __post_init__(self) -> None:
        check_frame(self.frame)


@dataclass(frozen=True, slots=True)
class Curve:
    """Keys in the order of their frames; the value is constant before and after them.

    Raises InputError for keys out of order and for values outside the scale.
    """

    keys: tuple[Key, ...] = ()
    scale: Scale = Scale.LINEAR

    def __post_init__(self) -> None:
        for key in self.keys:
            self.scale.position_of(key.value)
        for key, next_key in pairwise(self.keys):
            if abs(next_key.frame - key.frame) < _FRAMES_APART:
                raise InputError(f"There are two keys at frame {key.frame:g}: keep one.")
            if not next_key.frame - key.frame >= _FRAMES_APART:
                raise InputError(
                    f"Keys must be sorted by frame: {next_key.frame:g} comes after {key.frame:g}."
                )

    def value_at(self, frame: float) -> float:
        """Return the value at any time, in the parameter's unit; at a key, exactly that of the key.

        Raises ValueError for a curve without keys.
        """
        if not self.keys:
            raise ValueError("a curve without keys has no value")
        index = self._index_before(frame)
        if index < 0:
            return self.keys[0].value
        key = self.keys[index]
        if index == len(self.keys) - 1 or key.frame == frame:
            return key.value
        return self._interpolate(index, frame)

    def key_at(self, frame: float) -> Key | None:
        """Return the key at a frame, or None."""
        return next((key for key in self.keys if key_edits.is_same_frame(key.frame, frame)), None)

    def with_key(self, key: Key) -> "Curve":
        """Return the curve with a key added, or replaced at its frame."""
        return replace(self, keys=key_edits.merge_keys(self.keys, [key]))

    def with_value(self, frame: float, value: float) -> "Curve":
        """Return the curve with a value at `frame`; a new key interpolates as the key before it."""
        key = self.key_at(frame)
        if key is None:
            index = self._index_before(frame)
            previous_key = self.keys[index] if index >= 0 else Key(frame, value)
            key = Key(frame, value, previous_key.interpolation)
        return self.with_key(replace(key, value=value))

    def without_keys(self, frames: Collection[float]) -> "Curve":
        """Return the curve without the keys at these frames."""
        return replace(self, keys=tuple(key for key in self.keys if key.frame not in frames))

    def move_keys(self, frames: Collection[float], by_frames: float) -> "Curve":
        """Return the curve with the keys at these frames moved.

        A moved key replaces a key that is already at its new frame.
        """
        return replace(self, keys=key_edits.move_keys(self.keys, frames, by_frames))

    def ripple_keys(self, from_frame: float, by_frames: float) -> "Curve":
        """Return the curve with all keys from `from_frame` on moved later or earlier.

        Moving earlier cuts frames out, and the keys in those frames are removed.
        """
        return replace(self, keys=key_edits.ripple_keys(self.keys, from_frame, by_frames))

    def paste_keys(self, keys: Collection[Key], at_frame: float) -> "Curve":
        """Return the curve with copied keys from `at_frame` on.

        Pasted keys replace those at their frames.
        """
        return replace(self, keys=key_edits.paste_keys(self.keys, keys, at_frame))

    def convert_scale(self, scale: Scale) -> "Curve":
        """Return the same keys on another scale; the speed of the value at each key stays.

        Raises InputError if a value does not exist on that scale.
        """
        if scale is self.scale:
            return self
        Curve(self.keys, scale)  # raises for values outside the scale, before slopes are computed
        keys = (
            _scale_speeds(key, scale.slope_at(key.value) / self.scale.slope_at(key.value))
            for key in self.keys
        )
        return Curve(tuple(keys), scale)

    def with_handles(self, frame: float) -> "Curve":
        """Return the curve with the segment at `frame` as a Bezier along the same path.

        Its handles can then be moved. A segment that holds its value, and one that is a Bezier
        already, stay unchanged.
        """
        index = self._index_before(frame)
        if not 0 <= index < len(self.keys) - 1:
            return self
        start, end = self.keys[index : index + 2]
        if start.interpolation is Interpolation.LINEAR:
            slopes = (self._chord(index)[1],) * 2
        elif start.interpolation is Interpolation.SMOOTH:
            slopes = self._slope(index), self._slope(index + 1)
        else:
            return self
        ease_out, ease_in = (Ease(speed_per_frame=slope) for slope in slopes)
        bezier_key = replace(start, interpolation=Interpolation.BEZIER, ease_out=ease_out)
        return self.with_key(bezier_key).with_key(replace(end, ease_in=ease_in))

    def _interpolate(self, index: int, frame: float) -> float:
        """Return the value at a frame inside the segment after the key with this index."""
        start, end = self.keys[index], self.keys[index + 1]
        frames = end.frame - start.frame
        u = (frame - start.frame) / frames  # share of the segment, 0 to 1
        end_positions = self.scale.position_of(start.value), self.scale.position_of(end.value)
        value_bounds = [start.value, end.value]  # only handles can leave this range
        match start.interpolation:
            case Interpolation.HOLD:
                return start.value
            case Interpolation.LINEAR:
                position = end_positions[0] + (end_positions[1] - end_positions[0]) * u
            case Interpolation.SMOOTH:
                slopes = self._slope(index), self._slope(index + 1)
                position = hermite(u, end_positions, (slopes[0] * frames, slopes[1] * frames))
            case Interpolation.BEZIER:
                out_handle, in_handle = start.ease_out.handle(frames), end.ease_in.handle(frames)
                handles = (
                    (out_handle[0] / frames, out_handle[1]),
                    (in_handle[0] / frames, in_handle[1]),
                )
                position = bezier(u, end_positions, *handles)
                handle_tips = (end_positions[0], out_handle[1]), (end_positions[1], -in_handle[1])
                value_bounds += [
                    self.scale.value_at(origin + rise) for origin, rise in handle_tips if rise
                ]
        low, high = min(value_bounds), max(value_bounds)
        return min(
            max(self.scale.value_at(position), low), high
        )  # rounding must not leave the range

    def _slope(self, index: int) -> float:
        """Return the slope on the scale, per frame, at the key with this index.

        It is 0 at the first and the last key, beyond which the value is constant.
        """
        if index in (0, len(self.keys) - 1):
            return 0.0
        return monotone_slope(self._chord(index - 1), self._chord(index))

    def _chord(self, index: int) -> tuple[float, float]:
        """Return the frames of the segment after a key, and its rise on the scale per frame.

        The rise is 0 if the key holds its value.
        """
        start, end = self.keys[index], self.keys[index + 1]
        frames = end.frame - start.frame
        if start.interpolation is Interpolation.HOLD:
            return frames, 0.0
        return frames, (
            self.scale.position_of(end.value) - self.scale.position_of(start.value)
        ) / frames

    def _index_before(self, frame: float) -> int:
        """Return the index of the last key at or before a frame; -1 before the first."""
        return bisect_right(self.keys, frame, key=key_edits.frame_of) - 1


def _scale_speeds(key: Key, factor: float) -> Key:
    """Return the key with the speed of both handles times `factor`."""
    ease_out, ease_in = (
        replace(ease, speed_per_frame=ease.speed_per_frame * factor)
        for ease in (key.ease_out, key.ease_in)
    )
    return replace(key, ease_out=ease_out, ease_in=ease_in)
