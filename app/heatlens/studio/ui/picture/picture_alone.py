"""Draw the whole picture into a texture, for the second window and for stills of looks.

The labels of the grid are textures there, because the second window has no ImGui.
"""

from collections.abc import Sequence

import numpy as np
from imgui_bundle import imgui
from PIL import Image, ImageDraw, ImageFont

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.view import ViewState
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.render.display.picture_pass import PlacedPicture
from heatlens.render.gpu.device import Device, Framebuffer, Sampling, Texture
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.ui import theme
from heatlens.studio.ui.picture.grid import Pictures, Tile
from heatlens.studio.ui.picture.viewport import ViewportPanel


class PictureAlone:
    """A texture of any size with the whole picture."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._panel = ViewportPanel(ctx, PictureView())
        self._labels = TileLabels(ctx)
        self._target: Framebuffer | None = None
        self.texture: Texture | None = None

    def draw(
        self,
        pictures: Pictures | None,
        view: ViewState,
        size_px: tuple[int, int],
        has_labels: bool = False,
    ) -> None:
        """Draw the pictures into `texture`, which is resized to `size_px`; clear it if None.

        `has_labels` writes the names of the looks into a grid.
        """
        target = self._sized(size_px)
        target.use()
        target.scissor = None
        target.clear(*theme.SURROUND)
        if pictures is not None:
            self._panel.place_alone(pictures, view, size_px)
            tiles = pictures.tiles if has_labels else ()
            labels = self._labels.placed(tiles, self._panel.cells[: len(tiles)], size_px[1])
            self._panel.place_over(labels)
            self._panel.paint(target, size_px)

    def _sized(self, size_px: tuple[int, int]) -> Framebuffer:
        if self._target is None or self.texture is None or self.texture.size != size_px:
            self.release()
            self.texture = self._ctx.texture(size_px, 4)
            self._target = self._ctx.framebuffer([self.texture])
        return self._target

    def hand_over(self) -> Texture:
        """Return the texture; the caller owns it and must release it."""
        texture = self.texture
        assert texture is not None and self._target is not None
        self._target.release()
        self._target = self.texture = None
        return texture

    def release(self) -> None:
        """Release the textures of the picture and the labels."""
        self._labels.release()
        if self._target is not None and self.texture is not None:
            self._target.release()
            self.texture.release()
        self._target = self.texture = None


_HEIGHT_SHARE, _SIZE_LEAST = 1 / 45, 12.0  # font size: share of window height; least, in pixels
_ASIDE_EM, _BELOW_EM, _PAD_EM = 0.9, 0.8, 0.4  # the same as in `draw_tiles`


class TileLabels:
    """The textures of the labels, kept from frame to frame."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._made: dict[tuple[str, int], Texture] = {}

    def placed(
        self, tiles: Sequence[Tile], cells: Sequence[Viewport], height_px: int
    ) -> list[PlacedPicture]:
        """Return the labels, each placed at the lower left of its cell, in pixels of the window."""
        size = round(max(height_px * _HEIGHT_SHARE, _SIZE_LEAST))
        self._keep({(tile.words, size) for tile in tiles})
        return [
            _at_lower_left(self._texture(tile.words, size), cell, size)
            for tile, cell in zip(tiles, cells, strict=True)
        ]

    def _texture(self, words: str, size: int) -> Texture:
        key = words, size
        if key not in self._made:
            pixels = label_pixels(words, size)
            height, width = pixels.shape[:2]
            made = self._ctx.texture((width, height), 4, pixels.tobytes())
            made.sampling = Sampling.NEAREST
            self._made[key] = made
        return self._made[key]

    def _keep(self, wanted: set[tuple[str, int]]) -> None:
        for key in self._made.keys() - wanted:
            self._made.pop(key).release()

    def release(self) -> None:
        """Release the textures."""
        self._keep(set())


def label_pixels(words: str, size: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return a label as (H, W, 4) bytes, straight alpha: text of `size` px on dark ground."""
    font = ImageFont.truetype(str(theme.FONT_FILE), size)
    pad, (ascent, descent) = round(_PAD_EM * size), font.getmetrics()
    wide = round(font.getlength(words)) + 2 * pad
    ground, ink = (_bytes_of(c) for c in (theme.OVER_PICTURE.shadow, theme.OVER_PICTURE.handle))
    image = Image.new("RGBA", (wide, ascent + descent + pad), ground)
    ImageDraw.Draw(image).text((pad, pad // 2), words, fill=ink, font=font)
    return np.asarray(image, np.uint8)


def _bytes_of(color: int) -> tuple[int, int, int, int]:
    parts = imgui.color_convert_u32_to_float4(color)
    red, green, blue, alpha = (round(255 * part) for part in (parts.x, parts.y, parts.z, parts.w))
    return red, green, blue, alpha


def _at_lower_left(texture: Texture, cell: Viewport, size: int) -> PlacedPicture:
    (x, y), (width, height) = cell.corner, cell.size
    left, low = round(x + _ASIDE_EM * size), round(y + height - _BELOW_EM * size)
    first = float(left), float(low - texture.height)
    clip = Box(round(x), round(y), round(x + width), round(y + height))
    last = float(left + texture.width), float(low)
    return PlacedPicture(texture, first, last, clip, is_nearest=True, is_opaque=False)
