"""Cameras of a glTF file.

Source: Khronos, glTF 2.0 specification, section 3.10.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey, pose_of
from heatlens.media.scene.gltf.animation import Animation
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.scene import Array, SceneCamera

SENSOR_WIDTH_MM = 36.0  # full frame: glTF has an angle of view but no sensor
_ASPECT = 16 / 9  # aspect ratio of a camera without one
_CLIPPING_NOTE = "The clipping planes of cameras are ignored: everything is drawn"
_FOCAL_LEAST_MM, _FOCAL_MOST_MM = 0.1, 1e5


@dataclass
class GltfCameras:
    """The cameras on the nodes of the scene.

    Raises InputError for a camera whose position or values are impossible.
    """

    gltf: GltfFile
    animation: Animation
    cameras: list[SceneCamera] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _planes: list[tuple[SceneCamera, Record]] = field(default_factory=list)

    def __post_init__(self) -> None:
        tree = self.animation.tree
        for node in tree.scene_nodes:
            record = tree.records[node]
            camera = self.gltf.index(record, "camera", "cameras")
            if camera is not None:
                self._add_camera(node, record, camera)

    def _add_camera(self, node: int, node_record: Record, number: int) -> None:
        """Add camera `number` of the file on a node; an orthographic one becomes a note."""
        camera_record = self.gltf.top_level("cameras")[number]
        name = (
            node_record.text("name")
            or camera_record.text("name")
            or f"camera {len(self.cameras) + 1}"
        )
        if camera_record.text("type") != "perspective":
            note = f"The camera {name!r} is orthographic and has no lens: it is left out."
            self.notes[note] = None
            return
        lengths_mm = self._focal_lengths_mm(number, camera_record.object_at("perspective"))
        is_animated = len(lengths_mm) > 1
        scene_camera = SceneCamera(
            name=_make_unique(name, [other_camera.name for other_camera in self.cameras]),
            track=self._read_track(node, node_record),
            focal_length_mm=lengths_mm[0],
            sensor_width_mm=SENSOR_WIDTH_MM,
            lens_frames=tuple(self.animation.frames or ()) if is_animated else (),
            lens_tracks={"focal_length_mm": lengths_mm} if is_animated else {},
            is_width_assumed=True,
        )
        self.cameras.append(scene_camera)
        self._planes.append((scene_camera, camera_record.object_at("perspective")))

    def _read_track(self, node: int, node_record: Record) -> CameraTrack:
        """Return the poses of the camera on a node, a single one if it stands still."""
        moving_frames = self.animation.frames if self.animation.is_moving(node) else None
        frames = list(map(float, moving_frames or (self.animation.first_frame,)))
        world_matrices = self.animation.world_matrices_of(node, np.array(frames))
        keys = (
            PoseKey(f, _rigid_pose(node_record, m))
            for f, m in zip(frames, world_matrices, strict=True)
        )
        return CameraTrack(tuple(keys))

    def _focal_lengths_mm(self, number: int, perspective: Record) -> tuple[float, ...]:
        """Return the focal length at each frame, or a single one if the angle is constant."""
        track, frames = self.animation.angles.get(number), self.animation.frames
        if track is None or frames is None:
            angle = perspective.number("yfov", math.nan, least=1e-6)
            return (_focal_length_mm(perspective, angle),)
        angles = track.sample(self.animation.times_s(np.array(list(frames), float)))[:, 0]
        return tuple(_focal_length_mm(perspective, angle) for angle in angles.tolist())

    def note_clipping(self, boxes_m: Array) -> None:
        """Add a note for cameras whose clipping planes cut the boxes (N, 2, 3) of the world.

        heatlens also shows what is nearer than a camera's `znear` or farther than its `zfar`.
        """
        corners = np.stack([boxes_m[:, [i, j, k], [0, 1, 2]] for i, j, k in np.ndindex(2, 2, 2)])
        for camera, planes in self._planes:
            row = camera.track.keys[0].pose.world_to_camera[2]
            depths_m = -(corners @ row[:3] + row[3])
            far_m, near_m = planes.number("zfar", math.inf), planes.number("znear", 0.0)
            if depths_m.max() > far_m or ((depths_m > 0) & (depths_m < near_m)).any():
                self.gltf.note_loss(_CLIPPING_NOTE, planes)


def _focal_length_mm(perspective: Record, angle: float) -> float:
    """Return the focal length for a vertical angle of view in radians, on full frame."""
    aspect = perspective.number("aspectRatio", _ASPECT, least=1e-3)
    if not 0 < angle < math.pi:
        perspective.refuse("its angle 'yfov' should lie between 0 and pi")
    focal_mm = SENSOR_WIDTH_MM / (2 * aspect * math.tan(angle / 2))
    if not _FOCAL_LEAST_MM <= focal_mm <= _FOCAL_MOST_MM:
        perspective.refuse(f"no lens has a focal length of {focal_mm:g} mm")
    return focal_mm


def _rigid_pose(node_record: Record, matrix: Array) -> Pose:
    """Return the pose of a node at its matrix, without the scale and mirroring of its ancestors."""
    back, up = matrix[:3, 2], matrix[:3, 1]
    side = np.cross(up, back)
    if not np.linalg.norm(side) > 1e-12 or not np.abs(matrix[:3, 3]).max() <= 1e9:
        node_record.refuse("a camera is scaled to zero, or its place is not finite")
    rigid = matrix.copy()
    rigid[:3, 0], rigid[:3, 1] = side, np.cross(back, side)
    return pose_of(rigid)


def _make_unique(name: str, other_names: list[str]) -> str:
    """Return the name, with a number after it if another camera has it already."""
    unique_name, number = name, 1
    while unique_name in other_names:
        number += 1
        unique_name = f"{name} {number}"
    return unique_name
