"""A scene that has been opened: what a shot of it begins with."""

from dataclasses import dataclass, replace

from heatlens.model.framing import Framing
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.scene.scene import Scene
from heatlens.scene.scene_bounds import bounds_m, camera_lens, started_framing, track_of
from heatlens.scene.scene_source import is_demo, open_scene

_LENS = Lens(35.0, 2.0, 5.0, 36.0)


@dataclass(frozen=True, eq=False)
class OpenedScene:
    """A scene as it was asked for, and the shot that looks at it first."""

    text: str
    scene: Scene
    shot: Shot

    @property
    def frame(self) -> int:
        """The first one."""
        frames = self.shot.played
        return 1 if frames is None else frames.first


def opened_scene(text: str) -> OpenedScene:
    """Read it. Raises InputError naming the file where that fails."""
    scene = open_scene(text)
    if is_demo(text):
        from heatlens.scene.demo.demo import demo_shot

        return OpenedScene(text, scene, replace(demo_shot(), source=text))
    framing = started_framing(scene)
    shot = Shot(
        _started_lens(scene, framing),
        source=text,
        frames=scene.frames,
        frames_per_second=scene.frames_per_second,
        framing=framing,
    )
    return OpenedScene(text, scene, shot)


def _started_lens(scene: Scene, framing: Framing) -> Lens:
    """The camera's angle, focused on the middle of the scene."""
    lens = camera_lens(scene, framing, _LENS)
    frame = scene.frames.first if scene.frames else 1
    pose = track_of(scene, framing, lens).pose_at(frame)
    middle = bounds_m(scene, frame).mean(axis=0)
    row = pose.world_to_camera[2]
    depth_m = -float(row[:3] @ middle + row[3])
    nearest_m = 2e-3 * lens.focal_length_mm
    return replace(lens, focus_distance_m=max(depth_m, nearest_m))
