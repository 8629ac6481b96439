"""Edit a selection of keys across several rows: move, delete, copy, paste, interpolate.

All functions return a new shot; they raise LensError if its keys give an impossible lens.
"""

from collections.abc import Callable, Collection
from dataclasses import replace
from math import ceil, floor
from typing import NamedTuple

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.curves.key_edits import SAME_FRAME
from heatlens.core.model.keys import key_rows
from heatlens.core.model.keys.key_rows import CAMERA, ROWS, KeyedCurve, Row, key_frames
from heatlens.core.model.shot.camera_track import PoseKey
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot

_BEZIER = Interpolation.BEZIER
_MAX_CHECKED = 1000  # largest number of frames between keys to check


class KeyId(NamedTuple):
    """Identifies a key by its row and frame; a row has at most one key per frame."""

    row: Row
    frame: float


KeySelection = frozenset[KeyId]
CopiedKeys = tuple[tuple[Row, tuple[Key | PoseKey, ...]], ...]


def all_keys(shot: Shot) -> KeySelection:
    """Return every key of the shot, of all lens parameters and of the camera."""
    return frozenset(KeyId(row, frame) for row in ROWS for frame in key_frames(shot, row))


def keys_at(shot: Shot, frame: float) -> KeySelection:
    """Return the keys of all rows at a frame, up to a difference of SAME_FRAME."""
    return frozenset(key for key in all_keys(shot) if abs(key.frame - frame) < SAME_FRAME)


def frames_of(selection: KeySelection, row: Row) -> list[float]:
    """Return the frames of one row's keys, in order."""
    return sorted(key.frame for key in selection if key.row is row)


def key_of(shot: Shot, key: KeyId) -> Key | None:
    """Return a key of a lens parameter; None for keys of the camera, which have no value here."""
    return None if key.row is CAMERA else shot.curves.of(key.row).key_at(key.frame)


def with_keys_here(shot: Shot, frame: float) -> Shot:
    """Set keys at the present values for the focus and all keyed parameters."""
    for parameter in LensParameter:
        is_focus = parameter is LensParameter.FOCUS_DISTANCE and shot.curves.live is None
        if is_focus or shot.curves.of(parameter).keys:
            shot = shot.with_key(frame, parameter)
    return shot


def move_keys(shot: Shot, selection: KeySelection, by_frames: float) -> tuple[Shot, KeySelection]:
    """Move the chosen keys by a number of frames; keys that they land on are removed."""
    new_shot = _change_rows(
        shot, selection, lambda keyed, frames: keyed.move_keys(frames, by_frames)
    )
    return new_shot, frozenset(KeyId(row, frame + by_frames) for row, frame in selection)


def ripple_keys(shot: Shot, from_frame: float, by_frames: float) -> Shot:
    """Move all keys from `from_frame` on; moving them earlier cuts frames out."""
    return _change_rows(
        shot, all_keys(shot), lambda keyed, _: keyed.ripple_keys(from_frame, by_frames)
    )


def delete_keys(shot: Shot, selection: KeySelection, frame: float) -> Shot:
    """Remove the chosen keys; a parameter that loses its last key keeps its value at `frame`."""
    for row in ROWS:
        frames = frames_of(selection, row)
        if frames and len(frames) == len(key_frames(shot, row)):
            shot = key_rows.without_row_keys(shot, row, frame)
            selection = frozenset(key for key in selection if key.row is not row)
    return _change_rows(shot, selection, lambda keyed, frames: keyed.without_keys(frames))


def copy_keys(shot: Shot, selection: KeySelection) -> CopiedKeys:
    """Return the chosen keys for `paste_keys`, with frames relative to the first key."""
    first_frame = min((key.frame for key in selection), default=0.0)
    rows_with_keys = []
    for row in ROWS:
        frames = frames_of(selection, row)
        keys = [key for key in key_rows.keys_of(shot, row) if key.frame in frames]
        if keys:
            rows_with_keys.append(
                (row, tuple(replace(key, frame=key.frame - first_frame) for key in keys))
            )
    return tuple(rows_with_keys)


