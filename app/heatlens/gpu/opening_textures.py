"""The images of openings on the GPU; each is uploaded once, not for every picture."""

import moderngl
import numpy as np

from heatlens.gpu.textures import new_texture
from heatlens.model.lens.aperture import Aperture

_KEPT = 4  # enough for four looks side by side


class OpeningTextures:
    """Textures for lib/opening_image.lib.glsl, of the most recently used openings."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._held: dict[object, moderngl.Texture] = {}

    def of(self, aperture: Aperture) -> dict[str, moderngl.Texture]:
        """Return the textures by their names in the shader; none for an opening without an image.

        Raises LensError if the file of the image was not read.
        """
        grid = aperture.grid
        if grid is None:
            return {}
        key = (aperture.aperture_image, aperture.blade_rotation_deg)
        texture = self._held.pop(key, None)
        if texture is None:
            side = len(grid.sums)
            texture = new_texture(self._ctx, (side, side), 1, "u4", "opening")
            texture.write(np.ascontiguousarray(grid.sums, np.uint32).tobytes())
        self._held[key] = texture  # the latest is last
        while len(self._held) > _KEPT:
            self._held.pop(next(iter(self._held))).release()
        return {"aperture_image_tx": texture}

    def release(self) -> None:
        """Release everything on the GPU."""
        for texture in self._held.values():
            texture.release()
        self._held.clear()
