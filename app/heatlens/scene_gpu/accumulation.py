"""Depth of field by accumulation: the mean of what many points of the lens see.

Haeberli and Akeley 1990. It blurs what a pinhole never saw, and is right where the others guess;
its price is that the scene is drawn once for each point.
"""

from collections.abc import Iterator
from dataclasses import replace

import moderngl

from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.gpu.textures import TexturePool
from heatlens.model.aperture import Pupil
from heatlens.scene.scene_view import SceneView
from heatlens.scene_gpu.lens_samples import lens_samples
from heatlens.scene_gpu.raster import SceneRaster


class Accumulation:
    """Keeps the sum of the views so far, so that more views cost only the new ones."""

    def __init__(self, ctx: moderngl.Context, raster: SceneRaster) -> None:
        self._raster = raster
        self._program = ComputeProgram(ctx, "accumulate.comp.glsl")
        self._pool = TexturePool(ctx)
        self._key: tuple[object, tuple[int, int]] | None = None
        self._count = 0

    def release(self) -> None:
        """Give everything back to OpenGL."""
        self._program.release()
        self._pool.release()

    def steps(
        self,
        view: SceneView,
        pupil: Pupil,
        views: int,
        out: moderngl.Texture,
        key: object,
    ) -> Iterator[str]:
        """Render the mean of `views` views through `pupil` into `out`.

        `out` is RGBA of the view's size, half or float32. It holds the mean so far after each step
        called "view"; the steps before it are called "band". Equal keys promise equal light from
        the scene, view and lens, and a sum for an equal key is continued. If fewer views are asked
        for than were summed, the sum starts again, so that the picture depends on their number
        alone. A pupil of radius 0 gives the antialiased picture of a pinhole.
        """
        if self._key != (key, view.size) or self._count > views:
            self._key, self._count = (key, view.size), 0
        if self._count == views:
            self._add(out, is_new=False)
            return
        offsets, jitters = lens_samples(self._count, views, pupil)
        for (u, v), (x, y) in zip(offsets.tolist(), jitters.tolist(), strict=True):
            number = self._count
            through = replace(view, offset_m=(u, v), jitter_px=(x, y), sample=number)
            drawn, bands = (
                self._pool.texture("view", view.size, 4),
                self._raster.bands.of(view.size),
            )
            for band in bands:
                self._raster.draw(through, drawn, band)
                if band is not bands[-1]:
                    yield "band"
            self._add(out, is_new=True)
            yield "view"

    def _add(self, out: moderngl.Texture, is_new: bool) -> None:
        """Add the view that was drawn last, or only write the mean again."""
        is_first = self._count == 0
        self._count += is_new
        self._program.dispatch(
            pixel_groups(out.size),
            textures={"view_tx": self._pool.texture("view", out.size, 4)},
            images={"sum_img": self._pool.texture("sum", out.size, 4), "mean_img": out},
            uniforms={"count": float(self._count), "is_first": is_first, "is_new": is_new},
        )
