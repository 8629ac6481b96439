"""Small EXR files for tests of the window, what is known of them, and how they look in it."""

from pathlib import Path

import numpy as np

from heatlens.media.plate.read import read_plate
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import new_texture, upload
from support.gui import Gui


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
