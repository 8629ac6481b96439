"""Moves of the focus as one gesture: from here to there, along with something, and how near."""

from collections.abc import Callable
from dataclasses import replace

from heatlens.errors import InputError
from heatlens.model.curve import Curve, Key
from heatlens.model.frames import FrameRange
from heatlens.model.interpolation import Ease, Interpolation
from heatlens.model.marks import DepthAt, DistanceMark, PointMark, distance_at_m
from heatlens.model.shot import LensParameter, Shot

EASE_PERCENT = 100 / 3  # as a smooth curve leaves and arrives


def pull(
    shot: Shot,
    from_distance_m: float,
    to_distance_m: float,
    start_frame: float,
    frames: float,
    ease_percent: float = EASE_PERCENT,
) -> Shot:
    """Focus is pulled from one distance to another, leaving at `start_frame`, in `frames` frames.

    `ease_percent` is the influence at both ends: 0 starts and stops at once, 100 lingers longest.
    Focus keys inside the pull go. Raises InputError for a pull without frames or beyond an ease,
    LensError for a distance at which no lens can be focused.
    """
    if not frames > 0:
        raise InputError(f"A focus pull must last more than 0 frames, got {frames:g}.")
    ease, end_frame = Ease(ease_percent), start_frame + frames
    curve = _cleared(shot, start_frame, end_frame)
    first = curve.key_at(start_frame) or Key(start_frame, from_distance_m)
    last = curve.key_at(end_frame) or Key(end_frame, to_distance_m)
    bezier = Interpolation.BEZIER
    pulled = shot.with_curve(
        LensParameter.FOCUS_DISTANCE,
        curve.with_key(
            replace(first, value=from_distance_m, interpolation=bezier, ease_out=ease)
        ).with_key(replace(last, value=to_distance_m, ease_in=ease)),
    )
    for frame in (start_frame, end_frame):
        pulled.lens_at(frame)
    return pulled


def follow(
    shot: Shot, mark: DistanceMark | PointMark, frames: FrameRange, depth_at: DepthAt
) -> Shot:
    """Focus stays on a mark through `frames`: a key at each, in the place of those there were.

    Raises LensError where the mark comes nearer than a lens can be focused.
    """
    return followed(shot, frames, lambda frame: distance_at_m(mark, frame, depth_at, frames))


def followed(shot: Shot, frames: FrameRange, distance_m: Callable[[int], float]) -> Shot:
    """Focus is at `distance_m` of each frame, as in `follow`."""
    curve = _cleared(shot, frames.first, frames.last)
    keys = [Key(frame, distance_m(frame), Interpolation.LINEAR) for frame in frames]
    pulled = shot.with_curve(LensParameter.FOCUS_DISTANCE, curve.pasted(keys, 0))
    for frame in frames:
        pulled.lens_at(frame)
    return pulled


def frames_too_close(shot: Shot) -> tuple[int, ...]:
    """Return the frames at which the focus is nearer than the lens's close focus."""
    limit_m, span = shot.lens.close_focus_m, shot.span
    if limit_m is None or span is None:
        return ()
    return tuple(frame for frame in span if shot.lens_at(frame).focus_distance_m < limit_m)


def _cleared(shot: Shot, first: float, last: float) -> Curve:
    """Return the focus without its keys between two frames; keys at these two stay."""
    curve = shot.curves.focus_distance_m
    return curve.without_keys([key.frame for key in curve.keys if first < key.frame < last])
