"""The whole picture drawn into a texture: for a second window, and for stills of looks."""

import moderngl

from heatlens.model.view import ViewState
from heatlens.session.picture_view import PictureView
from heatlens.ui import theme
from heatlens.ui.picture.pictures import Pictures
from heatlens.ui.picture.tile_labels import TileLabels
from heatlens.ui.picture.viewport import ViewportPanel


class PictureAlone:
    """Draws the whole picture into a texture of any size."""

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
        """Draw it into `texture`, which gets this size; without pictures it is empty.

        `has_labels`: looks beside each other are named; one picture has nothing written on it.
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
        """Return the texture, which is the caller's from now on."""
        texture = self.texture
        assert texture is not None and self._target is not None
        self._target.release()
        self._target = self.texture = None
        return texture

    def release(self) -> None:
        """Give the texture back, and those of labels."""
        self._labels.release()
        if self._target is not None and self.texture is not None:
            self._target.release()
            self.texture.release()
        self._target = self.texture = None
