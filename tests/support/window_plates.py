"""Small EXR files for tests of the window, what is known of them, and how they look in it."""

from pathlib import Path
from typing import Any

import numpy as np

from heatlens.display.display_pass import DisplayPass
from heatlens.gpu.textures import new_texture, upload
from heatlens.model.lens import Lens
from heatlens.model.settings import Bokeh, DefocusSettings, Quality
from heatlens.plate.header.camera_header import lens_attributes
from heatlens.plate.read import read_plate
from heatlens.render import FrameRenderer
from support.exr_files import write_file
from support.gui import Gui
from support.plates import Image, room

WIDTH, HEIGHT = 96, 64
LENS = Lens(85.0, 1.0, 2.0, 36.0)  # 10 pixels of blur at infinity
QUICK = DefocusSettings(Bokeh.HEAT, Quality.DRAFT, 1)

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


def displayed(gui: Gui, pixels: np.ndarray, stops: float = 0.0, gamma: float = 1.0) -> np.ndarray:
    """Return (H, W, 3) bytes of linear `pixels` (H, W, 4) through the window's view transform."""
    ctx, size = gui.ctx, pixels.shape[1::-1]
    screen = DisplayPass(ctx)
    screen.set_transform(gui.session.pictures.color.transform)
    picture, out = new_texture(ctx, size, 4), ctx.texture(size, 4)
    upload(picture, pixels)
    screen.run(picture, out, stops, gamma)
    found = np.frombuffer(out.read(), np.uint8).reshape(*pixels.shape[:2], 4)
    for made in (screen, picture, out):
        made.release()
    return found[..., :3]


def region(gui: Gui, zoom: int = 1) -> np.ndarray:
    """Return (H, W, 3) bytes of the display window on the screen."""
    x, y = gui.session.pictures.view.geometry.origin
    shape = gui.session.facts.picture_shape
    assert (x, y) == (int(x), int(y))
    height, width = shape.height_px * zoom, shape.width_px * zoom
    found = gui.screenshot()[int(y) : int(y) + height, int(x) : int(x) + width]
    assert found.shape == (height, width, 3)
    return found


def rendered(gui: Gui, own: FrameRenderer) -> np.ndarray:
    """Render the shot's picture again from the file."""
    own.load(read_plate(Path(gui.session.facts.shot.source)))
    return own.pixels(gui.session.facts.shot)


def plate_pixels(gui: Gui) -> np.ndarray:
    return gui.session.source.plate.color
