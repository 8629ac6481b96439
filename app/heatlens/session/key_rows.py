"""The rows of the timeline: what has keys there, the parameters of the lens and the camera."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Final

from heatlens.errors import InputError
from heatlens.model.curve import Curve, Key
from heatlens.model.framing import CameraTrack, Framing, PoseKey
from heatlens.model.shot import LensParameter, Shot


class CameraRow(StrEnum):
    """Where the shot's own camera stands in a scene."""

    CAMERA = "camera"

    @property
    def words(self) -> str:
        """The name as people say it."""
        return str(self)


CAMERA: Final = CameraRow.CAMERA
Row = LensParameter | CameraRow
ROWS: tuple[Row, ...] = (*LensParameter, CAMERA)
Keyed = Curve | CameraTrack


class RowChoice:
    """The row that is chosen on the timeline: a parameter with its curve, or the camera.

    The camera's row has no curve, and is only there while a scene is open.
    """

    def __init__(self, has_scene: Callable[[], bool]) -> None:
        self._has_scene = has_scene
        self.shows_curve = False
        self.curve_of = LensParameter.FOCUS_DISTANCE
        self._is_on_camera = False

    def toggle_curve(self) -> None:
        """Show the curve of the chosen row, or the keys of all rows."""
        self.shows_curve = not self.shows_curve

    @property
    def chosen(self) -> Row:
        """The camera's row while it was chosen last and is seen, else the one with the curve."""
        is_seen = self._has_scene() and not self.shows_curve
        return CAMERA if self._is_on_camera and is_seen else self.curve_of

    def choose(self, row: Row) -> None:
        """Choose a row; a parameter is the one whose curve is shown from now on."""
        self._is_on_camera = row is CAMERA
        self.curve_of = row if isinstance(row, LensParameter) else self.curve_of


def key_frames(shot: Shot, row: Row) -> tuple[float, ...]:
    """Return the frames at which a row has keys, in order; a camera that stands still has none."""
    if row is CAMERA:
        return shot.camera_key_frames
    return tuple(key.frame for key in shot.curves.of(row).keys)


def keys_of(shot: Shot, row: Row) -> tuple[Key | PoseKey, ...]:
    """Return the keys of a row, in order."""
    if row is not CAMERA:
        return shot.curves.of(row).keys
    track = _track(shot)
    return track.keys if track is not None and track.is_moving else ()


def key_count(shot: Shot) -> int:
    """Count all keys, that of a camera that stands still among them."""
    track = _track(shot)
    of_lens = sum(len(shot.curves.of(parameter).keys) for parameter in LensParameter)
    return of_lens + (len(track.keys) if track else 0)


def keyed_of(shot: Shot, row: Row) -> Keyed | None:
    """Return what has the keys of a row; None for a camera that is not the shot's own."""
    return _track(shot) if row is CAMERA else shot.curves.of(row)


def with_keyed(shot: Shot, row: Row, keyed: Keyed) -> Shot:
    """Return the shot with other keys in a row."""
    if isinstance(keyed, CameraTrack):
        return replace(shot, framing=replace(shot.framing or Framing(), track=keyed))
    return shot if row is CAMERA else shot.with_curve(row, keyed)


def stilled(shot: Shot, row: Row, frame: float) -> Shot:
    """Remove all keys of a row; what they gave at `frame` stays."""
    if row is not CAMERA:
        return shot.without_keys(frame, row)
    track = _track(shot)
    if track is None:
        return shot
    return with_keyed(shot, row, CameraTrack((PoseKey(frame, track.pose_at(frame)),)))


def with_pasted(shot: Shot, row: Row, keys: Sequence[Key | PoseKey], at_frame: float) -> Shot:
    """Paste keys that were counted from 0, from `at_frame` on.

    Raises InputError for keys of a camera where there is no scene.
    """
    curve_keys = [key for key in keys if isinstance(key, Key)]
    if row is not CAMERA:
        return shot.with_curve(row, shot.curves.of(row).pasted(curve_keys, at_frame))
    if shot.framing is None:
        raise InputError("Keys of a camera were copied, and a plate has none: open a scene.")
    poses = [key for key in keys if isinstance(key, PoseKey)]
    track = _track(shot) or CameraTrack(tuple(poses)).moved([k.frame for k in poses], at_frame)
    return with_keyed(shot, row, track.pasted(poses, at_frame))


def _track(shot: Shot) -> CameraTrack | None:
    return None if shot.framing is None else shot.framing.track
