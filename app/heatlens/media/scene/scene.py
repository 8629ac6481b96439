"""A 3D scene as plain values, read from a file or made by a program; nothing here draws.

The world is right-handed with y up, in meters; matrices act on columns. Colors are scene-linear
with Rec.709 primaries; pictures that color a surface are 8-bit sRGB, as files keep them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.core.model.option import suggest_similar
from heatlens.core.model.shot.camera_track import CameraTrack
from heatlens.core.model.shot.framing import WorldAxis
from heatlens.media.scene.material import Color, Material

Array = NDArray[np.float64]
INSTANCES_MOST = 200_000
# frame -> (instances, 4, 4): the object-to-world matrix of each instance
Motion = Callable[[float], Array]
# frame -> the deformed mesh, always with the same triangles
Deform = Callable[[float], "Mesh"]
# frame -> all lights of the scene, some of which move
LightMotion = Callable[[float], "Lighting"]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one material.

    positions_m  (V, 3) float32
    normals      (V, 3) float32, unit
    uvs          (V, 2) float32, v downwards as in glTF; zeros where there are none
    triangles    (T, 3) uint32 into the vertices
    material     index into the scene's materials
    colors       (V, 3) or (V, 4) float32 from 0 to 1, linear; base color and alpha are multiplied
                 by them; None for white
    tangents     (V, 4) float32: the direction of u, unit or zero, and the sign of the bitangent
                 against v; None for a mesh without a normal map, which has no effect without them
    more_uvs     (V, 2) float32: the second set of texture coordinates, which a `MapPlace` may use
    sources      (V,) uint32: the vertex of the file from which each was made; None for same order
    """

    positions_m: NDArray[np.float32]
    normals: NDArray[np.float32]
    uvs: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    material: int = 0
    colors: NDArray[np.float32] | None = None
    tangents: NDArray[np.float32] | None = None
    more_uvs: NDArray[np.float32] | None = None
    sources: NDArray[np.uint32] | None = None

    @cached_property
    def box_m(self) -> Array:
        """The box (2, 3) around the triangles: its least and greatest corner; zeros for none."""
        if not len(self.triangles):
            return np.zeros((2, 3))
        # Parts of an object often share a list of vertices, of which each uses only some.
        is_used = np.zeros(len(self.positions_m), bool)
        is_used[self.triangles] = True
        used_positions = self.positions_m[is_used]
        return np.array([used_positions.min(axis=0), used_positions.max(axis=0)], np.float64)


@dataclass(frozen=True, eq=False)
class Instance:
    """A mesh at a place in the scene. Instances of the same name are one object for the user."""

    name: str
    mesh: int
    to_world: Array  # (4, 4)


@dataclass(frozen=True)
class SceneCamera:
    """A camera of the scene over its frames.

    is_width_assumed  the file has only an angle of view, for which a sensor was assumed
    f_stop            None if the file has none, as always with glTF
    focus_distance_m  may be infinite; None if the file has none
    lens_frames       frames at which `lens_tracks` give the lens
    lens_tracks       values at each of the frames, by field of Lens, for fields that change
    """

    name: str
    track: CameraTrack
    focal_length_mm: float = 35.0
    sensor_width_mm: float = 36.0
    f_stop: float | None = None
    focus_distance_m: float | None = None
    lens_frames: tuple[int, ...] = ()
    lens_tracks: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    is_width_assumed: bool = False


@dataclass(frozen=True)
class PointLight:
    """A light without shadows, as in KHR_lights_punctual.

    intensity     candela-like: radiance of a white surface facing it at 1 m is intensity / pi
    direction     axis of a spot; None for a light that shines in all directions
    cone_cosines  cosines of a spot's inner and outer half angle
    is_smooth     a spot fades between the two as in Cycles, else as in glTF, which is sharper
    """

    position_m: tuple[float, float, float]
    intensity: Color
    direction: tuple[float, float, float] | None = None
    cone_cosines: tuple[float, float] = (1.0, 0.0)
    is_smooth: bool = False


@dataclass(frozen=True)
class Daylight:
    """The sun, which is the only light with shadows, and a sky gradient.

    to_sun         direction towards the sun, of any length
    sun            irradiance of a surface that faces it; black for none
    zenith         radiance of the sky straight above
    horizon        radiance of the sky at the horizon
    ground         radiance from below
    """

    to_sun: tuple[float, float, float] = (0.4, 0.8, 0.45)
    sun: Color = (3.0, 2.8, 2.5)
    zenith: Color = (0.25, 0.40, 0.75)
    horizon: Color = (0.75, 0.80, 0.85)
    ground: Color = (0.20, 0.18, 0.16)


