"""A pinhole picture with several samples a pixel, and a mask of the pixels that need more.

All samples of a band of rows are drawn at once, as the pixels of a larger picture. Where the
samples of a pixel and its neighbors hardly differ, more samples would make no visible difference.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.scene_gpu.bands import Rows, view_of_samples
from heatlens.render.scene_gpu.raster import SceneRaster

_SPREAD_MAX = (
    0.04  # standard deviation of samples, relative to the light, up to which noise is invisible
)
# Farther outside the frame than the rim, a disc that reaches it spreads the light of a pixel over
# 200 and more: this standard deviation of four samples is an error of a thousandth in each.
_RIM_PX, _SPREAD_MAX_FAR = 8, 0.4
_BLACK_LIGHT = 0.01  # light that counts as black
LARGER = 2  # size of a band, relative to one with a single sample a pixel


@dataclass(frozen=True)
class Antialiased:
    """An antialiased picture.

    mean  RGBA float32
    done  R, 1 in pixels that need no more samples
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
        self._side_max_px = ctx.limits.texture_side_px
        self._key: object = None  # identifies the picture in memory

    def release(self) -> None:
        """Release everything on the GPU."""
        self._mean_program.release()
        self._done_program.release()
        self._pool.release()

    # Each pixel gets four samples. Where these differ from each other or from their neighbors,
    # `peel.py` adds 48 samples in three draws; a mask in the depth buffer excludes other pixels.
    def steps(
        self, view: SceneView, across: int, fine: int, margin_px: int, key: object
    ) -> Iterator[str]:
        """Draw `across` x `across` samples a pixel, or fewer if they do not fit into a texture.

        Each step draws a band; `picture` is complete at the end. `fine` pixels of the view, each
        way, make one pixel of the picture, and `margin_px` of them on every side are no part of
        the frame. The caller passes equal keys only for an equal scene and
        view; a picture with an equal key is not drawn again.
        """
        across = max(1, min(across, self._side_max_px // view.size[0]))
        key = key, view.size, across
        if key == self._key:
            return
        self._key = None  # the picture in memory is incomplete until the last step
        for rows in self._raster.bands.of_samples(view.size, across, LARGER):
            samples = view_of_samples(view, rows, across)
            sample_texture = self._pool.texture("samples", samples.size, 4)
            for band in self._raster.bands.of(samples.size, LARGER):
                self._raster.draw(samples, sample_texture, band)
                yield "view"
            self._average(samples, sample_texture, view.size, rows)
        picture = self.picture(view.size)
        self._done_program.dispatch(
            pixel_groups(view.size),
            textures={"spread_tx": self._pool.texture("spread", view.size, 2, "f2")},
            images={"out_done_img": picture.done},
            uniforms={
                "spread_max": _SPREAD_MAX,
                "reach": fine - 1,
                "margin_px": max(0, margin_px - _RIM_PX * fine),
                "spread_max_far": _SPREAD_MAX_FAR,
            },
        )
        self._key = key

    def picture(self, size: tuple[int, int]) -> Antialiased:
        """Return the picture of this size that the last steps have drawn."""
        mean = self._pool.texture("mean", size, 4)
        return Antialiased(mean, self._pool.texture("done", size, 1, "f2"))

    def _average(
        self, samples: SceneView, sample_texture: Texture, size: tuple[int, int], rows: Rows
    ) -> None:
        """Write the mean and the spread of the samples of each pixel of some rows.

        `samples` is the view that was drawn, and `size` that of the whole picture in pixels.
        """
        self._mean_program.dispatch(
            pixel_groups((size[0], samples.size[1] // samples.across)),
            textures={"samples_tx": sample_texture},
            images={
                "mean_img": self._pool.texture("mean", size, 4),
                "out_spread_img": self._pool.texture("spread", size, 2, "f2"),
            },
            uniforms={
                "across": samples.across,
                "first_row": rows[0],
                "end_row": min(rows[1], size[1]),
                "black_light": _BLACK_LIGHT,
            },
        )
