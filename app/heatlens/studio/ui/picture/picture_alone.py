"""Draw the whole picture into a texture, for the second window and for stills of looks.

The labels of the grid are textures there, because the second window has no ImGui.
"""

from collections.abc import Sequence

import numpy as np
from imgui_bundle import imgui
from PIL import Image, ImageDraw, ImageFont

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import ViewState
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.render.display.picture_pass import PlacedPicture
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Sampling, Texture
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
        target = self._target_of_size(size_px)
        target.use()
        target.scissor = None
        target.clear(*theme.SURROUND)
        if pictures is not None:
            self._panel.place_alone(pictures, view, size_px)
            tiles = pictures.tiles if has_labels else ()
            labels = self._labels.place_labels(tiles, self._panel.cells[: len(tiles)], size_px[1])
            self._panel.place_over(labels)
            self._panel.paint(target, size_px)

    def _target_of_size(self, size_px: tuple[int, int]) -> Framebuffer:
        """Return the framebuffer of the texture, made again if the size has changed."""
        if self._target is None or self.texture is None or self.texture.size != size_px:
            self.release()
            self.texture = self._ctx.texture(size_px, 4)
            self._target = self._ctx.framebuffer([self.texture])
        return self._target

    def detach_texture(self) -> Texture:
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


_HEIGHT_SHARE, _MIN_FONT_PX = 1 / 45, 12.0  # font size: share of window height; least, in pixels
_LEFT_EM, _BELOW_EM, _PAD_EM = 0.9, 0.8, 0.4  # the same as in `draw_tiles`


class TileLabels:
    """The textures of the labels, kept from frame to frame."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._textures: dict[tuple[str, int], Texture] = {}

    def place_labels(
        self, tiles: Sequence[Tile], cells: Sequence[Viewport], height_px: int
    ) -> list[PlacedPicture]:
        """Return the labels, each placed at the lower left of its cell, in pixels of the window."""
        size = round(max(height_px * _HEIGHT_SHARE, _MIN_FONT_PX))
        self._keep_only({(tile.words, size) for tile in tiles})
        return [
            _place_label(self._texture(tile.words, size), cell, size)
            for tile, cell in zip(tiles, cells, strict=True)
        ]

    def _texture(self, words: str, size: int) -> Texture:
        """Return the texture of a label, drawn at its first use."""
        key = words, size
        if key not in self._textures:
            pixels = label_pixels(words, size)
            height, width = pixels.shape[:2]
            texture = self._ctx.texture((width, height), 4, pixels.tobytes())
            texture.sampling = Sampling.NEAREST
            self._textures[key] = texture
        return self._textures[key]

    def _keep_only(self, keys: set[tuple[str, int]]) -> None:
        """Release the textures of all other labels."""
        for key in self._textures.keys() - keys:
            self._textures.pop(key).release()

    def release(self) -> None:
        """Release the textures."""
        self._keep_only(set())


def label_pixels(words: str, size: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return a label as (H, W, 4) bytes, straight alpha: text of `size` px on dark ground."""
    font = ImageFont.truetype(str(theme.FONT_FILE), size)
    padding, (ascent, descent) = round(_PAD_EM * size), font.getmetrics()
    width = round(font.getlength(words)) + 2 * padding
    background, text_color = (
        _bytes_of(color) for color in (theme.OVER_PICTURE.shadow, theme.OVER_PICTURE.handle)
    )
    image = Image.new("RGBA", (width, ascent + descent + padding), background)
    ImageDraw.Draw(image).text((padding, padding // 2), words, fill=text_color, font=font)
    return np.asarray(image, np.uint8)


def _bytes_of(color: int) -> tuple[int, int, int, int]:
    """Return the components of one of ImGui's packed colors, 0 to 255."""
    channels = imgui.color_convert_u32_to_float4(color)
    red, green, blue, alpha = (
        round(255 * channel) for channel in (channels.x, channels.y, channels.z, channels.w)
    )
    return red, green, blue, alpha


def _place_label(texture: Texture, cell: Viewport, size: int) -> PlacedPicture:
    """Place a label at the lower left of a cell, clipped to it."""
    (x, y), (width, height) = cell.corner, cell.size
    left, bottom = round(x + _LEFT_EM * size), round(y + height - _BELOW_EM * size)
    first = float(left), float(bottom - texture.height)
    clip = Box(round(x), round(y), round(x + width), round(y + height))
    last = float(left + texture.width), float(bottom)
    return PlacedPicture(texture, first, last, clip, is_nearest=True, is_opaque=False)
