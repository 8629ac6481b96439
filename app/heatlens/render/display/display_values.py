"""Display values of whole pictures for files, from the shader that also draws the window."""

from heatlens.media.color.view_transform import ViewTransform
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import FloatArray, download, new_texture, upload


class DisplayValues:
    """Converts scene-linear pictures to display values, over black, on the thread that draws.

    Every file with display values gets them here: `heatlens render`, an export and the window show
    the same picture. OpenColorIO on the CPU rounds differently.
    """

    def __init__(
        self, ctx: Device, transform: ViewTransform, exposure_stops: float = 0.0, gamma: float = 1.0
    ) -> None:
        self._ctx = ctx
        self._view = (exposure_stops, gamma)
        self._pass = DisplayPass(ctx)
        self._pass.set_transform(transform)
        self._out: Texture | None = None

    def of(self, picture: Texture) -> FloatArray:
        """Return display values (H, W, 3) of `picture`, premultiplied RGB or RGBA."""
        out = self._output_texture(picture.size)
        self._pass.run(picture, out, *self._view)
        return download(out)[..., :3]

    def encode(self, light: FloatArray) -> FloatArray:
        """Return display values (H, W, 3) of `light`, (H, W, 3) scene-linear."""
        picture = new_texture(self._ctx, light.shape[1::-1], 3, label="light to show")
        try:
            upload(picture, light)
            return self.of(picture)
        finally:
            picture.release()

    def _output_texture(self, size: tuple[int, int]) -> Texture:
        """Return the texture for the result, made again if the size changes."""
        if self._out is None or self._out.size != size:
            if self._out is not None:
                self._out.release()
            self._out = new_texture(self._ctx, size, 4, label="display values")
        return self._out

    def release(self) -> None:
        """Delete the pass and its texture."""
        self._pass.release()
        if self._out is not None:
            self._out.release()
