"""The scene that comes with the program: three people in a street at nightfall, made by code.

Everything a lens can show is in it: something close to the camera, people who cross at three
distances, and hundreds of small lights behind them.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from heatlens.model.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.model.framing import CameraTrack, Framing, PoseKey, looking_at
from heatlens.model.lens import Lens
from heatlens.model.lens_model import LensModel
from heatlens.model.marks import DistanceMark
from heatlens.model.pull import pull
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.scene.demo.actors import LOOP_FRAMES, Clothes, Walk, dress, joints_at
from heatlens.scene.demo.cafe import build_cafe
from heatlens.scene.demo.street import build_street
from heatlens.scene.demo.street_set import DemoSet
from heatlens.scene.demo.wet_ground import add_puddles
from heatlens.scene.scene import Array, Daylight, Motion, Scene, SceneCamera

DEMO_SOURCE = "demo"
_CAMERA = "dolly"
_FRAMES = FrameRange(1, LOOP_FRAMES)
_SKIN = (0.55, 0.34, 0.24)
# The actors to whose distance each mark belongs; it stays while the focus is there.
ACTORS = {
    "actor A": Walk((0.5, -3.47), (0.62, 0.2), 30, -1, 4),
    "actor B": Walk((-0.75, -5.85), (1.25, 0.25), 117, 1, 6),
    "actor C": Walk((1.2, -10.3), (2.2, 0.42), 220, 1, 8),
}
_CLOTHES = (
    Clothes((0.42, 0.045, 0.035), (0.05, 0.06, 0.1), (0.7, 0.6, 0.42), (0.62, 0.5, 0.3), _SKIN),
    Clothes(
        (0.03, 0.2, 0.22), (0.07, 0.06, 0.05), (0.6, 0.2, 0.08), (0.05, 0.04, 0.04), _SKIN, True
    ),
    Clothes((0.55, 0.36, 0.07), (0.04, 0.05, 0.09), (0.08, 0.16, 0.32), (0.3, 0.04, 0.06), _SKIN),
)
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
    stage = DemoSet()
    build_street(stage)
    puddles = add_puddles(stage)
    build_cafe(stage)
    still = len(stage.instances)
    joints = [
        (name, joint)
        for name, clothes in zip(ACTORS, _CLOTHES, strict=True)
        for joint in dress(stage, name, clothes)
    ]
    motion = _motion(np.stack([i.to_world for i in stage.instances[:still]]), joints)
    first = motion(_FRAMES.first)
    return Scene(
        path=Path(DEMO_SOURCE),
        meshes=tuple(stage.meshes),
        instances=tuple(
            replace(instance, to_world=matrix)
            for instance, matrix in zip(stage.instances, first, strict=True)
        ),
        materials=tuple(stage.materials),
        images=(puddles,),
        cameras=(SceneCamera(_CAMERA, _dolly(), 50.0, 36.0),),
        lights=tuple(stage.lights),
        daylight=_NIGHTFALL,
        motion=motion,
        frames=_FRAMES,
        frames_per_second=FRAMES_PER_SECOND,
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
    for (start, frames), mark, after in zip(_PULLS, _MARKS, _MARKS[1:], strict=False):
        shot = pull(shot, mark.distance_m, after.distance_m, start, frames)
    return shot


def _motion(still: Array, joints: list[tuple[str, str]]) -> Motion:
    """Return the motion of all instances: those that stand still, then those of the actors."""

    def places(frame: float) -> Array:
        poses = {name: joints_at(walk, frame) for name, walk in ACTORS.items()}
        return np.concatenate([still, [poses[name][joint] for name, joint in joints]])

    return places


def _dolly() -> CameraTrack:
    """Return a camera that moves slowly right, past the railing, and looks down the street."""
    keys = (
        (1, (-0.22, 1.06, 0.0), (0.02, 1.32, -6.0)),
        (120, (0.02, 1.09, -0.05), (-0.02, 1.29, -6.0)),
        (240, (0.2, 1.13, 0.0), (-0.04, 1.25, -6.0)),
    )
    return CameraTrack(tuple(PoseKey(frame, looking_at(eye, at)) for frame, eye, at in keys))
