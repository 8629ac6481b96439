"""Keep the size of a thing in the picture of a scene while focal length or camera change.

The size of a thing at depth z is proportional to focal length / z. If the focal length becomes k
times as long, the camera moves back along its axis until the thing is at depth k z, and the focus
distance and the marks change with it. Over frames this is a dolly zoom: the camera follows a keyed
focal length, or the focal length follows a moving camera.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey, Vector
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import apply_recorded_parameter, focus_on_distances
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.orbit import pivot_of
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import object_depth_m, track_of

DepthAt = Callable[[int, int], float]  # meters at a pixel of the frame whose size is kept

_STILL_M = 1e-9  # the camera moves equally at all frames if the difference is smaller
_POSSIBLE_FOCUS_LENGTHS = 2.0  # a focus this many focal lengths away is always possible
_SIZE_ERROR_MOST = 0.002  # largest error of the size between keys of the camera


@dataclass(frozen=True)
class KeptSize:
    """A thing of a scene whose size in the picture is kept.

    shot      the shot before the change
    frame     frame at which the size is measured
    mark      mark on the thing
    depth_at  function from a pixel to its depth at that frame, for marks on points
    """

    scene: Scene
    shot: Shot
    frame: float
    mark: Mark
    depth_at: DepthAt

    def with_focal_length(self, focal_length_mm: float) -> Shot:
        """Return the shot with another focal length and a camera that keeps the thing's size.

        Keys of the focal length are scaled by the same factor. Raises InputError if a mark or the
        focus would come to lie behind the camera, and LensError for an impossible lens.
        """
        factor = focal_length_mm / self.shot.lens_at(self.frame).focal_length_mm
        lens = self.shot.lens
        base_length_mm = lens.focal_length_mm * factor
        # The focus moves with the camera in the end; until then the lens only has to be possible.
        far_m = max(lens.focus_distance_m, _POSSIBLE_FOCUS_LENGTHS * base_length_mm / 1e3)
        lens = replace(lens, focal_length_mm=base_length_mm, focus_distance_m=far_m)
        scaled_shot = _scale_keys(replace(self.shot, lens=lens), factor)
        return self._move_camera(scaled_shot, lambda frame: factor * self.depth_m(frame))

    def follow_with_camera(self) -> Shot:
        """Return the shot with a camera that follows the keys of the focal length."""
        length_per_m = self._focal_length_mm(self.frame) / self.depth_m(self.frame)
        return self._move_camera(
            self.shot, lambda frame: self._focal_length_mm(frame) / length_per_m
        )

    def follow_with_focal_length(self) -> Shot:
        """Return the shot with a focal length that follows the camera and the thing."""
        length_per_m = self._focal_length_mm(self.frame) / self.depth_m(self.frame)
        focal_lengths_mm = {
            int(frame): length_per_m * self.depth_m(frame) for frame in self._frames
        }
        framing = self.shot.framing
        if framing is not None and not self.scene.cameras:  # a view of all depends on the lens
            framing = replace(framing, track=self._track)
        return apply_recorded_parameter(
            replace(self.shot, framing=framing), LensParameter.FOCAL_LENGTH, focal_lengths_mm
        )

    def depth_m(self, frame: float) -> float:
        """Return how far in front of the camera the thing is at a frame of the shot."""
        pose = self._track.pose_at(frame)
        if isinstance(self.mark, ObjectMark):
            return object_depth_m(self.scene, self.mark.object_name, pose, frame)
        depth_m = _depth_ahead_m(pose, self._world_position_m)
        if depth_m <= 0:
            raise InputError(f"{self.mark.name} is behind the camera at frame {frame:g}.")
        return depth_m

    @cached_property
    def _world_position_m(self) -> Vector:
        """The position in the world of a mark that does not move. Raises InputError."""
        far_m = self._distance_m(self.mark)
        if not np.isfinite(far_m):
            raise InputError(
                f"Mark {self.mark.name} is infinitely far away, so no camera can keep its size: "
                "choose another mark."
            )
        return pivot_of(self._track.pose_at(self.frame), far_m)

    def _distance_m(self, mark: Mark) -> float:
        """Return the distance of a mark at `frame`; raise InputError for a mark of plates."""
        if isinstance(mark, DistanceMark):
            return mark.distance_m
        if isinstance(mark, PointMark):
            return self.depth_at(int(mark.x_px), int(mark.y_px))
        raise InputError(
            f"Mark {mark.name} is on something in a plate, which no scene has: set a mark on an "
            "object of the scene."
        )

    @cached_property
    def _track(self) -> CameraTrack:
        return track_of(self.scene, self._framing, self.shot.lens_at(self.frame))

    @property
    def _framing(self) -> Framing:
        return self.shot.framing or Framing()

    @property
    def _frames(self) -> Sequence[float]:
        """Return the frames of the span; without one, that at which the size is measured."""
        span = self.shot.span
        return [self.frame] if span is None else [float(frame) for frame in span]

    def _focal_length_mm(self, frame: float) -> float:
        return self.shot.lens_at(frame).focal_length_mm

    def _move_camera(self, shot: Shot, target_depth_m: Callable[[float], float]) -> Shot:
        """Return the shot with a camera for which the thing has the depth `target_depth_m`.

        The marks and the focus are adjusted to the new camera.
        """
        frames, track = self._frames, self._track
        forward_m = {frame: self.depth_m(frame) - target_depth_m(frame) for frame in frames}
        is_still = not track.is_moving and np.ptp(list(forward_m.values())) < _STILL_M
        if is_still:
            framing = self._framing.with_pose(
                _move_forward(track.pose_at(self.frame), forward_m[frames[0]]), 1
            )
            step_m = forward_m[frames[0]]
        else:
            framing = replace(
                self._framing, track=_move_along_axis(track, forward_m, target_depth_m)
            )
            step_m = self.depth_m(self.frame) - target_depth_m(self.frame)
        marks = tuple(self._move_mark(mark, step_m, shot) for mark in shot.marks)
        shot = replace(shot, framing=framing, marks=marks)
        return (
            _bring_focus_nearer(shot, step_m, self.shot.lens.focus_distance_m)
            if is_still
            else self._follow_focus(shot, forward_m)
        )

    def _move_mark(self, mark: Mark, step_m: float, shot: Shot) -> Mark:
        """Return a mark as the camera sees it after moving forward by `step_m`."""
        if not isinstance(mark, (DistanceMark, PointMark)):
            return mark
        far_m = self._distance_m(mark)
        remaining_m = _remaining_m(far_m, step_m, f"mark {mark.name}")
        if isinstance(mark, DistanceMark):
            return replace(mark, distance_m=remaining_m)
        scale = shot.lens_at(self.frame).focal_length_mm / self._focal_length_mm(self.frame)
        scale *= far_m / remaining_m if np.isfinite(far_m) else 1.0
        size, point_px = np.array(self._framing.size), np.array([mark.x_px, mark.y_px])
        x, y = ((point_px + 0.5 - size / 2) * scale + size / 2 - 0.5).tolist()
        if not (0 <= x < size[0] and 0 <= y < size[1]):
            return DistanceMark(mark.name, remaining_m)  # it has left the picture
        return replace(mark, x_px=x, y_px=y)

    def _follow_focus(self, shot: Shot, forward_m: dict[float, float]) -> Shot:
        """Return the shot with the focus on the same depths of the scene at every frame.

        `forward_m` holds how far the camera moves forward, by frame.
        """
        focus_m = {frame: self.shot.lens_at(frame).focus_distance_m for frame in forward_m}
        label = "what is in focus"
        remaining_m = {
            int(frame): _remaining_m(far_m, forward_m[frame], label)
            for frame, far_m in focus_m.items()
        }
        followed_shot = focus_on_distances(shot, remaining_m)
        values = {key.value for key in followed_shot.curves.focus_distance_m.keys}
        if shot.curves.focus_distance_m.keys or len(values) > 1:
            return followed_shot
        return replace(shot, lens=replace(shot.lens, focus_distance_m=values.pop()))  # it stands


def _remaining_m(distance_m: float, step_m: float, label: str) -> float:
    """Return a distance after the camera moved forward by `step_m`.

    Raises InputError if it is not above 0.
    """
    if distance_m - step_m <= 0:
        raise InputError(
            f"The camera would go {format_distance(step_m)} forward, past {label} at "
            f"{format_distance(distance_m)}: choose a longer focal length."
        )
    return distance_m - step_m


def _scale_keys(shot: Shot, factor: float) -> Shot:
    """Return the shot with all keys of the focal length multiplied by a factor."""
    curve = shot.curves.focal_length_mm
    keys = tuple(replace(key, value=key.value * factor) for key in curve.keys)
    return shot.with_curve(LensParameter.FOCAL_LENGTH, replace(curve, keys=keys))


def _bring_focus_nearer(shot: Shot, step_m: float, focus_m: float) -> Shot:
    """Return the shot with the focus nearer by `step_m` at every frame.

    `focus_m` is the focus distance of a shot without keys of the focus.
    """
    label, curve = "what is in focus", shot.curves.focus_distance_m
    keys = tuple(replace(key, value=_remaining_m(key.value, step_m, label)) for key in curve.keys)
    shot = shot.with_curve(LensParameter.FOCUS_DISTANCE, replace(curve, keys=keys))
    if not keys:
        remaining_m = _remaining_m(focus_m, step_m, label)
        shot = replace(shot, lens=replace(shot.lens, focus_distance_m=remaining_m))
    # Raises LensError for a key that is not possible.
    for frame in shot.key_frames:
        shot.lens_at(frame)
    return shot


def _depth_ahead_m(pose: Pose, position_m: Vector) -> float:
    """Return the planar depth of a position in the world in front of a camera."""
    return float(np.subtract(pose.position_m, position_m) @ pose.turn[:, 2])


def _move_forward(pose: Pose, step_m: float) -> Pose:
    """Return the pose moved forward along its view axis by `step_m`."""
    x, y, z = np.asarray(pivot_of(pose, step_m)).tolist()
    return replace(pose, position_m=(x, y, z))


# Between keys the camera moves on the curve of its keys, not on that of the dolly. Keys are added
# where the error of the size is largest, until it is at most 0.2 % everywhere: this gives few
# enough keys for a person to edit.
def _move_along_axis(
    track: CameraTrack, forward_m: dict[float, float], target_depth_m: Callable[[float], float]
) -> CameraTrack:
    """Return the track moved along its axis at all frames, with as few keys as the size allows."""
    poses = {
        frame: _move_forward(track.pose_at(frame), step_m) for frame, step_m in forward_m.items()
    }
    key_frames = {*(key.frame for key in track.keys if key.frame in poses), min(poses), max(poses)}
    while True:
        moved_track = CameraTrack(
            tuple(PoseKey(frame, poses[frame]) for frame in sorted(key_frames))
        )
        errors = {
            frame: float(
                np.linalg.norm(np.subtract(moved_track.pose_at(frame).position_m, pose.position_m))
            )
            / target_depth_m(frame)
            for frame, pose in poses.items()
        }
        worst_frame = max(errors, key=lambda frame: errors[frame])
        if errors[worst_frame] <= _SIZE_ERROR_MOST or worst_frame in key_frames:
            return moved_track
        key_frames.add(worst_frame)


def crop_words(shot: Shot, frame: float, focal_length_mm: float) -> str:
    """Return a sentence on why a plate cannot keep a size, and on the crop of a focal length."""
    factor = shot.lens_at(frame).focal_length_mm / focal_length_mm
    effect_words = (
        f"shows the middle {100 * factor:.3g} % of its width and height, everything "
        f"{1 / factor:.3g} times as large"
        if factor <= 1
        else f"would show {factor:.3g} times its width, which it does not have"
    )
    return (
        "A plate is seen from one place, so no camera can move to keep a size: "
        f"{focal_length_mm:g} mm {effect_words}."
    )
