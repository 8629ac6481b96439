"""The scene that comes with the program: three people in a street at nightfall.

It shows the main effects of a lens: an object close to the camera, people who cross at three
distances, and hundreds of small lights behind them. The street is a glTF file, which
assets/demo_street makes. This module adds what glTF cannot hold: the sky, the loop, the camera and
the shot.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

from heatlens.core.base.paths import data_dir
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.pull import pull
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.gltf.read import read_gltf
from heatlens.media.scene.scene import Array, Daylight, Scene, SceneCamera

DEMO_SOURCE = "demo"
_CAMERA = "dolly"
_FRAMES = FrameRange(1, 240)
# Each mark has the distance of one actor, which hardly changes while the focus is there.
_MARKS = (DistanceMark("A", 3.3), DistanceMark("B", 5.63), DistanceMark("C", 9.96))
# Start and length of the pulls from mark to mark, in frames.
_PULLS = ((60, 28), (150, 34))
_NIGHTFALL = Daylight(
    to_sun=(-0.45, 0.55, -0.7),
    sun=(0.16, 0.22, 0.38),
    zenith=(0.012, 0.03, 0.10),
    horizon=(0.16, 0.11, 0.15),
    ground=(0.03, 0.022, 0.035),
)


@cache
def demo_scene() -> Scene:
    """Return the scene, which moves over frames 1 to 240 and then starts again."""
    street = read_gltf(data_dir("assets") / "demo.glb")
    transforms_once = street.transforms_at

    def transforms_in_loop(frame: float) -> Array:
        return transforms_once(_FRAMES.first + (frame - _FRAMES.first) % _FRAMES.count)

    return replace(
        street,
        path=Path(DEMO_SOURCE),
        cameras=(SceneCamera(_CAMERA, _dolly(), 50.0, 36.0),),
        daylight=_NIGHTFALL,
        motion=transforms_in_loop,
        frames=_FRAMES,
        frames_per_second=FRAMES_PER_SECOND,
        clips=(),
    )


def demo_shot() -> Shot:
    """Return a shot whose focus goes from the nearest person to the farthest in two pulls."""
    near = _MARKS[0].distance_m
    shot = Shot(
        lens=Lens(50.0, 2.0, near, 36.0, close_focus_m=0.45, model=LensModel.RENDERER),
        defocus=DefocusSettings(),
        source=DEMO_SOURCE,
        marks=_MARKS,
        frames=_FRAMES,
        frames_per_second=FRAMES_PER_SECOND,
        framing=Framing(1280, 720, camera=_CAMERA),
    )
    for (start, frames), mark, next_mark in zip(_PULLS, _MARKS, _MARKS[1:], strict=False):
        shot = pull(shot, mark.distance_m, next_mark.distance_m, start, frames)
    return shot


def _dolly() -> CameraTrack:
    """Return a camera that moves slowly to the right past the railing and looks down the street."""
    keys = (
        (1, (-0.22, 1.06, 0.0), (0.02, 1.32, -6.0)),
        (120, (0.02, 1.09, -0.05), (-0.02, 1.29, -6.0)),
        (240, (0.2, 1.13, 0.0), (-0.04, 1.25, -6.0)),
    )
    return CameraTrack(tuple(PoseKey(frame, pose_looking_at(eye, at)) for frame, eye, at in keys))
