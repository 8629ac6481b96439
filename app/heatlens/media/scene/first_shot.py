"""Make the first shot of a scene, for the window and for every command that takes a scene.

Given values take precedence, then those of the scene's camera, with keys for values that change.
Few files contain the f-stop and the focus of a camera, so these are assumed if they are not given,
and marked as assumed. The demo scene comes with a complete, animated lens.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from heatlens.core.model.curves.key_reduction import linear_keys
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.option import Values
from heatlens.core.model.shot.framing import Framing, SceneTiming
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.placing import Placing, place_for_first_shot
from heatlens.media.scene.scene import Scene, SceneCamera
from heatlens.media.scene.scene_bounds import bounds_m, first_framing, subject_m, track_of
from heatlens.media.scene.scene_read import is_demo, open_scene

# The lens for a scene file that has none; see `_file_shot`.
_ASSUMED = Lens(
    focal_length_mm=SceneCamera.focal_length_mm,
    f_stop=2.0,
    focus_distance_m=5.0,
    sensor_width_mm=SceneCamera.sensor_width_mm,
    model=LensModel.RENDERER,
)
_WIDE_F_STOP = 1.4  # for a large scene, which shows less blur
_NO_FIELDS: Mapping[str, object] = MappingProxyType({})
_FILE_PLACING = Placing()


@dataclass(frozen=True, eq=False)
class FirstShot:
    """A scene and the shot that shows it first.

    sources  the origin of the value, by field of Lens, for the fields that are always reported
    assumed  the fields whose values had to be assumed
    """

    scene: Scene
    shot: Shot
    sources: Mapping[str, str]
    assumed: frozenset[str]

    @property
    def frame(self) -> int:
        """The first frame; 1 if nothing moves."""
        return 1 if self.shot.played_frames is None else self.shot.played_frames.first


def first_shot(
    text: str,
    size: tuple[int, int] | None = None,
    camera: str | None = None,
    given_fields: Mapping[str, object] = _NO_FIELDS,
    timing: SceneTiming | None = None,
    placing: Placing = _FILE_PLACING,
) -> FirstShot:
    """Return the first shot of the scene `text`, in `size` pixels, seen through `camera`.

    `given_fields` are fields of Lens by name, which replace any keys; `timing` converts the
    seconds of a file to frames; `placing` gives the unit and the up axis if the file does not.
    Raises InputError if the scene cannot be read or has no such camera, and LensError if the values
    are impossible.
    """
    scene = open_scene(text, timing)
    scene, framing = place_for_first_shot(scene, first_framing(scene), placing)
    first = _demo_shot(scene, text) if is_demo(text) else _file_shot(scene, text, framing)
    if timing is not None:
        framing = replace(first.shot.framing or Framing(), timing=timing)
        first = replace(first, shot=replace(first.shot, framing=framing))
    if size is not None or camera is not None:
        first = _apply_framing(first, size, camera)
    first = _apply_given_fields(first, given_fields)
    if "focus_distance_m" not in first.assumed:
        return first
    lens = replace(first.shot.lens, focus_distance_m=_middle_depth_m(first))
    return replace(first, shot=replace(first.shot, lens=lens))


def _demo_shot(scene: Scene, text: str) -> FirstShot:
    """Return the first shot of the demo scene, which has a complete lens."""
    from heatlens.media.scene.demo import demo_shot  # the demo is read only when it is used

    sources = dict.fromkeys((*ANGLE, *OPENING, "model"), "as the demo is shot")
    return FirstShot(scene, replace(demo_shot(), source=text), sources, frozenset())


def _file_shot(scene: Scene, text: str, framing: Framing) -> FirstShot:
    """Return the first shot of a scene file, with assumed values where the file has none."""
    is_large = not scene.cameras and subject_m(scene) is not None
    shot = Shot(
        replace(_ASSUMED, f_stop=_WIDE_F_STOP) if is_large else _ASSUMED,
        source=text,
        frames=scene.frames,
        frames_per_second=scene.frames_per_second,
        framing=framing,
    )
    sources = {
        **dict.fromkeys(ANGLE, "assumed: the scene has no camera"),
        "f_stop": "assumed: the scene has none",
        "focus_distance_m": "assumed: the middle of the scene",
        "model": "as for every 3D scene",
    }
    first = FirstShot(scene, shot, sources, frozenset((*ANGLE, *OPENING)))
    return first if framing.camera is None else _apply_camera(first, framing.camera)


def _apply_camera(first: FirstShot, name: str) -> FirstShot:
    """Return the shot seen through the scene's camera `name`, with the lens values of the file."""
    camera, shot = first.scene.camera_named(name), first.shot
    values = lens_values(camera)
    return replace(
        first,
        shot=through_camera(shot, camera),
        sources={**first.sources, **_source_notes(camera, values)},
        assumed=first.assumed.difference(values),
    )


