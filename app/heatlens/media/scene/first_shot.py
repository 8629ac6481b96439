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
from heatlens.media.scene.placing import Placing, placed_first
from heatlens.media.scene.scene import Scene, SceneCamera
from heatlens.media.scene.scene_bounds import bounds_m, started_framing, subject_m, track_of
from heatlens.media.scene.scene_read import is_demo, open_scene

_ASSUMED = Lens(
    focal_length_mm=SceneCamera.focal_length_mm,
    f_stop=2.0,
    focus_distance_m=5.0,
    sensor_width_mm=SceneCamera.sensor_width_mm,
    model=LensModel.RENDERER,
)
_WIDE_F_STOP = 1.4  # for a large scene, which shows less blur
_NOTHING: Mapping[str, object] = MappingProxyType({})
_UNTOLD = Placing()


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
        return 1 if self.shot.played is None else self.shot.played.first


def first_shot(
    text: str,
    size: tuple[int, int] | None = None,
    camera: str | None = None,
    given: Mapping[str, object] = _NOTHING,
    timing: SceneTiming | None = None,
    placing: Placing = _UNTOLD,
) -> FirstShot:
    """Return the first shot of the scene `text`, in `size` pixels, seen through `camera`.

    `given` holds fields of Lens, which replace any keys at every frame; `timing` converts the
    seconds of a file to frames; `placing` gives the unit and the up axis if the file does not.
    Raises InputError if the scene cannot be read or has no such camera, and LensError if the values
    are impossible.
    """
    scene = open_scene(text, timing)
    scene, framing = placed_first(scene, started_framing(scene), placing)
    begun = _demo(scene, text) if is_demo(text) else _of_file(scene, text, framing)
    if timing is not None:
        framing = replace(begun.shot.framing or Framing(), timing=timing)
        begun = replace(begun, shot=replace(begun.shot, framing=framing))
    if size is not None or camera is not None:
        begun = _framed(begun, size, camera)
    begun = _with_given(begun, given)
    if "focus_distance_m" not in begun.assumed:
        return begun
    lens = replace(begun.shot.lens, focus_distance_m=_middle_m(begun))
    return replace(begun, shot=replace(begun.shot, lens=lens))


def _demo(scene: Scene, text: str) -> FirstShot:
    from heatlens.media.scene.demo import demo_shot  # the demo is read only when it is used

    sources = dict.fromkeys((*ANGLE, *OPENING, "model"), "as the demo is shot")
    return FirstShot(scene, replace(demo_shot(), source=text), sources, frozenset())


def _of_file(scene: Scene, text: str, framing: Framing) -> FirstShot:
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
    begun = FirstShot(scene, shot, sources, frozenset((*ANGLE, *OPENING)))
    return begun if framing.camera is None else _through(begun, framing.camera)


def _through(begun: FirstShot, name: str) -> FirstShot:
    """Return the shot with the lens of the scene's camera `name`, as far as the file has it."""
    camera, shot = begun.scene.camera_named(name), begun.shot
    values = lens_values(camera)
    return replace(
        begun,
        shot=through_camera(shot, camera),
        sources={**begun.sources, **_source_notes(camera, values)},
        assumed=begun.assumed.difference(values),
    )


def _source_notes(camera: SceneCamera, fields: Iterable[str]) -> dict[str, str]:
    """Return the origins of the fields of a camera."""
    sources = dict.fromkeys(fields, f"camera {camera.name} of the scene")
    if camera.is_width_assumed:
        sources["sensor_width_mm"] = f"assumed: camera {camera.name} has only an angle of view"
        sources["focal_length_mm"] = f"camera {camera.name} of the scene, for that sensor"
    return sources


def _framed(begun: FirstShot, size: tuple[int, int] | None, camera: str | None) -> FirstShot:
    framing = begun.shot.framing or Framing()
    if size is not None:
        framing = replace(framing, width_px=size[0], height_px=size[1])
    if camera is None:
        return replace(begun, shot=replace(begun.shot, framing=framing))
    name = begun.scene.camera_named(camera).name
    return _through(replace(begun, shot=replace(begun.shot, framing=framing)), name)


def lens_with(begun: FirstShot, given: Mapping[str, Any]) -> Lens:
    """Return the lens of the shot with the given fields.

    A camera of which only the angle of view is known keeps it on a sensor of another width.
    """
    shot, angle = begun.shot, _angle_alone(begun)
    width_mm = given.get("sensor_width_mm")
    if angle is None or width_mm is None or "focal_length_mm" in given:
        return replace(shot.lens, **given)
    focal_mm = angle.focal_length_mm * width_mm / angle.sensor_width_mm
    return replace(shot.lens, **{**given, "focal_length_mm": focal_mm})


def _angle_alone(begun: FirstShot) -> SceneCamera | None:
    """Return the camera of the shot if its file has an angle of view but no sensor, else None."""
    name = None if begun.shot.framing is None else begun.shot.framing.camera
    camera = None if name is None else begun.scene.camera_named(name)
    return camera if camera is not None and camera.is_width_assumed else None


def _with_given(begun: FirstShot, given: Mapping[str, object]) -> FirstShot:
    shot, lens = begun.shot, lens_with(begun, given)
    for name in set(map(str, LensParameter)).intersection(given):
        curve = shot.curves.of(LensParameter(name))
        shot = shot.with_curve(LensParameter(name), replace(curve, keys=()))
    return replace(
        begun,
        shot=replace(shot, lens=lens),
        sources={**begun.sources, **dict.fromkeys(given, "given")},
        assumed=begun.assumed.difference(given),
    )


def _middle_m(begun: FirstShot) -> float:
    """Return the planar depth of the middle of the scene, at least twice the focal length.

    For a large scene, it is the middle of the object that is in view.
    """
    scene, shot, frame = begun.scene, begun.shot, begun.frame
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
