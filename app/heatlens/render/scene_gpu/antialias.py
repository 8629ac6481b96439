"""A pinhole picture with several samples a pixel, and a mask of the pixels that need more.

All samples of a band of rows are drawn at once, as the pixels of a larger picture. Where the
samples of a pixel and its neighbours hardly differ, more samples would make no visible difference.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device, Texture
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.scene_gpu.bands import Rows, samples_of
from heatlens.render.scene_gpu.raster import SceneRaster

# The standard deviation of samples up to which their mean shows no noise, relative to the light,
# and the light that counts as black.
_MOST, _DARKEST = 0.04, 0.01
LARGER = 1  # size of a band, relative to one with a single sample a pixel


@dataclass(frozen=True)
class Antialiased:
    """The picture.

    mean  RGBA float32
    done  R, 1 where it needs no more samples
    """

    mean: Texture
    done: Texture


class Antialias:
    """Draws pictures one after the other, each in the same memory."""

    def __init__(self, ctx: Device, raster: SceneRaster) -> None:
        self._raster = raster
        self._mean_program = ComputeProgram(ctx, "scene_gpu/antialias_mean.comp.glsl")
        self._done_program = ComputeProgram(ctx, "scene_gpu/antialias_done.comp.glsl")
        self._pool = TexturePool(ctx)
        self._most_px = ctx.limits.texture_side_px
        self._key: object = None  # identifies the picture in memory

    def release(self) -> None:
        """Release everything on the GPU."""
        self._mean_program.release()
        self._done_program.release()
        self._pool.release()

    # Every pixel had 64 samples at first, then 16, and 48 more where these differed. It is four
    # now, and where they differ from each other or from their neighbours, 48 more in three draws
    # (`peel.py`). A mask in the depth buffer sees to it that no other pixel is drawn again.
    def steps(self, view: SceneView, across: int, fine: int, key: object) -> Iterator[str]:
        """Draw `across` x `across` samples a pixel, or fewer if they do not fit into a texture.

        Each step draws a band; `picture` is complete at the end. `fine` pixels of the view, each
        way, make one pixel on the screen. The caller passes equal keys only for an equal scene and
        view; a picture with an equal key is not drawn again.
        """
        across = max(1, min(across, self._most_px // view.size[0]))
        key = key, view.size, across
        if key == self._key:
            return
        self._key = None
        for rows in self._raster.bands.of_samples(view.size, across, LARGER):
            samples = samples_of(view, rows, across)
            drawn = self._pool.texture("samples", samples.size, 4)
            for band in self._raster.bands.of(samples.size, LARGER):
                self._raster.draw(samples, drawn, band)
                yield "view"
            self._average(samples, drawn, view.size, rows)
        picture = self.picture(view.size)
        self._done_program.dispatch(
            pixel_groups(view.size),
            textures={"spread_tx": self._pool.texture("spread", view.size, 2, "f2")},
            images={"out_done_img": picture.done},
            uniforms={"most": _MOST, "reach": fine},
        )
        self._key = key

    def picture(self, size: tuple[int, int]) -> Antialiased:
        """Return the picture of this size that the last steps have drawn."""
        mean = self._pool.texture("mean", size, 4)
        return Antialiased(mean, self._pool.texture("done", size, 1, "f2"))

    def _average(
        self, samples: SceneView, drawn: Texture, size: tuple[int, int], rows: Rows
    ) -> None:
        self._mean_program.dispatch(
            pixel_groups((size[0], samples.size[1] // samples.across)),
            textures={"samples_tx": drawn},
            images={
                "mean_img": self._pool.texture("mean", size, 4),
                "out_spread_img": self._pool.texture("spread", size, 2, "f2"),
            },
            uniforms={
                "across": samples.across,
                "first_row": rows[0],
                "end_row": min(rows[1], size[1]),
                "darkest": _DARKEST,
            },
        )
