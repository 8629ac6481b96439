"""Cameras and lights of a glTF file.

Sources: Khronos, glTF 2.0 specification, section 3.10; KHR_lights_punctual.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from heatlens.model.framing import CameraTrack, Pose, PoseKey, pose_of
from heatlens.scene.gltf.animation import FIRST_FRAME, Animation
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.scene import Array, Color, Daylight, PointLight, SceneCamera

SENSOR_WIDTH_MM = 36.0  # glTF has an angle but no sensor; this is the full frame of a still camera
_ASPECT = 16 / 9  # of a camera without one
_FOCAL_LEAST_MM, _FOCAL_MOST_MM = 0.1, 1e5
_STILL = "Lights that move stay where they are at frame 1."


@dataclass
class GltfViews:
    """The cameras and lights that hang on the nodes of the scene.

    Raises InputError for a camera or a light whose place or values are impossible.
    """

    gltf: GltfFile
    animation: Animation
    cameras: list[SceneCamera] = field(default_factory=list)
    lights: list[PointLight] = field(default_factory=list)
    daylight: Daylight = field(default_factory=Daylight)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _suns: int = 0

    def __post_init__(self) -> None:
        tree = self.animation.tree
        lit = self.gltf.root.inside("extensions", "KHR_lights_punctual").records("lights")
        cameras = self.gltf.listed("cameras")
        worlds = self.animation.worlds(FIRST_FRAME)
        for node in tree.seen:
            record = tree.records[node]
            camera = record.index("camera", len(cameras))
            if camera is not None:
                self._add_camera(node, record, cameras[camera])
            on_it = record.inside("extensions", "KHR_lights_punctual")
            light = on_it.index("light", len(lit))
            if light is not None:
                self._add_light(node, lit[light], worlds[node])
        if self.lights and not self._suns:
            self.daylight = replace(self.daylight, sun=(0.0, 0.0, 0.0))

    def _add_camera(self, node: int, on_node: Record, camera: Record) -> None:
        name = on_node.text("name") or camera.text("name") or f"camera {len(self.cameras) + 1}"
        if camera.text("type") != "perspective":
            self.notes[f"The camera {name!r} has no perspective, so no lens: it is left out."] = (
                None
            )
            return
        frames = self.animation.frames
        moves = frames is not None and self.animation.moves(node)
        at = [float(frame) for frame in frames] if frames and moves else [float(FIRST_FRAME)]
        places = self.animation.track_of(node, np.array(at))
        keys = [PoseKey(f, _pose(on_node, m)) for f, m in zip(at, places, strict=True)]
        focal_mm = _focal_length_mm(camera.inside("perspective"))
        unique = _unlike(name, [known.name for known in self.cameras])
        found = SceneCamera(unique, CameraTrack(tuple(keys)), focal_mm, SENSOR_WIDTH_MM)
        self.cameras.append(found)

    def _add_light(self, node: int, light: Record, world: Array) -> None:
        if self.animation.moves(node):
            self.notes[_STILL] = None
        kind = light.text("type")
        color, (x, y, z) = _color(light), _axis(light, world)
        if kind == "directional":
            self._add_sun((-x, -y, -z), color)
            return
        if kind not in ("point", "spot"):
            light.refuse(f"{kind[:20]!r} is not a light type of glTF")
        position = tuple(map(float, world[:3, 3]))
        spot = light.inside("spot")
        outer = min(spot.number("outerConeAngle", math.pi / 4, least=1e-6), math.pi / 2)
        inner = min(spot.number("innerConeAngle", 0.0, least=0.0), outer)
        is_spot = kind == "spot"
        self.lights.append(
            PointLight(
                (position[0], position[1], position[2]),
                color,
                (x, y, z) if is_spot else None,
                (math.cos(inner), math.cos(outer)) if is_spot else (1.0, 0.0),
            )
        )

    def _add_sun(self, to_sun: Color, irradiance: Color) -> None:
        """Keep the brightest directional light, because the scene can have one sun."""
        self._suns += 1
        if self._suns > 1:
            self.notes["Of several suns only the brightest shines."] = None
        if self._suns == 1 or sum(irradiance) > sum(self.daylight.sun):
            self.daylight = replace(self.daylight, to_sun=to_sun, sun=irradiance)


def _focal_length_mm(perspective: Record) -> float:
    angle = perspective.number("yfov", math.nan, least=1e-6)
    aspect = perspective.number("aspectRatio", _ASPECT, least=1e-3)
    if not angle < math.pi:
        perspective.refuse("its angle 'yfov' should lie between 0 and pi")
    focal_mm = SENSOR_WIDTH_MM / (2 * aspect * math.tan(angle / 2))
    if not _FOCAL_LEAST_MM <= focal_mm <= _FOCAL_MOST_MM:
        perspective.refuse(f"no lens has a focal length of {focal_mm:g} mm")
    return focal_mm


def _pose(on_node: Record, matrix: Array) -> Pose:
    """Return the pose of a node without its ancestors' scale, upright where they mirror it."""
    back, up = matrix[:3, 2], matrix[:3, 1]
    side = np.cross(up, back)
    if not np.linalg.norm(side) > 1e-12 or not np.abs(matrix[:3, 3]).max() <= 1e9:
        on_node.refuse("a camera is scaled to zero, or its place is not finite")
    rigid = matrix.copy()
    rigid[:3, 0], rigid[:3, 1] = side, np.cross(back, side)
    return pose_of(rigid)


def _axis(light: Record, world: Array) -> tuple[float, float, float]:
    """Return the direction in which a light shines, which is its node's -z."""
    length = float(np.linalg.norm(world[:3, 2]))
    if not (1e-12 < length < 1e12 and np.abs(world[:3, 3]).max() <= 1e9):
        light.refuse("a light is scaled to zero, or its place is not finite")
    x, y, z = map(float, -world[:3, 2] / length)
    return x, y, z


def _color(light: Record) -> Color:
    intensity = light.number("intensity", 1.0, least=0.0)
    red, green, blue = (max(v, 0.0) * intensity for v in light.row("color", (1, 1, 1)))
    return red, green, blue


def _unlike(name: str, others: list[str]) -> str:
    """Return the name, with a number after it if another camera has it already."""
    found, number = name, 1
    while found in others:
        number += 1
        found = f"{name} {number}"
    return found
