"""Make plates with alpha, and render them."""

from dataclasses import replace

import numpy as np

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.deep.stacked import Surface, stack_surfaces
from heatlens.media.plate.plate import Plate
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import Image, lens_blurring, plate_of, room

Layer = tuple[Image | float, Image, float]  # straight light, coverage (H, W), metres


def coverage(height: int, width: int) -> Image:
    """Return alpha from 1 at the left to 0 at the right, with a soft and a hard edge between."""
    ramp = np.clip(1.5 - np.arange(width, dtype=np.float32) / (width / 3), 0, 1)
    alpha = np.broadcast_to(ramp, (height, width)).copy()
    alpha[: height // 4, : width // 2] = 0.0
    return alpha


def render_alpha_plate(
    renderer: FrameRenderer, rgba: Image, depth_m: Image, coc_px: float, *settings
) -> Image:
    """Render a plate with alpha through a lens of blur `coc_px`. Return (H, W, 4)."""
    renderer.load(plate_of(rgba, depth_m, has_alpha=True))
    lens = lens_blurring(coc_px, depth_m.shape[1])
    return renderer.pixels(Shot(lens, DefocusSettings(*settings)))


def covered_room() -> tuple[Image, Image]:
    """Return the room, premultiplied by its coverage, and its depth."""
    color, depth = room()
    alpha = coverage(*depth.shape)[..., None]
    return np.concatenate([color * alpha, alpha], axis=2), depth


def plate_of_layers(layers: list[Layer], has_alpha: bool = True, is_measured: bool = True) -> Plate:
    """Return the plate with the lists of `layers`, each a premultiplied element of one render."""
    surfaces = []
    for light, cover, depth_m in layers:
        rgba = np.stack([light * cover] * 3 + [cover], axis=2).astype(np.float32)
        surface_m = np.where(cover > 0, np.float32(depth_m), np.float32(np.inf))
        surfaces.append(Surface(rgba, surface_m))
    stack = stack_surfaces(surfaces, is_measured)
    plate = plate_of(stack.color, stack.depth_m, has_alpha=has_alpha)
    return replace(plate, fragments=stack.lists)
