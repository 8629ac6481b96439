"""The commands on the camera of a scene: orbit, truck, dolly, frame, keys, other cameras."""

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import report_errors
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import free_letter
from heatlens.core.model.marks.marks import ObjectMark, PointMark
from heatlens.core.model.shot.camera_track import Pose, Vector
from heatlens.core.model.shot.framing import Framing, WorldAxis
from heatlens.core.model.shot.pull import focus_on_distances
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.orbit import (
    CameraDrag,
    dolly_camera,
    orbit_camera,
    pan_camera,
    pivot_of,
)
from heatlens.media.scene.first_shot import lens_values, through_camera
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import (
    bounds_m,
    corners_m,
    frame_points,
    object_depth_m,
    object_names,
)
from heatlens.studio.session.scenes.clip_choice import ClipChoice
from heatlens.studio.session.scenes.following import PointMeasurement
from heatlens.studio.session.scenes.size_keeping import SizeKeeping
from heatlens.studio.session.shared import Commands, Shared

_TURN_RAD = math.pi  # orbit angle of a drag as long as the picture is high
_DOLLY_SHARE = 0.12  # movement for one wheel notch, as a share of the focus distance


class SceneCommands(Commands):
    """The commands on the camera of a scene; they do nothing for a plate."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._renderer = self._source.picture.renderer
        self.clips, self.size = ClipChoice(shared), SizeKeeping(shared)
        self.selected: str | None = None  # name of the selected object

    @property
    def scene(self) -> Scene | None:
        """The open scene; None if there is none."""
        return self._source.scene

    @property
    def framing(self) -> Framing:
        """The framing of the shot."""
        return self._editing.shot.framing or Framing()

    @property
    def pose(self) -> Pose:
        """The pose of the camera at the current frame; None without a scene."""
        pose = self._renderer.pose_at(self._editing.shot, self._editing.frame)
        assert pose is not None  # there is a scene
        return pose

    def move(self, drag: CameraDrag) -> None:
        """Move the camera by a mouse movement."""
        if not (drag.right or drag.down):
            return
        if drag.kind == "dolly" and self.size.chosen is not None:
            self._zoom(1.0 - _DOLLY_SHARE * drag.down)
            return
        pose, pivot = self.pose, self._pivot_m()
        if drag.kind == "orbit":
            new_pose = orbit_camera(pose, pivot, -_TURN_RAD * drag.right, _TURN_RAD * drag.down)
        elif drag.kind == "truck":
            span_m = self._picture_height_m(
                float(np.linalg.norm(np.subtract(pivot, pose.position_m)))
            )
            new_pose = pan_camera(pose, -span_m * drag.right, span_m * drag.down)
        else:
            new_pose = dolly_camera(pose, pivot, _DOLLY_SHARE * drag.down)
        self._set_pose(new_pose)

    def _zoom(self, factor: float) -> None:
        """Scale the focal length; the camera moves too, as the chosen mark keeps its size."""
        lens = self._editing.lens
        self._editing.edit_lens(replace(lens, focal_length_mm=factor * lens.focal_length_mm))

    def frame_objects(self, name: str | None) -> None:
        """Frame the objects called `name`, or the whole scene if None, from the same direction."""
        scene = self.scene
        if scene is not None and name is not None and name not in object_names(scene):
            self._notify(f"This scene has no object called {name}.")
        elif scene is not None:
            points, aspect = corners_m(scene, self._editing.frame, name), self._aspect
            self._set_pose(frame_points(points, self._editing.lens, aspect, self.pose.turn))
            self._editing.settle()

    def frame_selected(self) -> None:
        """Frame the selected object, or the whole scene if none is selected."""
        self.frame_objects(self.selected)

    def object_m(self, name: str, frame: int | None = None) -> float | None:
        """Return the distance of an object in m; None if there is no such object in front."""
        try:
            return self._depth_m(name, self._editing.frame if frame is None else frame)
        except InputError:
            return None

    def _depth_m(self, name: str, frame: int) -> float:
        """Return the distance of an object in m.

        Raise InputError if there is no such object, or it cannot be focused on.
        """
        scene, pose = self.scene, self._renderer.pose_at(self._editing.shot, frame)
        if scene is None or pose is None:
            raise InputError(f"No scene is open that could have an object called {name!r}.")
        return object_depth_m(scene, name, pose, frame)

    def point_m(self, x_px: int, y_px: int, frame: int) -> float | None:
        """Return the distance at a pixel at a frame, in m; None outside the picture."""
        try:
            return self._renderer.scene_depth_m(self._editing.shot, frame, x_px, y_px)
        except InputError:
            return None

    def measure_point(self, mark: PointMark, frames: FrameRange) -> PointMeasurement | None:
        """Begin to measure the distance of a point at each of `frames`; None without a scene."""
        scene = self._renderer.scene
        if scene is None:
            return None
        return PointMeasurement(self._renderer, scene, self._editing.shot, mark, frames)

    def focus_on(self, name: str) -> None:
        """Focus on the middle of an object. Raise InputError if that is impossible."""
        depth_m = self._depth_m(name, self._editing.frame)
        self._editing.edit_lens(replace(self._editing.lens, focus_distance_m=depth_m))

    def set_mark(self, name: str) -> None:
        """Set a mark that moves with the object."""
        shot = self._editing.shot
        mark = ObjectMark(free_letter(shot_mark.name for shot_mark in shot.marks), name)
        self._editing.do(replace(shot, marks=(*shot.marks, mark)))

    def follow(self, mark: ObjectMark, frames: FrameRange) -> None:
        """Keep the focus on an object from in to out, and notify the user."""
        name = mark.object_name
        with report_errors(self._notify):
            distances_m = {frame: self._depth_m(name, frame) for frame in frames}
            self._editing.do(focus_on_distances(self._editing.shot, distances_m))
            self._notify(f"The focus follows {name} from {frames.first} on.")

    def look_through(self, name: str) -> None:
        """Look through a camera of the scene, with the lens values that the file has for it.

        Keys of the shot's own camera are removed, and keys of lens values in the file are replaced
        by those of the file. All of this is one undo step. Notifies the user.
        """
        scene = self.scene
        if scene is None:
            return
        camera = scene.camera_named(name)
        self._editing.do(through_camera(self._editing.shot, camera))
        self._notify(_camera_message(name, self._editing.lens, lens_values(camera)))

    def set_axis_and_unit(self, up_axis: WorldAxis, meters_per_unit: float) -> None:
        """Set the up axis and the unit of the file, and frame the whole scene again.

        A focus without keys scales with the unit, and so stays on the same object.
        """
        framing, shot = self.framing, self._editing.shot
        if (framing.up_axis, framing.meters_per_unit) == (up_axis, meters_per_unit):
            return
        ratio = meters_per_unit / framing.meters_per_unit
        focus_m = max(shot.lens.focus_distance_m * ratio, 2e-3 * shot.lens.focal_length_mm)
        new_framing = replace(
            framing, up_axis=up_axis, meters_per_unit=meters_per_unit, camera=None, track=None
        )
        lens = replace(shot.lens, focus_distance_m=focus_m)
        self._editing.do(replace(shot, framing=new_framing, lens=lens))

    def set_key(self) -> None:
        """Set a key for the camera at this frame; without a track, it begins one."""
        if not self._source.has_camera:
            return
        pose = self.pose
        frame, track = self._editing.frame, self.framing.track
        framing = (
            self.framing.with_pose(pose, frame)
            if track is None
            else replace(self.framing, track=track.with_key(frame, pose))  # also to a single key
        )
        self._editing.do(replace(self._editing.shot, framing=framing))

    def toggle_key(self) -> None:
        """Set a key of the camera at this frame, or delete the one that is there."""
        if self._editing.frame in self.key_frames:
            self.delete_key()
        else:
            self.set_key()

    def delete_key(self) -> None:
        """Delete the camera's key at this frame."""
        track = self.framing.track
        if track is not None:
            new_framing = replace(self.framing, track=track.without_key(self._editing.frame))
            self._editing.do(replace(self._editing.shot, framing=new_framing))

    @property
    def key_frames(self) -> tuple[float, ...]:
        """The frames with keys of the shot's own camera."""
        track = self.framing.track if self._source.has_camera else None
        return () if track is None else tuple(key.frame for key in track.keys)

    @property
    def _aspect(self) -> float:
        return self.framing.width_px / self.framing.height_px

    def _set_pose(self, pose: Pose) -> None:
        """Set the pose of the camera at the playhead, as part of the current gesture."""
        self._editing.edit(
            replace(self._editing.shot, framing=self.framing.with_pose(pose, self._editing.frame))
        )

    def _picture_height_m(self, distance_m: float) -> float:
        """Return the height of the view at a distance, in m."""
        lens = self._editing.lens
        return distance_m * lens.sensor_width_mm / (lens.focal_length_mm * self._aspect)

    def _pivot_m(self) -> Vector:
        """Return the pivot of an orbit: the point in focus, but not behind the whole scene."""
        scene, pose = self.scene, self.pose
        assert scene is not None
        box = bounds_m(scene, self._editing.frame)
        farthest = float(np.linalg.norm(np.abs(box - np.array(pose.position_m)).max(axis=0)))
        return pivot_of(pose, min(self._editing.lens.focus_distance_m, farthest))


def _camera_message(name: str, lens: Lens, given_fields: Collection[str]) -> str:
    """Return a message about the lens values that came with a camera, and those that stayed."""
    words_by_field = {
        "focal_length_mm": f"{lens.focal_length_mm:.4g} mm",
        "f_stop": f"f/{lens.f_stop:.3g}",
        "focus_distance_m": f"focus at {format_distance(lens.focus_distance_m)}",
    }
    given_words = ", ".join(
        words for field, words in words_by_field.items() if field in given_fields
    )
    missing_words = " and ".join(
        words for field, words in words_by_field.items() if field not in given_fields
    )
    return (
        f"Through {name}: {given_words}."
        + f" The file has no other values, so {missing_words} stayed." * bool(missing_words)
    )
