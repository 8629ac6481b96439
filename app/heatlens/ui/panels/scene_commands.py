"""The hand on the scene's camera: round what is in focus, aside, nearer, through its cameras."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from heatlens.errors import HeatlensError, InputError
from heatlens.model.frames import FrameRange
from heatlens.model.framing import Framing, Pose, Vector
from heatlens.model.marks import ObjectMark, next_mark_name
from heatlens.model.orbit import dollied, orbited, panned, pivot_of
from heatlens.model.pull import followed
from heatlens.scene.scene import Scene
from heatlens.scene.scene_bounds import (
    bounds_m,
    camera_lens,
    corners_m,
    framed,
    object_depth_m,
    object_names,
)

if TYPE_CHECKING:
    from heatlens.ui.app import App

_TURN_RAD = math.pi  # for a drag over the height of the picture
_DOLLY_SHARE = 0.12  # of the way, for a notch of the wheel


@dataclass(frozen=True, slots=True)
class CameraDrag:
    """What the mouse did: a share of the picture's height to the right and down, or notches."""

    kind: Literal["orbit", "truck", "dolly"]
    right: float = 0.0
    down: float = 0.0


class SceneCommands:
    """What can be done with the camera of a scene; nothing where a plate is open."""

    def __init__(self, app: "App") -> None:
        self._app = app
        self.selected: str | None = None  # name of an object

    @property
    def scene(self) -> Scene | None:
        """The scene that is open."""
        return self._app.source.scene

    @property
    def framing(self) -> Framing:
        """How it is looked at."""
        return self._app.shot.framing or Framing()

    @property
    def pose(self) -> Pose:
        """Where the camera stands at the frame."""
        pose = self._app.renderer.pose_at(self._app.shot, self._app.editing.frame)
        assert pose is not None  # there is a scene
        return pose

    def move(self, drag: CameraDrag) -> None:
        """Answer the mouse; one that is only held moves nothing."""
        if not (drag.right or drag.down):
            return
        pose, pivot = self.pose, self._pivot_m()
        if drag.kind == "orbit":
            moved = orbited(pose, pivot, -_TURN_RAD * drag.right, _TURN_RAD * drag.down)
        elif drag.kind == "truck":
            span_m = self._height_m(float(np.linalg.norm(np.subtract(pivot, pose.position_m))))
            moved = panned(pose, -span_m * drag.right, span_m * drag.down)
        else:
            moved = dollied(pose, pivot, _DOLLY_SHARE * drag.down)
        self._stand(moved)

    def frame(self, name: str | None) -> None:
        """See the objects called `name`, or the whole scene, from the same side."""
        scene = self.scene
        if scene is not None and name is not None and name not in object_names(scene):
            self._app.say(f"This scene has no object called {name}.")
        elif scene is not None:
            points, aspect = corners_m(scene, self._app.editing.frame, name), self._aspect
            self._stand(framed(points, self._app.lens, aspect, self.pose.turn))
            self._app.editing.settle()

    def frame_selected(self) -> None:
        """The chosen object, or without one everything."""
        self.frame(self.selected)

    def object_m(self, name: str, frame: int | None = None) -> float | None:
        """How far an object is, None where there is none such to be seen."""
        try:
            return self._depth_m(name, self._app.editing.frame if frame is None else frame)
        except InputError:
            return None

    def _depth_m(self, name: str, frame: int) -> float:
        """Raises InputError where there is no such object, or it cannot be focused on."""
        scene, pose = self.scene, self._app.renderer.pose_at(self._app.shot, frame)
        if scene is None or pose is None:
            raise InputError(f"No scene is open that could have an object called {name!r}.")
        return object_depth_m(scene, name, pose, frame)

    def focus_on(self, name: str) -> None:
        """On the middle of an object. Raises InputError where that cannot be."""
        depth_m = self._depth_m(name, self._app.editing.frame)
        self._app.edit_lens(replace(self._app.lens, focus_distance_m=depth_m))

    def mark(self, name: str) -> None:
        """A mark that goes where the object goes."""
        shot = self._app.shot
        mark = ObjectMark(next_mark_name(shot.marks), name)
        self._app.editing.do(replace(shot, marks=(*shot.marks, mark)))

    def follow(self, mark: ObjectMark, frames: FrameRange) -> None:
        """Keep the focus on an object from in to out."""
        app, name = self._app, mark.object_name
        try:
            app.editing.do(followed(app.shot, frames, lambda frame: self._depth_m(name, frame)))
            app.say(f"The focus follows {name} from {frames.first} on.")
        except HeatlensError as error:
            app.say(str(error))

    def look_through(self, name: str) -> None:
        """One of the scene's cameras, with its angle of view; the shot's own track goes."""
        scene, app = self.scene, self._app
        if scene is not None:
            framing = replace(self.framing, camera=name, track=None)
            lens = camera_lens(scene, framing, app.shot.lens)
            app.editing.do(replace(app.shot, framing=framing, lens=lens))

    def set_key(self) -> None:
        """The camera stands here at this frame, and elsewhere at others."""
        if self.scene is None:
            return
        app, pose = self._app, self.pose
        frame, track = app.editing.frame, self.framing.track
        framing = (
            self.framing.at(pose, frame)
            if track is None
            else replace(self.framing, track=track.with_key(frame, pose))
        )
        app.editing.do(replace(app.shot, framing=framing))

    def delete_key(self) -> None:
        """The camera's key at this frame goes."""
        app, track = self._app, self.framing.track
        if track is not None:
            without = replace(self.framing, track=track.without_key(app.editing.frame))
            app.editing.do(replace(app.shot, framing=without))

    @property
    def key_frames(self) -> tuple[float, ...]:
        """Where the shot's own camera has keys."""
        track = self.framing.track if self.scene is not None else None
        return () if track is None else tuple(key.frame for key in track.keys)

    @property
    def _aspect(self) -> float:
        return self.framing.width_px / self.framing.height_px

    def _stand(self, pose: Pose) -> None:
        app = self._app
        app.edit(replace(app.shot, framing=self.framing.at(pose, app.editing.frame)))

    def _height_m(self, distance_m: float) -> float:
        """Of what is seen at a distance."""
        lens = self._app.lens
        return distance_m * lens.sensor_width_mm / (lens.focal_length_mm * self._aspect)

    def _pivot_m(self) -> Vector:
        """What is in focus, straight ahead; with the focus far beyond the scene, its middle."""
        scene, pose = self.scene, self.pose
        assert scene is not None
        box = bounds_m(scene, self._app.editing.frame)
        farthest = float(np.linalg.norm(np.abs(box - np.array(pose.position_m)).max(axis=0)))
        return pivot_of(pose, min(self._app.lens.focus_distance_m, farthest))
