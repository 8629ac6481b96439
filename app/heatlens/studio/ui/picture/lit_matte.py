"""Draw the matte of a mark over the picture, in the color of marks."""

import numpy as np
from imgui_bundle import ImVec2, imgui

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.picture_view import PictureView
from heatlens.media.plate.plate import FloatImage
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.studio.board.facts import Facts
from heatlens.studio.ui import rects, theme

LitMatte = tuple[FloatImage, Box]  # coverage, the top row first, and its data window
_OPACITY = 0.45


class MatteDrawer:
    """Draws a matte over the picture; its texture is kept while the matte stays the same."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._matte: LitMatte | None = None
        self._texture: Texture | None = None

    def draw(self, matte: LitMatte | None, facts: Facts, view: PictureView) -> None:
        """Draw the matte in the current window, where its thing is in the picture."""
        if matte is not self._matte:
            self._upload(matte)
        if matte is None or self._texture is None or facts.plate is None:
            return
        box, display = matte[1], facts.plate.display_window
        corners = (box.x0, box.y0), (box.x1, box.y1)
        first, end = (
            ImVec2(
                *view.geometry.window_at_picture(
                    facts.picture_point((x - display.x0, y - display.y0))
                )
            )
            for x, y in corners
        )
        (left, top), (width, height) = view.viewport.corner, view.viewport.size
        draw = imgui.get_window_draw_list()
        draw.push_clip_rect(ImVec2(left, top), ImVec2(left + width, top + height), True)
        draw.add_image(imgui.ImTextureRef(self._texture.handle), first, end)
        draw.pop_clip_rect()
        rects.note_at("lit matte", (first.x, first.y, end.x, end.y))

    def _upload(self, matte: LitMatte | None) -> None:
        """Make the texture of a matte, in place of the one before."""
        if self._texture is not None:
            self._texture.release()
        self._matte, self._texture = matte, None
        if matte is None:
            return
        color = imgui.color_convert_u32_to_float4(theme.OVER_PICTURE.mark)
        pixels = np.empty((*matte[0].shape, 4), np.uint8)
        pixels[..., :3] = np.multiply((color.x, color.y, color.z), 255).astype(np.uint8)
        pixels[..., 3] = np.clip(matte[0], 0.0, 1.0) * (255 * _OPACITY)
        height, width = matte[0].shape
        self._texture = self._ctx.texture((width, height), 4, pixels.tobytes())
