"""Surfaces of a scene: what is seen, and then what lies behind a surface drawn before."""

import moderngl

from heatlens.scene.scene_view import SceneView
from heatlens.scene_gpu.mesh_draw import MeshDraw
from heatlens.scene_gpu.raster import SceneRaster, SkyDraw, eye_uniforms

_PEEL = {"PEEL": 1}


class SurfaceRaster:
    """Draws colour and dioptres into one texture: RGBA float32, whose alpha is 0 for the sky."""

    def __init__(self, ctx: moderngl.Context, raster: SceneRaster) -> None:
        self._raster = raster
        self._cover = MeshDraw(ctx, raster.buffers, "scene_cover", _PEEL)
        self._surface = MeshDraw(ctx, raster.buffers, "scene_surface", _PEEL)
        self._sky = SkyDraw(ctx, _PEEL)

    def front(self, view: SceneView, out: moderngl.Texture, done: moderngl.Texture) -> None:
        """Draw what is seen, but nothing in the pixels where `done`, R, is not 0.

        The view takes its rows of `out`, which is cleared before the first of them.
        """
        target = self._raster.target_of(out)
        if view.rows_above == 0:
            target.clear()
        target.viewport = 0, view.rows_above, *view.size
        target.use()
        self._raster.hide(target, view, done)
        self._raster.draw_into(target, view, self._raster.cover, self._surface, self._sky)
        target.viewport = 0, 0, *out.size

    def behind(self, view: SceneView, before: moderngl.Texture, out: moderngl.Texture) -> None:
        """Draw the next surface behind `before`, which `front` or this drew, or metres (R).

        The backs of closed meshes are left out. Behind the sky there is the sky once more.
        """
        self._raster.buffers.tell_backs(view.eye_m)
        target = self._raster.target_of(out)
        target.use()
        target.clear()
        peeled = eye_uniforms(view) | {"before_is_depth": before.components == 1}
        self._raster.draw_into(
            target, view, self._cover, self._surface, self._sky, peeled, {"before_tx": before}
        )

    def release(self) -> None:
        """Release the programs."""
        for held in (self._cover, self._surface, self._sky):
            held.release()
