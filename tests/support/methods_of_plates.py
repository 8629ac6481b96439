"""Render plates by the other blur methods (gather, scatter, pyramid, …), for tests of them."""

import numpy as np

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import FOCUS_M, Image, coc_plate_of

OF_PLATES = [method for method in Method if not method.needs_scene]
OTHERS = [Method.GATHER, Method.SCATTER, Method.PYRAMID]
DISCS = [Method.GATHER, Method.SCATTER]
ANY_LENS = Lens(50.0, 2.0, FOCUS_M, 36.0)
# A disc's rim is a ramp one pixel wide, and the disc is of a pixel: 1/12 px^2 each.
PIXEL_VARIANCE = 2 / 12


def render_with_method(
    renderer: FrameRenderer, plate, method: Method, lens: Lens = ANY_LENS, proxy: float = 1.0
) -> Image:
    renderer.load(plate)
    return renderer.pixels(Shot(lens, DefocusSettings(method=method, proxy=proxy)))


def point_blurred(renderer: FrameRenderer, method: Method, coc_px: float, side: int) -> Image:
    """Blur one white pixel on black, with the same signed coc everywhere."""
    color = np.zeros((side, side, 3), np.float32)
    color[side // 2, side // 2] = 1.0
    plate = coc_plate_of(color, np.full((side, side), coc_px, np.float32))
    return render_with_method(renderer, plate, method)
