"""What lies behind the picture of a scene, as the fragment lists that deep files are read into.

The scene is drawn in bands at several samples a pixel, and behind what is seen the next two
surfaces. A pass makes a list of each pixel: surfaces near to far with the part of the pixel that
they cover. Scratch is bounded by the size of a band; nothing is read back but a count.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.gpu.textures import TexturePool
from heatlens.model.value_bins import ValueBins
from heatlens.plate.fragments import FragmentLists
from heatlens.scene.scene_view import SceneView
from heatlens.scene_gpu.depth_survey import DepthSurvey
from heatlens.scene_gpu.overscan import Overscan
from heatlens.scene_gpu.raster import SceneRaster
from heatlens.scene_gpu.surface_raster import SurfaceRaster

_FRONT_SIDE, _BEHIND_SIDE = 4, 2  # samples across a pixel of what is seen, and of what is behind,
_BEHIND_SIDE_FINE = 1  # where pixels are finer than those of the picture
_SAMPLES_MOST = 1 << 21  # of a band
_A_PIXEL = 2.0  # fragments that there is room for, on average
_FRAGMENT_BYTES = 12


@dataclass(frozen=True, eq=False)
class Peeled:
    """The lists of a picture.

    fragments   of all of its pixels
    places      RGBA: where in each pixel its light stands, see peel_lists.comp.glsl
    bins        dioptres of what is seen and of what is behind it
    count       fragments that were found, and `capacity`, that there is room for
    """

    fragments: FragmentBuffers
    places: moderngl.Texture
    bins: ValueBins
    count: int
    capacity: int

    def read(self) -> FragmentLists:
        """Return the lists from the GPU."""
        starts = np.frombuffer(self.fragments.starts.read(), np.uint32)
        pixels = self.fragments.size[0] * self.fragments.size[1]
        size = _FRAGMENT_BYTES * min(self.count, self.capacity)
        words = np.frombuffer(self.fragments.words.read(size) if size else b"", np.uint32)
        return FragmentLists(starts[: pixels + 1], words.reshape(-1, 3), is_measured=True)


class ScenePeel:
    """Makes the lists of one picture after the other, each in the same memory."""

    def __init__(self, ctx: moderngl.Context, raster: SceneRaster, survey: DepthSurvey) -> None:
        self._ctx = ctx
        self._raster, self._survey = raster, survey
        self._surfaces = SurfaceRaster(ctx, raster)
        self._count = ComputeProgram(ctx, "peel_lists.comp.glsl", {"COUNT": 1})
        self._starts = ComputeProgram(ctx, "peel_starts.comp.glsl")
        self._write = ComputeProgram(ctx, "peel_lists.comp.glsl")
        self._total = ctx.buffer(reserve=4)
        self._pool = TexturePool(ctx)

    def steps(
        self,
        view: SceneView,
        picture: Overscan,
        place: Callable[[], None],
    ) -> Generator[str, None, Peeled]:
        """Make the lists of a picture in steps; return them at the end.

        `view` is that of the picture, whose depth becomes that of the nearest fragment where
        several are seen in a pixel. `place` puts the scene in its place, where others may have
        moved it between two steps.
        """
        width, height = view.size
        color, depth, nearest = picture.color, picture.depth, float(picture.bins.high)
        behind_side = _BEHIND_SIDE if picture.fine == 1 else _BEHIND_SIDE_FINE
        side = max(1, min(_FRONT_SIDE, int(self._ctx.info["GL_MAX_TEXTURE_SIZE"]) // width))
        rows = max(1, min(height, _SAMPLES_MOST // (side * side * width)))
        starts = self._pool.buffer("starts", 4 * (width * height + 1))
        limit = int(self._ctx.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]) // _FRAGMENT_BYTES
        capacity = min(int(_A_PIXEL * width * height), limit)
        words = self._pool.buffer("words", _FRAGMENT_BYTES * capacity)
        places = self._pool.texture("places", view.size, 4, "f2")
        self._total.write(np.zeros(1, np.uint32))
        for first in range(0, height, rows):
            place()
            samples = self._samples(view, first, rows, (side, behind_side))
            band = first, min(first + rows, height)
            self._list(
                samples, band, (side, behind_side), (color, depth, places), starts, words, capacity
            )
            yield "behind"
        count = int(np.frombuffer(self._total.read(), np.uint32)[0])
        bins = self._survey.with_fragments(depth, words, min(count, capacity), nearest)
        fragments = FragmentBuffers(starts, words, view.size, False, is_exact=True)
        return Peeled(fragments, places, bins, count, capacity)

    def _samples(
        self, view: SceneView, first: int, rows: int, sides: tuple[int, int]
    ) -> dict[str, moderngl.Texture]:
        """Draw a band, and return the textures by the names of lib/surface_groups.lib.glsl."""
        seen, behind = (_band_view(view, first, rows, side) for side in sides)
        drawn = {
            "front_tx": self._pool.texture("front", seen.size, 4),
            "first_tx": self._pool.texture("first", behind.size, 1),
            "behind_tx": self._pool.texture("behind", behind.size, 4),
            "last_tx": self._pool.texture("last", behind.size, 4),
        }
        self._surfaces.front(seen, drawn["front_tx"])
        self._raster.depth(behind, drawn["first_tx"])
        self._surfaces.behind(behind, drawn["first_tx"], drawn["behind_tx"])
        self._surfaces.behind(behind, drawn["behind_tx"], drawn["last_tx"])
        return drawn

    def _list(
        self,
        samples: dict[str, moderngl.Texture],
        band: tuple[int, int],
        sides: tuple[int, int],
        picture: tuple[moderngl.Texture, moderngl.Texture, moderngl.Texture],
        starts: moderngl.Buffer,
        words: moderngl.Buffer,
        capacity: int,
    ) -> None:
        """Count, place and write the lists of the rows of a band."""
        (first, end), (color, depth, places) = band, picture
        groups = pixel_groups((color.width, end - first))
        textures = samples | {"color_tx": color}
        uniforms = {"first_row": first, "end_row": end}
        uniforms |= {"front_side": sides[0], "behind_side": sides[1]}
        kept = {"start_block": starts}
        self._count.dispatch(groups, textures=textures, buffers=kept, uniforms=uniforms)
        self._starts.dispatch(
            (1, 1),
            buffers=kept | {"total_block": self._total},
            uniforms={
                "first_pixel": first * color.width,
                "pixel_count": (end - first) * color.width,
                "capacity": capacity,
            },
        )
        self._write.dispatch(
            groups,
            textures=textures,
            images={"out_depth_img": depth, "out_place_img": places},
            buffers=kept | {"fragment_block": words},
            uniforms=uniforms,
        )

    def release(self) -> None:
        """Give everything back to OpenGL."""
        programs = self._count, self._starts, self._write
        for held in (*programs, self._total, self._surfaces, self._pool):
            held.release()


def _band_view(view: SceneView, first: int, rows: int, side: int) -> SceneView:
    """Return the view of some rows of a picture, `side` times as large."""
    width, height = view.size
    below_px = first + rows / 2 - height / 2
    return replace(
        view,
        size=(side * width, side * rows),
        focal_px=side * view.focal_px,
        jitter_px=(0.0, side * below_px),
        sample=0,  # the pixels of this view are the samples, and differ by their places
    )
