"""Keep the size of a thing in the picture of a scene while focal length or camera change.

A thing at depth z is as large as focal length / z. So where the focal length becomes k times as
long, the camera goes back along its axis until the thing is at k z, and all that is kept by
distance follows: focus and marks. Over frames this is a dolly zoom: the camera follows a keyed
focal length, or the focal length a moving camera.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.framing import CameraTrack, Framing, Pose, PoseKey, Vector
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import followed, recorded
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.orbit import pivot_of
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import object_depth_m, track_of

DepthAt = Callable[[int, int], float]  # metres at a pixel of the frame whose size is kept

_STILL_M = 1e-9
_OFF_MOST = 0.002  # largest error of the size between keys of the camera


@dataclass(frozen=True)
class KeptSize:
    """A thing of a scene, whose size at a frame is kept.

    shot      before the change
    frame     at which the size is measured
    mark      on the thing
    depth_at  the depth at a pixel at that frame, for marks on points
    """

    scene: Scene
    shot: Shot
    frame: float
    mark: Mark
    depth_at: DepthAt

    def at_length(self, focal_length_mm: float) -> Shot:
        """Return the shot with another focal length, from where the thing is as large as before.

        Keys of the focal length are scaled by the same factor. Raises InputError where something
        that has a distance would come to lie behind the camera, and LensError for such a lens.
        """
        factor = focal_length_mm / self.shot.lens_at(self.frame).focal_length_mm
        lens = replace(self.shot.lens, focal_length_mm=self.shot.lens.focal_length_mm * factor)
        longer = _scaled_keys(replace(self.shot, lens=lens), factor)
        return self._moved(longer, lambda frame: factor * self.depth_m(frame))

    def by_camera(self) -> Shot:
        """Return the shot with a camera that follows the keys of the focal length."""
        size = self._length_mm(self.frame) / self.depth_m(self.frame)
        return self._moved(self.shot, lambda frame: self._length_mm(frame) / size)

    def by_length(self) -> Shot:
        """Return the shot with a focal length that follows the camera and the thing."""
        size = self._length_mm(self.frame) / self.depth_m(self.frame)
        track = {int(at): size * self.depth_m(at) for at in self._frames}
        framing = self.shot.framing
        if framing is not None and not self.scene.cameras:  # a view of all depends on the lens
            framing = replace(framing, track=self._track)
        return recorded(replace(self.shot, framing=framing), LensParameter.FOCAL_LENGTH, track)

    def depth_m(self, frame: float) -> float:
        """Return how far in front of the camera the thing is at a frame of the shot."""
        pose = self._track.pose_at(frame)
        if isinstance(self.mark, ObjectMark):
            return object_depth_m(self.scene, self.mark.object_name, pose, frame)
        depth_m = _ahead_m(pose, self._place_m)
        if depth_m <= 0:
            raise InputError(f"{self.mark.name} is behind the camera at frame {frame:g}.")
        return depth_m

    @cached_property
    def _place_m(self) -> Vector:
        """The place in the world of a mark that stands."""
        far_m = self._distance_m(self.mark)
        if not np.isfinite(far_m):
            raise InputError(f"{self.mark.name} is infinitely far away: its size never changes.")
        return pivot_of(self._track.pose_at(self.frame), far_m)

    def _distance_m(self, mark: Mark) -> float:
        if isinstance(mark, DistanceMark):
            return mark.distance_m
        if isinstance(mark, PointMark):
            return self.depth_at(int(mark.x_px), int(mark.y_px))
        raise InputError(f"{mark.name} is a mark of plates: no scene has what it is on.")

    @cached_property
    def _track(self) -> CameraTrack:
        return track_of(self.scene, self._framing, self.shot.lens_at(self.frame))

    @property
    def _framing(self) -> Framing:
        return self.shot.framing or Framing()

    @property
    def _frames(self) -> Sequence[float]:
        span = self.shot.span
        return [self.frame] if span is None else [float(frame) for frame in span]

    def _length_mm(self, frame: float) -> float:
        return self.shot.lens_at(frame).focal_length_mm

    def _moved(self, shot: Shot, wanted_m: Callable[[float], float]) -> Shot:
        """Return the shot with a camera from which the thing is at `wanted_m`, and what follows."""
        frames, track = self._frames, self._track
        forward = {frame: self.depth_m(frame) - wanted_m(frame) for frame in frames}
        is_still = not track.is_moving and np.ptp(list(forward.values())) < _STILL_M
        if is_still:
            framing = self._framing.at(_forward(track.pose_at(self.frame), forward[frames[0]]), 1)
            by_m = forward[frames[0]]
        else:
            framing = replace(self._framing, track=_along(track, forward, wanted_m))
            by_m = self.depth_m(self.frame) - wanted_m(self.frame)
        marks = tuple(self._mark(mark, by_m, shot) for mark in shot.marks)
        shot = replace(shot, framing=framing, marks=marks)
        return _nearer_focus(shot, by_m) if is_still else self._with_focus(shot, forward)

    def _mark(self, mark: Mark, by_m: float, shot: Shot) -> Mark:
        """Return a mark as it is from where the camera stands after it went forward."""
        if not isinstance(mark, (DistanceMark, PointMark)):
            return mark
        far_m = self._distance_m(mark)
        after_m = _left(far_m, by_m, f"mark {mark.name}")
        if isinstance(mark, DistanceMark):
            return replace(mark, distance_m=after_m)
        larger = shot.lens_at(self.frame).focal_length_mm / self._length_mm(self.frame)
        larger *= far_m / after_m if np.isfinite(far_m) else 1.0
        size, at = np.array(self._framing.size), np.array([mark.x_px, mark.y_px])
        x, y = ((at + 0.5 - size / 2) * larger + size / 2 - 0.5).tolist()
        if not (0 <= x < size[0] and 0 <= y < size[1]):
            return DistanceMark(mark.name, after_m)  # it has left the picture
        return replace(mark, x_px=x, y_px=y)

    def _with_focus(self, shot: Shot, forward: dict[float, float]) -> Shot:
        focus_m = {at: self.shot.lens_at(at).focus_distance_m for at in forward}
        what = "what is in focus"
        after = {int(at): _left(far_m, forward[at], what) for at, far_m in focus_m.items()}
        made = followed(shot, after)
        values = {key.value for key in made.curves.focus_distance_m.keys}
        if shot.curves.focus_distance_m.keys or len(values) > 1:
            return made
        return replace(shot, lens=replace(shot.lens, focus_distance_m=values.pop()))  # it stands


def _left(distance_m: float, by_m: float, what: str) -> float:
    """Return a distance after the camera went forward. Raises InputError where none is left."""
    if distance_m - by_m <= 0:
        raise InputError(
            f"The camera would go {format_distance(by_m)} forward, past {what} at "
            f"{format_distance(distance_m)}."
        )
    return distance_m - by_m


def _scaled_keys(shot: Shot, factor: float) -> Shot:
    curve = shot.curves.focal_length_mm
    keys = tuple(replace(key, value=key.value * factor) for key in curve.keys)
    return shot.with_curve(LensParameter.FOCAL_LENGTH, replace(curve, keys=keys))


def _nearer_focus(shot: Shot, by_m: float) -> Shot:
    """Return the shot whose focus is by so much nearer at every frame."""
    what, curve = "what is in focus", shot.curves.focus_distance_m
    keys = tuple(replace(key, value=_left(key.value, by_m, what)) for key in curve.keys)
    shot = shot.with_curve(LensParameter.FOCUS_DISTANCE, replace(curve, keys=keys))
    if not keys:
        after_m = _left(shot.lens.focus_distance_m, by_m, what)
        shot = replace(shot, lens=replace(shot.lens, focus_distance_m=after_m))
    for frame in shot.key_frames:
        shot.lens_at(frame)
    return shot


def _ahead_m(pose: Pose, place_m: Vector) -> float:
    return float(np.subtract(pose.position_m, place_m) @ pose.turn[:, 2])


def _forward(pose: Pose, by_m: float) -> Pose:
    x, y, z = np.asarray(pivot_of(pose, by_m)).tolist()
    return replace(pose, position_m=(x, y, z))


# Between keys the camera moves on its own curve and not on the dolly's. Keys are added where the
# size is off most until none is off by more than 0.2 %: few enough for a person to edit.
def _along(
    track: CameraTrack, forward: dict[float, float], wanted_m: Callable[[float], float]
) -> CameraTrack:
    """Return the track moved along its axis at all frames, with as few keys as the size allows."""
    poses = {frame: _forward(track.pose_at(frame), by_m) for frame, by_m in forward.items()}
    keyed = {*(key.frame for key in track.keys if key.frame in poses), min(poses), max(poses)}
    while True:
        made = CameraTrack(tuple(PoseKey(frame, poses[frame]) for frame in sorted(keyed)))
        off = {
            frame: float(
                np.linalg.norm(np.subtract(made.pose_at(frame).position_m, pose.position_m))
            )
            / wanted_m(frame)
            for frame, pose in poses.items()
        }
        worst = max(off, key=lambda frame: off[frame])
        if off[worst] <= _OFF_MOST or worst in keyed:
            return made
        keyed.add(worst)


def crop_words(shot: Shot, frame: float, focal_length_mm: float) -> str:
    """Return why a plate cannot be seen from elsewhere, and what another length shows of it."""
    factor = shot.lens_at(frame).focal_length_mm / focal_length_mm
    shown = (
        f"shows the middle {100 * factor:.3g} % of its width and height, everything "
        f"{1 / factor:.3g} times as large"
        if factor <= 1
        else f"would show {factor:.3g} times its width, which it does not have"
    )
    return (
        "A plate is seen from one place, so no camera can move to keep a size: "
        f"{focal_length_mm:g} mm {shown}."
    )
