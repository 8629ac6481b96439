"""Cameras of a glTF file.

Source: Khronos, glTF 2.0 specification, section 3.10.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from heatlens.model.framing import CameraTrack, Pose, PoseKey, pose_of
from heatlens.scene.gltf.animation import Animation
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.scene import Array, SceneCamera

SENSOR_WIDTH_MM = 36.0  # glTF has an angle but no sensor; this is the full frame of a still camera
_ASPECT = 16 / 9  # of a camera without one
_FOCAL_LEAST_MM, _FOCAL_MOST_MM = 0.1, 1e5


@dataclass
class GltfCameras:
    """The cameras that hang on the nodes of the scene.

    Raises InputError for a camera whose place or values are impossible.
    """

    gltf: GltfFile
    animation: Animation
    cameras: list[SceneCamera] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once

    def __post_init__(self) -> None:
        tree = self.animation.tree
        cameras = self.gltf.listed("cameras")
        for node in tree.seen:
            record = tree.records[node]
            camera = record.index("camera", len(cameras))
            if camera is not None:
                self._add_camera(node, record, cameras[camera])

    def _add_camera(self, node: int, on_node: Record, camera: Record) -> None:
        name = on_node.text("name") or camera.text("name") or f"camera {len(self.cameras) + 1}"
        if camera.text("type") != "perspective":
            self.notes[f"The camera {name!r} has no perspective, so no lens: it is left out."] = (
                None
            )
            return
        frames = self.animation.frames
        moves = frames is not None and self.animation.moves(node)
        at = (
            [float(frame) for frame in frames]
            if frames and moves
            else [float(self.animation.first_frame)]
        )
        places = self.animation.track_of(node, np.array(at))
        keys = [PoseKey(f, _pose(on_node, m)) for f, m in zip(at, places, strict=True)]
        focal_mm = _focal_length_mm(camera.inside("perspective"))
        unique = _unlike(name, [known.name for known in self.cameras])
        track = CameraTrack(tuple(keys))
        found = SceneCamera(unique, track, focal_mm, SENSOR_WIDTH_MM, is_width_assumed=True)
        self.cameras.append(found)


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


def _unlike(name: str, others: list[str]) -> str:
    """Return the name, with a number after it if another camera has it already."""
    found, number = name, 1
    while found in others:
        number += 1
        found = f"{name} {number}"
    return found
