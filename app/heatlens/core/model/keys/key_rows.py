"""The rows of the timeline that can have keys: the lens parameters and the camera."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Final

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot


class CameraRow(StrEnum):
    """The row of the shot's own camera in a scene."""

    CAMERA = "camera"

    @property
    def words(self) -> str:
        """The name of the row as the screen shows it."""
        return str(self)


CAMERA: Final = CameraRow.CAMERA
Row = LensParameter | CameraRow
ROWS: tuple[Row, ...] = (*LensParameter, CAMERA)
KeyedCurve = Curve | CameraTrack


class RowChoice:
    """The selected row of the timeline: a lens parameter or the camera.

    The camera's row has no curve, and exists only while a scene is open.
    """

    def __init__(self, has_camera: Callable[[], bool]) -> None:
        self._has_camera = has_camera
        self.shows_curve = False
        self.curve_parameter = LensParameter.FOCUS_DISTANCE
        self._is_on_camera = False

    @property
    def has_camera(self) -> bool:
        """True if there is a row of the camera."""
        return self._has_camera()

    def toggle_curve(self) -> None:
        """Switch between the curve of the selected row and the keys of all rows."""
        self.shows_curve = not self.shows_curve

    @property
    def selected_row(self) -> Row:
        """The camera's row if it was selected last and is shown, else the parameter's row."""
        is_camera_shown = self.has_camera and not self.shows_curve
        return CAMERA if self._is_on_camera and is_camera_shown else self.curve_parameter

    def select(self, row: Row) -> None:
        """Select a row; for a lens parameter, also show its curve."""
        self._is_on_camera = row is CAMERA
        self.curve_parameter = row if isinstance(row, LensParameter) else self.curve_parameter


def key_frames(shot: Shot, row: Row) -> tuple[float, ...]:
    """Return the frames with keys of a row, in order; a camera that does not move has none."""
    if row is CAMERA:
        return shot.camera_key_frames
    return tuple(key.frame for key in shot.curves.of(row).keys)


def shown_rows(shot: Shot, has_camera: bool) -> tuple[Row, ...]:
    """Return the rows that the timeline shows: the focus, and each that has keys.

    The others get their first key by the dot beside their control in the Lens panel.
    """
    lens_rows = (
        parameter
        for parameter in LensParameter
        if parameter is LensParameter.FOCUS_DISTANCE or key_frames(shot, parameter)
    )
    return (*lens_rows, CAMERA) if has_camera else tuple(lens_rows)


def keys_of(shot: Shot, row: Row) -> tuple[Key | PoseKey, ...]:
    """Return the keys of a row, in order."""
    if row is not CAMERA:
        return shot.curves.of(row).keys
    track = _camera_track(shot)
    return track.keys if track is not None and track.is_moving else ()


def key_count(shot: Shot) -> int:
    """Count all keys, including the single key of a camera that does not move."""
    track = _camera_track(shot)
    lens_count = sum(len(shot.curves.of(parameter).keys) for parameter in LensParameter)
    return lens_count + (len(track.keys) if track else 0)


def keyed_curve(shot: Shot, row: Row) -> KeyedCurve | None:
    """Return the keyed curve or track of a row; None for a camera of the scene's file."""
    return _camera_track(shot) if row is CAMERA else shot.curves.of(row)


def with_keyed_curve(shot: Shot, row: Row, keyed: KeyedCurve) -> Shot:
    """Return the shot with the curve or track of a row replaced."""
    if isinstance(keyed, CameraTrack):
        return replace(shot, framing=replace(shot.framing or Framing(), track=keyed))
    return shot if row is CAMERA else shot.with_curve(row, keyed)


def without_row_keys(shot: Shot, row: Row, frame: float) -> Shot:
    """Remove all keys of a row; the value at `frame` stays."""
    if row is not CAMERA:
        return shot.without_keys(frame, row)
    camera_track = _camera_track(shot)
    if camera_track is None:
        return shot
    return with_keyed_curve(shot, row, CameraTrack((PoseKey(frame, camera_track.pose_at(frame)),)))


def paste_into_row(shot: Shot, row: Row, keys: Sequence[Key | PoseKey], at_frame: float) -> Shot:
    """Paste keys, whose frames begin at 0, from `at_frame` on.

    Raise InputError for keys of a camera if there is no scene.
    """
    curve_keys = [key for key in keys if isinstance(key, Key)]
    if row is not CAMERA:
        return shot.with_curve(row, shot.curves.of(row).paste_keys(curve_keys, at_frame))
    if shot.framing is None:
        raise InputError(
            "The copied keys are those of a camera, and a plate has none: open a scene."
        )
    poses = [key for key in keys if isinstance(key, PoseKey)]
    track = _camera_track(shot) or CameraTrack(tuple(poses)).move_keys(
        [k.frame for k in poses], at_frame
    )
    return with_keyed_curve(shot, row, track.paste_keys(poses, at_frame))


def _camera_track(shot: Shot) -> CameraTrack | None:
    """Return the shot's own track of the camera; None for a plate or the camera of a file."""
    return None if shot.framing is None else shot.framing.track
