"""Draw the whole picture into a texture, for the second window and for stills of looks."""

import moderngl

from heatlens.model.view.view import ViewState
from heatlens.session.pictures.picture_view import PictureView
from heatlens.ui import theme
from heatlens.ui.picture.pictures import Pictures
from heatlens.ui.picture.tile_labels import TileLabels
from heatlens.ui.picture.viewport import ViewportPanel


class PictureAlone:
    """A texture of any size with the whole picture."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._panel = ViewportPanel(ctx, PictureView())
        self._labels = TileLabels(ctx)
        self._target: moderngl.Framebuffer | None = None
        self.texture: moderngl.Texture | None = None

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
        target.scissor = None  # type: ignore[assignment]  # its stub does not know that
        target.clear(*theme.SURROUND)
        if pictures is not None:
            self._panel.place_alone(pictures, view, size_px)
            tiles = pictures.tiles if has_labels else ()
            labels = self._labels.placed(tiles, self._panel.cells[: len(tiles)], size_px[1])
            self._panel.place_over(labels)
            self._panel.paint(target, size_px)

    def _sized(self, size_px: tuple[int, int]) -> moderngl.Framebuffer:
        if self._target is None or self.texture is None or self.texture.size != size_px:
            self.release()
            self.texture = self._ctx.texture(size_px, 4)
            self._target = self._ctx.framebuffer([self.texture])
        return self._target

    def hand_over(self) -> moderngl.Texture:
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
