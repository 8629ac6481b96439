"""Moves of the focus as keys: pulls, recorded moves, followed things, and frames too close."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import Enum, StrEnum, auto
from math import inf

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.core.model.curves.key_reduction import Samples, reduce_keys, trim_still_ends
from heatlens.core.model.focus.live_focus import Distances, Follow, LiveFocus, MeasuredMark, Pursuit
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot, live_sharp_dioptres

_SNAP_AFTER = 0.7  # share of the frames for which a late snap waits
_OVERSHOOT, _OVERSHOOT_END = 0.08, 0.75  # shares of the way in dioptres, and of the frames
_LEAST_DIOPTRES = 1e-4  # an overshoot that goes below this goes to infinity
EASE_PERCENT = 100 / 3  # the influence in a smooth curve
_KEY_ERROR_SHARE = 0.125  # largest error of the keys, as a share of the sharp range
_UNNAMED_MARK = "it"
TOLERANCE_LEAST, TOLERANCE_MOST = 1e-4, 1.0  # of a recorded pull, in dioptres


def pull(
    shot: Shot,
    from_distance_m: float,
    to_distance_m: float,
    start_frame: float,
    frames: float,
    ease_percent: float = EASE_PERCENT,
) -> Shot:
    """Pull the focus from one distance to another in `frames` frames from `start_frame` on.

    `ease_percent` is the influence at both ends: 0 starts and stops abruptly, 100 most gently.
    Focus keys inside the pull are removed. Raises InputError for a pull without frames or beyond an
    ease, LensError for a distance at which no lens can be focused.
    """
    if not frames > 0:
        raise InputError(f"A focus pull must last more than 0 frames, got {frames:g}.")
    ease, end_frame = Ease(ease_percent), start_frame + frames
    curve = _without_keys_between(shot, start_frame, end_frame)
    first = curve.key_at(start_frame) or Key(start_frame, from_distance_m)
    last = curve.key_at(end_frame) or Key(end_frame, to_distance_m)
    bezier = Interpolation.BEZIER
    pulled_shot = shot.with_curve(
        LensParameter.FOCUS_DISTANCE,
        curve.with_key(
            replace(first, value=from_distance_m, interpolation=bezier, ease_out=ease)
        ).with_key(replace(last, value=to_distance_m, ease_in=ease)),
    )
    for frame in (start_frame, end_frame):
        pulled_shot.lens_at(frame)  # raises LensError
    return pulled_shot


class PullShape(StrEnum):
    """How a pull goes from one distance to the other."""

    EASE = "ease"
    LINEAR = "linear"
    SNAP = "late snap"
    OVERSHOOT = "overshoot and settle"


def shaped_pull(
    shot: Shot,
    from_distance_m: float,
    to_distance_m: float,
    start_frame: float,
    frames: float,
    shape: PullShape = PullShape.EASE,
    ease_percent: float = EASE_PERCENT,
) -> Shot:
    """Pull the focus as `pull` does, in a shape; `ease_percent` applies where the shape eases.

    A late snap waits for most of the time and then moves quickly. An overshoot passes the end by a
    share of the way, in dioptres, and comes back. Raises what `pull` raises.
    """
    origin, target = from_distance_m, to_distance_m
    if shape is PullShape.LINEAR:
        return pull(shot, origin, target, start_frame, frames, 0.0)
    if shape is PullShape.SNAP:
        # The first pull sets the keys at both ends; the second lets the focus wait at its start.
        wait_frames = float(round(_SNAP_AFTER * frames))
        pulled_shot = pull(shot, origin, target, start_frame, frames, ease_percent)
        moving = start_frame + wait_frames, frames - wait_frames
        return pull(pulled_shot, origin, target, *moving, ease_percent)
    if shape is PullShape.OVERSHOOT and frames > 1:
        # Three pulls: the keys at both ends, then past the target, then back to it.
        dioptres = 1.0 / target + _OVERSHOOT * (1.0 / target - 1.0 / origin)
        overshoot_m = 1.0 / dioptres if dioptres > _LEAST_DIOPTRES else inf
        overshoot_frames = float(max(round(_OVERSHOOT_END * frames), 1))
        pulled_shot = pull(shot, origin, target, start_frame, frames, ease_percent)
        pulled_shot = pull(
            pulled_shot, origin, overshoot_m, start_frame, overshoot_frames, ease_percent
        )
        coming_back = start_frame + overshoot_frames, frames - overshoot_frames
        return pull(pulled_shot, overshoot_m, target, *coming_back, ease_percent)
    return pull(shot, origin, target, start_frame, frames, ease_percent)


def reverse_focus(shot: Shot, frames: FrameRange) -> Shot:
    """Return the shot with the keys of the focus between two frames in the opposite order.

    With keys at both ends, the focus at each frame is the old focus at the mirrored frame. Raises
    InputError for fewer than two keys.
    """
    curve = shot.curves.focus_distance_m
    keys_inside = [key for key in curve.keys if frames.first <= key.frame <= frames.last]
    if len(keys_inside) < 2:
        raise InputError("A pull needs two keys of the focus before it can be reversed.")
    first, last = keys_inside[0].frame, keys_inside[-1].frame
    # The segment after a mirrored key is the one before the old key, which the previous key shaped.
    mirrored_keys = [
        replace(
            key,
            frame=first + last - key.frame,
            interpolation=previous_key.interpolation,
            ease_in=key.ease_out,
            ease_out=key.ease_in,
        )
        for previous_key, key in zip([keys_inside[-1], *keys_inside[:-1]], keys_inside, strict=True)
    ]
    curve = curve.without_keys([key.frame for key in keys_inside])
    for key in mirrored_keys:
        curve = curve.with_key(key)
    return shot.with_curve(LensParameter.FOCUS_DISTANCE, curve)


def hold_focus(shot: Shot, frame: float) -> Shot:
    """Return the shot with a focus key at a frame that holds until the next key."""
    keyed_shot = shot.with_key(frame, LensParameter.FOCUS_DISTANCE)
    curve = keyed_shot.curves.focus_distance_m
    key = curve.key_at(frame)
    assert key is not None
    held_curve = curve.with_key(replace(key, interpolation=Interpolation.HOLD))
    return keyed_shot.with_curve(LensParameter.FOCUS_DISTANCE, held_curve)


def apply_recorded_focus(
    shot: Shot, samples: Samples, tolerance_dioptres: float, by_hand: bool = False
) -> Shot:
    """Return the shot with a recorded focus as few keys, which replace those in its range.

    `samples` are (frame, focus distance in meters) in the order of the frames, at least one. The
    focus is off by no more than the tolerance at each of them. A pull that was performed `by_hand`
    has its keys where the hand moves, and its ends ease. Raises LensError if no lens can be
    focused, InputError for infinity on a scale of meters.
    """
    scale = shot.curves.focus_distance_m.scale
    moving_samples = trim_still_ends(samples, tolerance_dioptres) if by_hand else samples
    keys = reduce_keys(moving_samples, tolerance_dioptres, scale, by_hand)
    return _record_keys(shot, LensParameter.FOCUS_DISTANCE, samples, keys)


# A recording without movement is a single key, from which the lens would drift towards the next key
# of the curve. A recorded constant focal length did so.
def _hold_ends(keys: list[Key], first: float, last: float, other_keys_curve: Curve) -> list[Key]:
    """Return the keys of a recording from frame `first` to `last`, with its end values held.

    A value is held up to an end of the recording if the curve has other keys beyond that end.
    """
    if len(keys) == 1 and last > first:  # still
        return [replace(keys[0], interpolation=Interpolation.HOLD), Key(last, keys[0].value)]
    held_keys = list(keys)
    if keys[0].frame > first and any(key.frame < first for key in other_keys_curve.keys):
        held_keys.insert(0, Key(frame=first, value=keys[0].value, interpolation=Interpolation.HOLD))
    if keys[-1].frame < last and any(key.frame > last for key in other_keys_curve.keys):
        held_keys[-1] = replace(held_keys[-1], interpolation=Interpolation.HOLD)
        held_keys.append(Key(last, keys[-1].value))
    return held_keys


def apply_recorded_parameter(
    shot: Shot, parameter: LensParameter, track: Mapping[int, float]
) -> Shot:
    """Return the shot with a recorded parameter as few keys, which replace those in its range.

    `track` is the value by frame. The keys differ from it invisibly little: by 1 % of an f-stop and
    0.2 % of a focal length. Raises LensError if there can be no such lens.
    """
    samples = sorted(track.items())
    tolerance = parameter.facts.unseen_share / max(track.values())
    keys = reduce_keys(samples, tolerance, shot.curves.of(parameter).scale)
    return _record_keys(shot, parameter, samples, keys)


def _record_keys(
    shot: Shot, parameter: LensParameter, samples: Samples, keys: Sequence[Key]
) -> Shot:
    """Return the shot with the keys of a recording in place of those in the range of its samples.

    Raises LensError if there can be no such lens at one of the samples.
    """
    curve, (first, last) = shot.curves.of(parameter), (samples[0][0], samples[-1][0])
    replaced_frames = [key.frame for key in curve.keys if first <= key.frame <= last]
    other_keys_curve = curve.without_keys(replaced_frames)
    held_keys = _hold_ends(list(keys), first, last, other_keys_curve)
    recorded_shot = shot.with_curve(parameter, other_keys_curve.paste_keys(held_keys, 0))
    for frame, _ in samples:
        recorded_shot.lens_at(frame)  # raises LensError
    return recorded_shot


def frames_too_close(shot: Shot) -> tuple[int, ...]:
    """Return the frames at which the focus is nearer than the lens's close focus."""
    limit_m, span = shot.lens.close_focus_m, shot.span
    if limit_m is None or span is None:
        return ()
    return tuple(frame for frame in span if shot.focus_distance_at(frame) < limit_m)


