"""A shot that starts from a camera: its lens, with keys for what moves."""

import math
from collections.abc import Collection
from dataclasses import fields, replace

from heatlens.camera.samples import CameraSamples, Track, is_constant
from heatlens.errors import InputError
from heatlens.model.curve import Key
from heatlens.model.interpolation import Interpolation, Scale
from heatlens.model.lens import Lens
from heatlens.model.shot import LensParameter, Shot

# A value that differs by less, as a part of it, is the same one rounded to float32 twice.
_SAME = 2e-7


def with_camera(shot: Shot, camera: CameraSamples, kept: Collection[str] = ()) -> Shot:
    """`shot` with the lens of `camera`; fields of Lens in `kept`, and what it does not tell, stay.

    What moves has linear keys on the scale that the shot has for it, what stands still has none.
    Raises InputError for a film back that changes, LensError where the values make no lens.
    """
    tracks = lens_tracks(camera, kept)
    shot = replace(shot, lens=replace(shot.lens, **{name: t[0] for name, t in tracks.items()}))
    for parameter in LensParameter:
        if parameter in tracks:
            curve = shot.curves.of(parameter)
            keys = linear_keys(camera.frames, tracks[parameter], curve.scale)
            shot = shot.with_curve(parameter, replace(curve, keys=keys))
    for frame in camera.frames:
        shot.lens_at(frame)
    return shot


def lens_tracks(camera: CameraSamples, kept: Collection[str] = ()) -> dict[str, Track]:
    """The tracks that are fields of Lens, but those in `kept`.

    Raises InputError for a sensor width that changes.
    """
    names = {field.name for field in fields(Lens)}.difference(kept)
    tracks = {name: track for name, track in camera.lens_tracks.items() if name in names}
    width_mm = tracks.get("sensor_width_mm")
    if width_mm is not None and not is_constant(width_mm):
        raise InputError(
            f"The sensor of camera {camera.name} is {min(width_mm):g} to {max(width_mm):g} mm "
            "wide, but a shot has one width for all its frames: give the one that it shall have."
        )
    return tracks


def linear_keys(frames: tuple[int, ...], track: Track, scale: Scale) -> tuple[Key, ...]:
    """Keys that meet the track at every frame; none where nothing moves.

    Those that lie on the line between their neighbours on `scale` are left out: from the last key,
    the line to the next must pass each frame between as near as float32 can tell.
    """
    if is_constant(track):
        return ()
    places = [scale.place_of(value) for value in track]
    kept = [0]
    lowest, highest = -math.inf, math.inf  # slopes from the last key that pass all since
    for index in range(1, len(frames)):
        slope, frame_count = _slope(frames, places, kept[-1], index)
        if not lowest <= slope <= highest:
            kept.append(index - 1)
            lowest, highest = -math.inf, math.inf
            slope, frame_count = _slope(frames, places, index - 1, index)
        reach = _slack(track[index], scale) / frame_count
        lowest, highest = max(lowest, slope - reach), min(highest, slope + reach)
    kept.append(len(frames) - 1)
    return tuple(Key(frames[at], track[at], Interpolation.LINEAR) for at in kept)


def _slope(frames: tuple[int, ...], places: list[float], start: int, end: int) -> tuple[float, int]:
    count = frames[end] - frames[start]
    return (places[end] - places[start]) / count, count


def _slack(value: float, scale: Scale) -> float:
    """By how much a place may be off."""
    return _SAME * abs(scale.slope_at(value) * value) if math.isfinite(value) else 0.0
