"""Convert a rendered frame by the view transform, and crop it to the display window."""

import moderngl
import numpy as np

from heatlens.display.display_pass import DisplayPass
from heatlens.export.job import Look
from heatlens.gpu.textures import download, new_texture
from heatlens.plate.picture.picture_write import in_display_window
from heatlens.plate.plate import FloatImage, Plate


class ShownPictures:
    """Display pictures over black, all in the size of the display window.

    Players show the display window: overscan is cut off, and frames of which the renderer wrote
    only a part are completed.
    """

    def __init__(self, ctx: moderngl.Context, look: Look) -> None:
        self._ctx = ctx
        self._look = look
        self._pass = DisplayPass(ctx)
        self._pass.set_transform(look.transform)
        self._out: moderngl.Texture | None = None
        nothing = np.zeros((1, 1, 3), np.float32)
        self._black = look.transform.apply_cpu(nothing, look.exposure_stops, look.gamma)[0, 0]

    def of(self, picture: moderngl.Texture, plate: Plate, proxy: float) -> FloatImage:
        """Return display values (H, W, 3) of `picture`, which is `plate` rendered at `proxy`."""
        out = self._texture(picture.size)
        self._pass.run(picture, out, self._look.exposure_stops, self._look.gamma)
        shown = download(out)[..., :3]
        return in_display_window(shown, plate, proxy, outside=self._black)

    def _texture(self, size: tuple[int, int]) -> moderngl.Texture:
        if self._out is None or self._out.size != size:
            if self._out is not None:
                self._out.release()
            self._out = new_texture(self._ctx, size, 4, label="display values")
        return self._out

    def release(self) -> None:
        """Delete all objects of OpenGL."""
        self._pass.release()
        if self._out is not None:
            self._out.release()
