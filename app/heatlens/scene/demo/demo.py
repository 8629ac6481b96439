"""The scene that comes with the program: three people in a street at nightfall, made by code.

Everything a lens can show is in it: something close to the camera, people who cross at three
distances, and hundreds of small lights behind them.

Puddles are holes in the wet ground, and a mirrored street hangs below it. A mirror image is
therefore as far away as its light has travelled, and a lens blurs it accordingly.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

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
from heatlens.scene.demo.shapes import quads, scaled
from heatlens.scene.demo.street import build_street
from heatlens.scene.demo.street_set import DemoSet
from heatlens.scene.scene import Array, Daylight, Material, Motion, Scene, SceneCamera

DEMO_SOURCE = "demo"
_CAMERA = "dolly"
_FRAMES = FrameRange(1, LOOP_FRAMES)
_SKIN = (0.55, 0.34, 0.24)
# Each mark has the distance of one actor, which hardly changes while the focus is there.
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
_TILE_M = 9.0  # period of the puddles
_TILE_PX = 256
_REFLECTED = 0.3  # share of the light that water reflects at so flat an angle
_MIRRORED = ("houses", "windows", "street lamps", "garlands", "signs", "shops", "cars")


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


def add_puddles(stage: DemoSet) -> npt.NDArray[np.uint8]:
    """Add the ground and the mirror images in its puddles; return the map of the ground.

    The map is the first image of the scene, (H, W, 4), with holes where alpha is under one half.
    """
    for name in _MIRRORED:
        _mirror(stage, name)
    wet = Material(
        "asphalt", (0.032, 0.034, 0.04), roughness=0.26, alpha_cutoff=0.5, base_color_map=0
    )
    corners = np.array([(-30, 0, 6), (30, 0, 6), (30, 0, -75), (-30, 0, -75)], np.float64)
    ground = replace(quads([corners]), uvs=(corners[:, [0, 2]] / _TILE_M).astype(np.float32))
    stage.put("ground", stage.mesh(ground, stage.material(wet)), np.eye(4))
    return _puddle_map(np.random.default_rng(11))


def _mirror(stage: DemoSet, name: str) -> None:
    """Add each instance of that name once more, upside down and darker."""
    darker: dict[int, int] = {}
    for instance in [one for one in stage.instances if one.name == name]:
        if instance.mesh not in darker:
            mesh = stage.meshes[instance.mesh]
            material = stage.material(_reflected(stage.materials[mesh.material]))
            darker[instance.mesh] = stage.mesh(mesh, material)
        flipped = scaled(1, -1, 1) @ instance.to_world
        stage.put("reflections", darker[instance.mesh], flipped)


def _reflected(material: Material) -> Material:
    base, emission = (
        tuple(_REFLECTED * value for value in color)
        for color in (material.base_color, material.emission)
    )
    return replace(
        material,
        base_color=(base[0], base[1], base[2]),
        emission=(emission[0], emission[1], emission[2]),
    )


def _puddle_map(rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return a map of waves that repeat on a tile; the lowest parts are under water."""
    at = 2 * np.pi * np.arange(_TILE_PX) / _TILE_PX
    height = np.zeros((_TILE_PX, _TILE_PX))
    for _ in range(24):
        across, along = rng.integers(-4, 5, 2)
        share = rng.normal() / (1.0 + across**2 + along**2) ** 0.5
        height += share * np.cos(across * at + along * at[:, None] + rng.uniform(0, 2 * np.pi))
    height = (height - np.quantile(height, 0.34)) / height.std()
    pixels = np.full((_TILE_PX, _TILE_PX, 4), 255, np.uint8)
    pixels[..., 3] = np.clip(127.5 + 127.5 * height / 0.4, 0, 255).astype(np.uint8)
    return pixels