def _without_keys_between(shot: Shot, first: float, last: float) -> Curve:
    """Return the focus without its keys between two frames; keys at these two stay."""
    curve = shot.curves.focus_distance_m
    return curve.without_keys([key.frame for key in curve.keys if first < key.frame < last])


def focus_on_distances(shot: Shot, distances_m: Distances, follow: Follow | None = None) -> Shot:
    """Return the shot with the focus on a thing at all frames of `distances_m`.

    Its keys replace all keys in their range. With the default `follow` the focus is off by no more
    than a quarter of the sharp range. Raises InputError if the thing is hidden at every frame,
    LensError if it comes nearer than a lens can be focused.
    """
    frames = sorted(distances_m)
    if not any(distance_m is not None for distance_m in distances_m.values()):
        raise InputError("The mark is hidden, or out of the picture, at every frame.")
    measured_mark = MeasuredMark(_UNNAMED_MARK, tuple(distances_m[frame] for frame in frames))
    return _bake(
        shot, LiveFocus((Pursuit(_UNNAMED_MARK),), follow or Follow(), frames[0], (measured_mark,))
    )


def bake_live_focus(shot: Shot) -> Shot:
    """Return a shot with keys in place of the focus that follows; without one, unchanged."""
    live = shot.curves.live
    if live is None:
        return shot
    keyless_shot = replace(shot, curves=replace(shot.curves, live=None))
    return _bake(keyless_shot, live) if live.measured else keyless_shot


def _bake(shot: Shot, live: LiveFocus) -> Shot:
    """Return the shot with few keys that follow the measured focus of `live`."""
    half_sharp_dioptres = live_sharp_dioptres(shot, live.frames)
    track = live.dioptres(half_sharp_dioptres, shot.frames_per_second)
    samples = [
        (frame, Scale.RECIPROCAL.value_at(dioptres))
        for frame, dioptres in zip(live.frames, track, strict=True)
    ]
    return apply_recorded_focus(shot, samples, 2.0 * _KEY_ERROR_SHARE * min(half_sharp_dioptres))


class RecordingState(Enum):
    """The stages of a recording, in their order."""

    OFF = auto()
    ARMED = auto()  # the count-in begins when the shot is to play
    COUNTING = auto()  # 3, 2, 1: the user takes hold of the focus before playback starts
    RECORDING = auto()
    RECORDED = auto()  # the keys are set, and their tolerance can still be changed

    @property
    def is_waiting(self) -> bool:
        """True from arming a recording until its keys are set."""
        return self not in (RecordingState.OFF, RecordingState.RECORDED)