@dataclass(frozen=True)
class Lighting:
    """All lights of a scene at one frame."""

    lights: tuple[PointLight, ...]
    daylight: Daylight


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene with everything that is visible in it.

    path      path of the file, or a name for a scene that comes from no file
    motion    matrices of the instances at each frame; None if they never move
    frames    frames in which something moves, None for a still scene
    deforms   the mesh at each frame, by index, for each mesh that changes its shape
    light_motion  the lights at each frame, as many as `lights`; None if none of them moves
    clips     names of the animations that the file has
    notes     sentences for the user
    up_axis, meters_per_unit  chosen or guessed for a file that lacks them, see `placing`
    named_files  the other files of the scene, whether they exist or not; None if its reader does
              not know them

    Raises InputError if it has no instances.
    """

    path: Path
    meshes: tuple[Mesh, ...]
    instances: tuple[Instance, ...]
    materials: tuple[Material, ...] = (Material(),)
    images: tuple[NDArray[np.uint8], ...] = ()  # (H, W, 4), row 0 at v = 0
    cameras: tuple[SceneCamera, ...] = ()
    lights: tuple[PointLight, ...] = ()
    daylight: Daylight = field(default_factory=Daylight)
    motion: Motion | None = None
    frames: FrameRange | None = None
    frames_per_second: float = FRAMES_PER_SECOND
    notes: tuple[str, ...] = ()
    deforms: Mapping[int, Deform] = field(default_factory=dict)
    clips: tuple[str, ...] = ()
    light_motion: LightMotion | None = None
    up_axis: WorldAxis = WorldAxis.Y
    meters_per_unit: float = 1.0
    named_files: tuple[Path, ...] | None = None
    _latest_shapes: list[tuple[float, Mapping[int, Mesh]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        if not self.instances:
            raise InputError(
                f"{self.path}: this scene has no surfaces to look at: export it with its meshes."
            )
        check_instances(self.path, len(self.instances))

    @property
    def triangle_count(self) -> int:
        """Number of triangles of all instances together."""
        return sum(len(self.meshes[instance.mesh].triangles) for instance in self.instances)

    @cached_property
    def boxes_m(self) -> Array:
        """The boxes (instances, 2, 3) of the meshes of all instances, in their own axes."""
        return np.array([self.meshes[instance.mesh].box_m for instance in self.instances])

    @property
    def is_moving(self) -> bool:
        """Whether objects or lights move, or meshes change their shape."""
        return self.motion is not None or bool(self.deforms) or self.light_motion is not None

    def lighting_at(self, frame: float) -> Lighting:
        """Return the lights of the scene at a frame."""
        if self.light_motion is not None:
            return self.light_motion(frame)
        return Lighting(self.lights, self.daylight)

    def boxes_at(self, frame: float) -> Array:
        """Return the boxes (instances, 2, 3) of the meshes at a frame, in their own axes."""
        if not self.deforms:
            return self.boxes_m
        boxes = [mesh.box_m for mesh in self.meshes]
        for number, mesh in self.shapes_at(frame).items():
            boxes[number] = mesh.box_m
        return np.array([boxes[instance.mesh] for instance in self.instances])

    def shapes_at(self, frame: float) -> Mapping[int, Mesh]:
        """Return the meshes that change their shape, by index, deformed for a frame.

        Those of the last frame are cached, because placing and drawing both need them.
        """
        latest = self._latest_shapes
        if latest and latest[0][0] == frame:
            return latest[0][1]
        shapes = {number: deform(frame) for number, deform in self.deforms.items()}
        latest[:] = [(frame, shapes)]
        return shapes

    def transforms_at(self, frame: float) -> Array:
        """Return the matrices (instances, 4, 4) from object to world at a frame."""
        if self.motion is not None:
            return self.motion(frame)
        return np.stack([instance.to_world for instance in self.instances])

    def camera_named(self, name: str) -> SceneCamera:
        """Return a camera; raise InputError that lists the names if there is no such camera."""
        for camera in self.cameras:
            if camera.name == name:
                return camera
        names = [camera.name for camera in self.cameras]
        name_list = ", ".join(names) or "none"
        raise InputError(
            f"{self.path} has no camera called {name!r}; there are: "
            f"{name_list}.{suggest_similar(name, names)}"
        )


def check_instances(path: Path, count: int) -> None:
    """Raise InputError if a file has more instances than can be drawn."""
    if count > INSTANCES_MOST:
        raise InputError(
            f"{path} has {count:,} objects or more; heatlens draws {INSTANCES_MOST:,} at most."
        )
