"""A pinhole picture antialiased: many samples where surfaces meet, few where nothing changes.

All pixels get some samples. Those in which, and around which, these hardly differ are done; the
others go on until there are as many as wished.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import moderngl

from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.gpu.textures import Storage, TexturePool
from heatlens.model.boxes import Box
from heatlens.model.pupil import PINHOLE
from heatlens.scene.scene_view import SceneView
from heatlens.scene_gpu.lens_samples import lens_samples
from heatlens.scene_gpu.raster import SceneRaster

_FOR_ALL = 16  # views of every pixel, after which some are done
# A standard deviation of the mean that is not visible, relative to the light and to what counts as
# black: one percent of the light is about a step of 8 bits.
_MOST, _DARKEST = 0.01, 0.01


@dataclass
class _Progress:
    """How far a picture is done."""

    key: object
    size: tuple[int, int]
    views: int = 0  # that all bands have
    bands: int = 0  # that have one more
    has_done: bool = False  # it is known which pixels are done


class Antialias:
    """Keeps the sum of the samples so far, so that more samples cost only the new ones."""

    def __init__(self, ctx: moderngl.Context, raster: SceneRaster) -> None:
        self._raster = raster
        self._add_program = ComputeProgram(ctx, "antialias_add.comp.glsl")
        self._done_program = ComputeProgram(ctx, "antialias_done.comp.glsl")
        self._mean_program = ComputeProgram(ctx, "antialias_mean.comp.glsl")
        self._pool = TexturePool(ctx)
        self._progress = _Progress(None, (0, 0))

    def release(self) -> None:
        """Give everything back to OpenGL."""
        for program in (self._add_program, self._done_program, self._mean_program):
            program.release()
        self._pool.release()

    def steps(
        self, view: SceneView, views: int, out: moderngl.Texture, key: object
    ) -> Iterator[str]:
        """Render the mean of at most `views` samples a pixel into `out`, RGBA of the view's size.

        Equal keys promise equal light from the scene and view, and a sum for an equal key is
        continued, even if its steps were abandoned. If fewer views are asked for than were summed,
        the sum starts again, so that the picture depends on their number alone. A step draws one
        band of one view.
        """
        now = self._progress
        if (now.key, now.size) != (key, view.size) or now.views + (now.bands > 0) > views:
            now = self._progress = _Progress(key, view.size)
        _, jitters = lens_samples(0, views, PINHOLE)
        bands = self._raster.bands.of(view.size)
        while now.views < views:
            self._look(now)
            x, y = jitters[now.views].tolist()
            sample = replace(view, jitter_px=(x, y), sample=now.views)
            self._sample(sample, bands[now.bands])
            now.bands += 1
            if now.bands == len(bands):
                now.views, now.bands = now.views + 1, 0
            yield "view"
        self._mean(out)
        yield "mean"

    def _texture(self, name: str, components: int) -> moderngl.Texture:
        storage: Storage = "f4" if components == 4 else "f2"
        return self._pool.texture(name, self._progress.size, components, storage)

    def _look(self, now: _Progress) -> None:
        """Find the finished pixels once all of them have had their views."""
        if now.has_done or now.views < _FOR_ALL:
            return
        now.has_done = True
        self._done_program.dispatch(
            pixel_groups(now.size),
            textures={"sum_tx": self._texture("sum", 4)},
            images={"out_done_img": self._texture("done", 1)},
            uniforms={"views": float(now.views), "most": _MOST, "darkest": _DARKEST},
        )

    def _sample(self, view: SceneView, band: Box) -> None:
        """Draw one more view of a band for the pixels that are not finished."""
        now, drawn, done = self._progress, self._texture("view", 4), self._texture("done", 1)
        self._raster.draw(view, drawn, band, done if now.has_done else None)
        self._add_program.dispatch(
            pixel_groups((band.width, band.height)),
            textures={"view_tx": drawn, "done_tx": done},
            images={"sum_img": self._texture("sum", 4)},
            uniforms={"first_row": band.y0, "is_first": now.views == 0, "has_done": now.has_done},
        )

    def _mean(self, out: moderngl.Texture) -> None:
        now = self._progress
        self._mean_program.dispatch(
            pixel_groups(now.size),
            textures={"sum_tx": self._texture("sum", 4), "done_tx": self._texture("done", 1)},
            images={"mean_img": out},
            uniforms={"views": float(now.views), "has_done": now.has_done},
        )
