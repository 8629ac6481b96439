"""Draw preview levels as the window does at 1:1: enlarged, with the plate's focused detail."""

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from heatlens.defocus.plate_passes import ProxyPass
from heatlens.display.display_pass import DisplayPass
from heatlens.display.enlarge_pass import EnlargePass
from heatlens.display.picture_pass import Detail, PicturePass, PlacedPicture
from heatlens.gpu.textures import TexturePool
from heatlens.model.boxes import Box
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer

Shown = NDArray[np.float32]


@dataclass(eq=False)
class DragView:
    """Owns a screen as large as the picture at rest, in the plain sRGB curve."""

    renderer: FrameRenderer
    size: tuple[int, int]

    def __post_init__(self) -> None:
        ctx = self.renderer.ctx
        self._pool = TexturePool(ctx)
        self._display, self._enlarge = DisplayPass(ctx), EnlargePass(ctx)
        self._proxy, self._laying = ProxyPass(ctx), PicturePass(ctx)
        self._out = ctx.texture(self.size, 4)
        self._screen = ctx.framebuffer([self._out])
        # Bound when the screen goes: moderngl would bind the window's, and there may be none.
        self._rest = ctx.simple_framebuffer((1, 1))
        self._held: list[moderngl.Texture] = []

    def at_rest(self, picture: moderngl.Texture) -> Shown:
        """Return the whole picture as on the screen, (H, W, 3), 0 to 1."""
        return self._on_screen(self._shown(picture), None)

    def moving(self, picture: moderngl.Texture, shot: Shot, rest_proxy: float) -> Shown:
        """Return a level's `picture` of `shot` as it is shown while dragging."""
        proxy = shot.defocus.proxy
        if proxy >= rest_proxy:
            return self.at_rest(picture)
        return self._on_screen(self._enlarged(picture), self._detail(shot, rest_proxy))

    def _detail(self, shot: Shot, rest_proxy: float) -> Detail:
        loaded, proxy = self.renderer.loaded, shot.defocus.proxy
        plate = self._shown(self._small(self.size) if rest_proxy < 1.0 else loaded.color)
        sides = (max(1, round(side * proxy / rest_proxy)) for side in self.size)
        width, height = sides
        coarse = self._enlarged(self._small((width, height)))
        optics = self.renderer.optics(shot)
        return Detail(plate, coarse, loaded.depth, optics.line, 1.0 / proxy)

    def _small(self, size: tuple[int, int]) -> moderngl.Texture:
        loaded = self.renderer.loaded
        color = self._pool.texture(f"small plate {size}", size, 4)
        depth = self._pool.texture("small depth", size, 1)
        self._proxy.run(loaded.color, loaded.depth, 1.0, color, depth)
        return color

    def _new(self, size: tuple[int, int]) -> moderngl.Texture:
        texture = self.renderer.ctx.texture(size, 4)
        texture.repeat_x = texture.repeat_y = False
        self._held.append(texture)
        return texture

    def _shown(self, picture: moderngl.Texture) -> moderngl.Texture:
        out = self._new(picture.size)
        self._display.run(picture, out)
        out.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return out

    def _enlarged(self, picture: moderngl.Texture) -> moderngl.Texture:
        shown = self._pool.texture("shown small", picture.size, 4, "f2")
        self._display.run(picture, shown)
        out = self._new(picture.size)
        self._enlarge.run(shown, out)
        out.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return out

    def _on_screen(self, picture: moderngl.Texture, detail: Detail | None) -> Shown:
        width, height = self.size
        corners = (0.0, 0.0), (float(width), float(height))
        is_whole = detail is None
        placed = PlacedPicture(picture, *corners, Box(0, 0, width, height), is_whole, True, detail)
        self._laying.run([placed], self._screen, self.size)
        while self._held:
            self._held.pop().release()
        pixels = np.frombuffer(self._screen.read(components=3), np.uint8)
        return (pixels.reshape(height, width, 3)[::-1] / np.float32(255)).astype(np.float32)

    def release(self) -> None:
        """Delete all GPU objects except the framebuffer that stays bound."""
        self._rest.use()
        self._screen.release()
        self._out.release()
        self._pool.release()
        self._display.release()
