"""Helpers that compare pictures in the window with the plates of tests."""

from pathlib import Path

import numpy as np

from heatlens.media.plate.read import read_plate
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import new_texture, upload
from support.gui import Gui


def display_bytes(
    gui: Gui, pixels: np.ndarray, stops: float = 0.0, gamma: float = 1.0
) -> np.ndarray:
    """Convert linear `pixels` (H, W, 4) by the window's view transform to bytes (H, W, 3)."""
    ctx, size = gui.ctx, pixels.shape[1::-1]
    screen = DisplayPass(ctx)
    screen.set_transform(gui.session.pictures.color.transform)
    picture, out = new_texture(ctx, size, 4), ctx.texture(size, 4)
    upload(picture, pixels)
    screen.run(picture, out, stops, gamma)
    pixels_out = np.frombuffer(out.read(), np.uint8).reshape(*pixels.shape[:2], 4)
    for gpu_object in (screen, picture, out):
        gpu_object.release()
    return pixels_out[..., :3]


def screen_region(gui: Gui, zoom: int = 1) -> np.ndarray:
    """Return the screen pixels (H, W, 3) of the picture's display window as bytes."""
    x, y = gui.session.pictures.view.geometry.origin
    shape = gui.session.facts.shape
    assert (x, y) == (int(x), int(y))
    height, width = shape.height_px * zoom, shape.width_px * zoom
    pixels = gui.screenshot()[int(y) : int(y) + height, int(x) : int(x) + width]
    assert pixels.shape == (height, width, 3)
    return pixels


def render_shot_from_file(gui: Gui, renderer: FrameRenderer) -> np.ndarray:
    """Render the shot's picture again from the file."""
    renderer.load(read_plate(Path(gui.session.facts.shot.source)))
    return renderer.pixels(gui.session.facts.shot)


def plate_pixels(gui: Gui) -> np.ndarray:
    return gui.session.source.plate.color