def paste_keys(shot: Shot, keys: CopiedKeys, at_frame: float) -> tuple[Shot, KeySelection]:
    """Paste keys from `at_frame` on; return the shot and the pasted keys as the new selection.

    Raise InputError for keys of a camera if there is no scene.
    """
    for row, copies in keys:
        shot = key_rows.paste_into_row(shot, row, copies, at_frame)
    return check_shot(shot), frozenset(
        KeyId(row_copied, key.frame + at_frame)
        for row_copied, keys_copied in keys
        for key in keys_copied
    )


def interpolate_keys(shot: Shot, selection: KeySelection, interpolation: Interpolation) -> Shot:
    """Set the interpolation after each chosen key; a Bezier keeps the shape of the curve."""

    def change(curve: Curve, frames: Collection[float]) -> Curve:
        """Return the curve with the interpolation set after its keys at `frames`."""
        for frame in frames:
            if interpolation is _BEZIER:
                curve = curve.with_handles(frame)
            key = curve.key_at(frame)
            if key is not None:
                curve = curve.with_key(replace(key, interpolation=interpolation))
        return curve

    return _change_curves(shot, selection, change)


def ease_keys(shot: Shot, selection: KeySelection, influence_percent: float, is_out: bool) -> Shot:
    """Set the influence of the outgoing (`is_out`) or incoming handles, as Bezier segments."""

    def change(curve: Curve, frames: Collection[float]) -> Curve:
        """Return the curve with the influence set at its keys at `frames`."""
        for frame in frames:
            curve = _with_bezier(curve, frame, is_out)
            key = curve.key_at(frame)
            if key is not None:
                name = "ease_out" if is_out else "ease_in"
                ease = replace(getattr(key, name), influence_percent=influence_percent)
                curve = curve.with_key(replace(key, **{name: ease}))
        return curve

    return _change_curves(shot, selection, change)


def _with_bezier(curve: Curve, frame: float, is_out: bool) -> Curve:
    """Return the curve with the segment after (`is_out`) or before a key as a Bezier."""
    previous_frames = [key.frame for key in curve.keys if key.frame < frame - SAME_FRAME]
    start = frame if is_out else previous_frames[-1] if previous_frames else None
    if start is None:
        return curve
    curve = curve.with_handles(start)
    key = curve.key_at(start)
    return curve if key is None else curve.with_key(replace(key, interpolation=_BEZIER))


def check_shot(shot: Shot) -> Shot:
    """Return the shot if its lens is possible at all keys and between them.

    Raise LensError that names the first frame with an impossible lens.
    """
    for frame in (*shot.key_frames, *_frames_to_check(shot)):
        shot.lens_at(frame)
    return shot


def _frames_to_check(shot: Shot) -> range:
    """Return the frames between keys that have to be checked.

    Bezier handles can overshoot, and a long lens cannot focus near. In a long shot only some
    frames are checked, so that dragging stays fast.
    """
    keys, focals = shot.curves.focus_distance_m.keys, shot.curves.focal_length_mm.keys
    if not focals and all(key.interpolation is not _BEZIER for key in keys):
        return range(0)
    first, last = floor(shot.key_frames[0]), ceil(shot.key_frames[-1])
    return range(first, last + 1, 1 + (last - first) // _MAX_CHECKED)


def _change_rows(
    shot: Shot,
    selection: KeySelection,
    change: Callable[[KeyedCurve, Collection[float]], KeyedCurve],
) -> Shot:
    """Apply `change` to each row that has chosen keys."""
    for row in ROWS:
        frames = frames_of(selection, row)
        keyed = key_rows.keyed_curve(shot, row)
        if frames and keyed is not None:
            shot = key_rows.with_keyed_curve(shot, row, change(keyed, frames))
    return check_shot(shot)


def _change_curves(
    shot: Shot, selection: KeySelection, change: Callable[[Curve, Collection[float]], Curve]
) -> Shot:
    """Apply `change` to the curve of each lens parameter that has chosen keys."""
    for parameter in LensParameter:
        frames = frames_of(selection, parameter)
        if frames:
            shot = shot.with_curve(parameter, change(shot.curves.of(parameter), frames))
    return check_shot(shot)
