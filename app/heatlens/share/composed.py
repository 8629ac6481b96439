"""Compose what the window shows of a picture, and take it from the GPU."""

from dataclasses import dataclass

import moderngl
import numpy as np

from heatlens.display.picture_pass import Detail, PicturePass, PlacedPicture
from heatlens.model.boxes import Box
from heatlens.share.picture import Pixels, in_display

_PREVIEW_PX = 720  # width of a preview at most: drawing it must not hold up the next one


@dataclass(frozen=True, eq=False)
class Seen:
    """A picture in display values, what lies over it, and the windows that it fills."""

    texture: moderngl.Texture
    data: Box
    display: Box
    detail: Detail | None = None
    overlay: moderngl.Texture | None = None

    @property
    def is_bare(self) -> bool:
        """True for a picture of full size with nothing over it."""
        is_full = self.texture.size == (self.data.width, self.data.height)
        return is_full and self.detail is None and self.overlay is None


class Composed:
    """Draws pictures for pages."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._pass = PicturePass(ctx)
        self._target: moderngl.Framebuffer | None = None

    def pixels(self, seen: Seen) -> Pixels:
        """Return the pixels of the display window, (H, W, 4), the top row first."""
        if seen.is_bare:
            pixels = np.empty((seen.texture.height, seen.texture.width, 4), np.uint8)
            seen.texture.read_into(pixels.data.cast("B"))
            return in_display(pixels, seen.data, seen.display)
        scale = 1.0 if seen.detail is None else min(1.0, _PREVIEW_PX / seen.display.width)
        size = max(1, round(seen.display.width * scale)), max(1, round(seen.display.height * scale))
        target = self._sized(size)
        target.use()
        target.clear(0.0, 0.0, 0.0, 1.0)
        self._pass.run(_placed(seen, scale, size), target, size)
        pixels = np.empty((size[1], size[0], 4), np.uint8)
        target.read_into(pixels.data.cast("B"), components=4)
        return pixels[::-1]

    def _sized(self, size: tuple[int, int]) -> moderngl.Framebuffer:
        if self._target is None or self._target.size != size:
            self.release()
            self._target = self._ctx.framebuffer([self._ctx.texture(size, 4)])
        return self._target

    def release(self) -> None:
        """Release the target that pictures are drawn into."""
        if self._target is not None:
            for texture in self._target.color_attachments:
                texture.release()
            self._target.release()
        self._target = None


def _placed(seen: Seen, scale: float, size: tuple[int, int]) -> list[PlacedPicture]:
    data, display, clip = seen.data, seen.display, Box(0, 0, *size)
    first = (data.x0 - display.x0) * scale, (data.y0 - display.y0) * scale
    last = (data.x1 - display.x0) * scale, (data.y1 - display.y0) * scale
    smooth = (moderngl.LINEAR, moderngl.LINEAR)
    seen.texture.filter = smooth
    if seen.detail is not None:
        seen.detail.plate.filter = seen.detail.coarse.filter = smooth
    placed = [PlacedPicture(seen.texture, first, last, clip, False, True, seen.detail)]
    if seen.overlay is not None:
        placed.append(PlacedPicture(seen.overlay, first, last, clip, True, False))
    return placed
