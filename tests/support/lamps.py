"""Make plates with a point of light, and render them."""

import numpy as np

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import FAR_M, Image, plate_of

KINDS = [(bokeh, quality) for bokeh in Bokeh for quality in Quality]
SIZE = 129
DIM, LAMP = 0.25, 300.0  # added to one pixel: too little, and enough, to be drawn as a disc
# The poles' images are half floats: 11 bits, of which every passing between rows and columns costs
# a rounding to the nearest.
HALF_ROUNDING = 2.0**-11


def render_plate_with_lens(
    renderer: FrameRenderer, plate: Plate, lens: Lens, *settings: object
) -> Image:
    """Render `plate`; return (H, W, 4). `settings` are in the order of DefocusSettings."""
    renderer.load(plate)
    return renderer.pixels(Shot(lens, DefocusSettings(*settings)))


def grey_for(bokeh: Bokeh) -> float:
    """Return the gray around the point of light, as the disc kernel has negative lobes.

    Black would cut the lobes off. The gray is exact in half floats. Other kernels use black, near
    which half floats are finer.
    """
    return 0.0078125 if bokeh is Bokeh.DISC else 0.0


def point_plate(bokeh: Bokeh, light: float, size: int = SIZE, depth_m: float = FAR_M) -> Plate:
    """Return a plate with one pixel that is `light` brighter than its surroundings."""
    color = np.full((size, size, 3), grey_for(bokeh), np.float32)
    color[size // 2, size // 2] += light
    return plate_of(color, np.full((size, size), depth_m, np.float32))