def _source_notes(camera: SceneCamera, fields: Iterable[str]) -> dict[str, str]:
    """Return the origins of the fields of a camera."""
    sources = dict.fromkeys(fields, f"camera {camera.name} of the scene")
    if camera.is_width_assumed:
        sources["sensor_width_mm"] = f"assumed: camera {camera.name} has only an angle of view"
        sources["focal_length_mm"] = f"camera {camera.name} of the scene, for that sensor"
    return sources


def _apply_framing(first: FirstShot, size: tuple[int, int] | None, camera: str | None) -> FirstShot:
    """Return the shot with this size in pixels and through this camera, where they are given."""
    framing = first.shot.framing or Framing()
    if size is not None:
        framing = replace(framing, width_px=size[0], height_px=size[1])
    if camera is None:
        return replace(first, shot=replace(first.shot, framing=framing))
    name = first.scene.camera_named(camera).name
    return _apply_camera(replace(first, shot=replace(first.shot, framing=framing)), name)


def lens_with_fields(first: FirstShot, given_fields: Mapping[str, Any]) -> Lens:
    """Return the lens of the shot with the given fields of Lens.

    A camera of which only the angle of view is known keeps it on a sensor of another width.
    """
    shot, angle_camera = first.shot, _camera_with_angle_only(first)
    width_mm = given_fields.get("sensor_width_mm")
    if angle_camera is None or width_mm is None or "focal_length_mm" in given_fields:
        return replace(shot.lens, **given_fields)
    focal_mm = angle_camera.focal_length_mm * width_mm / angle_camera.sensor_width_mm
    return replace(shot.lens, **{**given_fields, "focal_length_mm": focal_mm})


def _camera_with_angle_only(first: FirstShot) -> SceneCamera | None:
    """Return the camera of the shot if its file has an angle of view but no sensor; else None."""
    name = None if first.shot.framing is None else first.shot.framing.camera
    camera = None if name is None else first.scene.camera_named(name)
    return camera if camera is not None and camera.is_width_assumed else None


def _apply_given_fields(first: FirstShot, given_fields: Mapping[str, object]) -> FirstShot:
    """Return the shot with the given fields of Lens, whose keys are removed."""
    shot, lens = first.shot, lens_with_fields(first, given_fields)
    for name in set(map(str, LensParameter)).intersection(given_fields):
        curve = shot.curves.of(LensParameter(name))
        shot = shot.with_curve(LensParameter(name), replace(curve, keys=()))
    return replace(
        first,
        shot=replace(shot, lens=lens),
        sources={**first.sources, **dict.fromkeys(given_fields, "given")},
        assumed=first.assumed.difference(given_fields),
    )


def _middle_depth_m(first: FirstShot) -> float:
    """Return the planar depth of the middle of the scene, at least twice the focal length.

    For a large scene, it is the middle of the object that is in view.
    """
    scene, shot, frame = first.scene, first.shot, first.frame
    subject = None if scene.cameras else subject_m(scene)
    pose = track_of(scene, shot.framing or Framing(), shot.lens).pose_at(frame)
    middle = bounds_m(scene, frame).mean(axis=0) if subject is None else subject.mean(axis=0)
    row = pose.world_to_camera[2]
    depth_m = -float(row[:3] @ middle + row[3])
    return max(depth_m, 2e-3 * shot.lens.focal_length_mm)


ANGLE = ("focal_length_mm", "sensor_width_mm")
OPENING = ("f_stop", "focus_distance_m")


def through_camera(shot: Shot, camera: SceneCamera) -> Shot:
    """Return the shot with the position, motion, lens and keys of a camera.

    Keys are replaced for values that the file has. A camera of which only the angle of view is
    known keeps it on the sensor of the shot.
    """
    framing = replace(shot.framing or Framing(), camera=camera.name, track=None)
    values, tracks = lens_values(camera), dict(camera.lens_tracks)
    if camera.is_width_assumed:
        scale = shot.lens.sensor_width_mm / camera.sensor_width_mm
        values["sensor_width_mm"] = shot.lens.sensor_width_mm
        values["focal_length_mm"] = camera.focal_length_mm * scale
        if "focal_length_mm" in tracks:
            tracks["focal_length_mm"] = tuple(mm * scale for mm in tracks["focal_length_mm"])
    shot = replace(shot, framing=framing, lens=replace(shot.lens, **values))
    for parameter in set(LensParameter).intersection(values):
        curve, track = shot.curves.of(parameter), tracks.get(parameter)
        keys = linear_keys(camera.lens_frames, track, curve.scale) if track else ()
        shot = shot.with_curve(parameter, replace(curve, keys=keys))
    return shot


def lens_values(camera: SceneCamera) -> Values:
    """Return the fields of Lens that the file has for a camera, at its first frame."""
    values = {field: getattr(camera, field) for field in (*ANGLE, *OPENING)}
    return {field: value for field, value in values.items() if value is not None}
