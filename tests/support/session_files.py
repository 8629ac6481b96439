"""Small plates and a small scene with known values, for tests of sessions and windows."""

from pathlib import Path
from typing import Any

import numpy as np

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.header.camera_header import lens_attributes
from support.exr_files import write_file
from support.gltf_files import GltfWriter
from support.plates import Image, room

WIDTH, HEIGHT = 96, 64
LENS = Lens(85.0, 1.0, 2.0, 36.0)  # 10 pixels of blur at infinity
QUICK = DefocusSettings(bokeh=Bokeh.HEAT, quality=Quality.DRAFT, layers=1)

# Pixels of the room, each amid an area of one depth.
BALL, POST, SKY = (60, 32), (22, 50), (80, 4)
BALL_M, POST_M = 2.0, np.float32(0.9).item()


def write_plate(path: Path, color: Image, **channels_and_attributes: Any) -> Path:
    """Write `color` (H, W, 3 or 4) and channels by name, the lens in the header."""
    height, width = color.shape[:2]
    channels = {
        name: np.ascontiguousarray(color[..., i]) for i, name in enumerate("RGBA"[: color.shape[2]])
    }
    attributes = lens_attributes(
        LENS.focal_length_mm, LENS.f_stop, LENS.focus_distance_m, LENS.sensor_width_mm
    )
    for name, value in channels_and_attributes.items():
        is_channel = isinstance(value, np.ndarray) and value.shape == (height, width)
        (channels if is_channel else attributes)[name] = value
    return write_file(path, channels, **attributes)


def room_file(path: Path, width: int = WIDTH, height: int = HEIGHT, **attributes: Any) -> Path:
    """Write the room with its distances."""
    color, depth = room(width, height)
    return write_plate(path, color, Z=depth, **attributes)


def scene_shot(path: Path, width_px: int, height_px: int, **changes: Any) -> Path:
    """Write a shot of the scene at a small size, which renders quickly, and the scene beside it."""
    scene = path.with_name("scene.gltf")
    if not scene.exists():
        write_scene(scene)
    framing = Framing(width_px=width_px, height_px=height_px)
    write_shot(path, Shot(lens=LENS, defocus=QUICK, source=str(scene), framing=framing, **changes))
    return path


def write_scene(path: Path) -> Path:
    """Write two squares, one of them moving away, and two cameras of different angle."""
    writer = GltfWriter()
    mesh = writer.mesh()
    near = writer.node(name="near", mesh=mesh, translation=[-0.5, -0.5, 0.0])
    writer.node(name="far", mesh=mesh, translation=[-2.0, -2.0, -4.0], scale=[4, 4, 1])
    writer.animate(near, "translation", [0.0, 1.0], [[-0.5, -0.5, 0.0], [-0.5, -0.5, -2.0]])
    for name, x, angle in (("main", 0.0, 0.7), ("side", 1.5, 0.4)):
        perspective = {"yfov": angle, "znear": 0.1, "aspectRatio": 1.5}
        camera = writer.add("cameras", type="perspective", perspective=perspective, name=name)
        writer.node(name=name, camera=camera, translation=[x, 0.0, 3.0])
    return writer.write(path)
