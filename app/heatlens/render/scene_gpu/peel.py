"""List the surfaces behind the picture of a scene, in the same form as for deep files.

The scene is drawn in bands: the visible surface, with more samples in pixels that need them
(antialias.py), and the next two surfaces behind it. A pass makes a list for each pixel: surfaces
from near to far with the share of the pixel that they cover. Where there are many samples the
picture becomes their mean, so that picture and lists agree. Scratch memory is limited by the size
of a band; only a count is read back.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.core.model.value_bins import ValueBins
from heatlens.media.plate.fragments import FragmentLists
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.gpu.device import Buffer, Device, Texture
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.shader_constants import PEEL_DRAWS
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.scene_gpu.bands import Rows, samples_of
from heatlens.render.scene_gpu.depth_survey import DepthSurvey
from heatlens.render.scene_gpu.mesh_draw import MeshDraw
from heatlens.render.scene_gpu.overscan import Overscan
from heatlens.render.scene_gpu.raster import SceneRaster, SkyDraw, eye_uniforms

_PEEL = {"PEEL": 1}


class SurfaceRaster:
    """Draws colour and dioptres into one texture: RGBA float32, whose alpha is 0 for the sky."""

    def __init__(self, ctx: Device, raster: SceneRaster) -> None:
        self._raster = raster
        self._cover = MeshDraw(ctx, raster.buffers, "scene_gpu/scene_cover", _PEEL)
        self._surface = MeshDraw(ctx, raster.buffers, "scene_gpu/scene_surface", _PEEL)
        self._sky = SkyDraw(ctx, _PEEL)

    def front(self, view: SceneView, out: Texture, done: Texture, band: Box) -> None:
        """Draw the visible surfaces of a band, except in pixels where `done`, R, is not 0.

        The view takes its rows of `out`, which is cleared before the first of them.
        """
        target = self._raster.targets.of(out)
        if view.rows_above == band.y0 == 0:
            target.clear()
        target.viewport = 0, view.rows_above, *view.size
        with self._raster.within(target, band, view.rows_above):
            self._raster.hide(target, view, done)
            self._raster.draw_into(target, view, self._raster.cover, self._surface, self._sky)
        target.viewport = 0, 0, *out.size

    def behind(self, view: SceneView, before: Texture, out: Texture, band: Box) -> None:
        """Draw the next surface behind `before`: a texture of `front` or `behind`, or metres (R).

        The backs of closed meshes are left out. Behind the sky comes the sky again.
        """
        self._raster.buffers.tell_backs(view.eye_m)
        peeled = eye_uniforms(view) | {"before_is_depth": before.components == 1}
        with self._raster.within(self._raster.targets.of(out), band) as target:
            target.clear()
            self._raster.draw_into(
                target, view, self._cover, self._surface, self._sky, peeled, {"before_tx": before}
            )

    def release(self) -> None:
        for held in (self._cover, self._surface, self._sky):
            held.release()


# Samples across a pixel of the picture: of the visible surface in each of several draws, and of the
# surfaces behind it.
FRONT_SIDE, _BEHIND_SIDE = 4, 2
# Shift of each draw in sample distances: no two draws share a row or a column, so that axis-aligned
# edges are resolved as finely as others.
_SHIFTS = ((-1 / 3, 0.0), (0.0, 1 / 3), (1 / 3, -1 / 3))
STEPS_OF_BAND = PEEL_DRAWS + 3
SAMPLES = PEEL_DRAWS * FRONT_SIDE**2  # in a pixel that needs all of them
LARGER = 4  # size of a band on a processor: most of its pixels are done already
_A_PIXEL = 2.0  # initial room for fragments, per pixel on average
_ROOM = 1.1  # room for the next picture, relative to the last one
_FRAGMENTS_MOST = 1 << 26  # fragments of a picture: 800 MB
_FRAGMENT_BYTES = 12


@dataclass(frozen=True, eq=False)
class Peeled:
    """The lists of a picture.

    fragments   of all pixels
    depth       R, metres of the picture, or of the nearest surface if the list begins with that
    places      RGBA: where the light is within each pixel, see peel_lists.comp.glsl
    bins        dioptres of the visible surfaces and of those behind them
    count       fragments that were found, and `capacity`, how many fit
    """

    fragments: FragmentBuffers
    depth: Texture
    places: Texture
    bins: ValueBins
    count: int
    capacity: int

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences for the user about lists that were cut short."""
        left_out = self.count - self.capacity
        if left_out <= 0:
            return ()
        return (
            f"Memory for surfaces behind the picture ran out: {left_out} of {self.count} were left "
            "out, and at the bottom of the picture they are guessed. Use a smaller --size.",
        )

    def read(self) -> FragmentLists:
        starts = np.frombuffer(self.fragments.starts.read(), np.uint32)
        pixels = self.fragments.size[0] * self.fragments.size[1]
        size = _FRAGMENT_BYTES * min(self.count, self.capacity)
        words = np.frombuffer(self.fragments.words.read(size) if size else b"", np.uint32)
        return FragmentLists(starts[: pixels + 1], words.reshape(-1, 3), is_measured=True)


@dataclass(frozen=True)
class _Room:
    """Memory for lists."""

    starts: Buffer
    words: Buffer
    depth: Texture
    places: Texture
    capacity: int


class ScenePeel:
    """Makes the lists of successive pictures in the same two banks of memory."""

    def __init__(self, ctx: Device, raster: SceneRaster, survey: DepthSurvey) -> None:
        self._ctx = ctx
        self._raster, self._survey = raster, survey
        self._surfaces = SurfaceRaster(ctx, raster)
        self._count = ComputeProgram(ctx, "scene_gpu/peel_lists.comp.glsl", {"COUNT": 1})
        self._starts = ComputeProgram(ctx, "defocus/peel_starts.comp.glsl")
        self._write = ComputeProgram(ctx, "scene_gpu/peel_lists.comp.glsl")
        self._total = ctx.buffer(reserve=4)
        self._pool = TexturePool(ctx)
        self._a_pixel = _A_PIXEL

    # How many surfaces lie behind a picture is known only when they have been drawn. Room for two a
    # pixel is taken at first, and a picture that needs more is drawn again with what it counted, up
    # to 800 MB; what is beyond is left out and told.
    def steps(
        self,
        view: SceneView,
        picture: Overscan,
        done: Texture,
        place: Callable[[], None],
        bank: int,
    ) -> Generator[str, None, Peeled]:
        """Make the lists of a picture in steps; return them at the end.

        `view` is that of the picture. Where `done` is 0, the colour becomes the mean of the samples
        drawn. `place` puts the scene back in its place, because others may move it between two
        steps. Lists in the other `bank` stay as they are.
        """
        out = self._room(view.size, bank)
        sides = self._sides(view.size[0], picture.fine)
        self._total.write(np.zeros(1, np.uint32))
        for rows in self._raster.bands.of_samples(view.size, sides[0], LARGER):
            samples = yield from self._samples(view, rows, sides, done, place)
            self._list(samples, rows, sides, picture, out)
            yield "behind"
        count = int(np.frombuffer(self._total.read(), np.uint32)[0])
        if count > out.capacity and self._makes_room(count, view.size):
            return (yield from self.steps(view, picture, done, place, bank))
        nearest, most = float(picture.bins.high), min(count, out.capacity)
        bins = self._survey.with_fragments(out.depth, out.words, most, nearest)
        fragments = FragmentBuffers(out.starts, out.words, view.size, False, is_exact=True)
        return Peeled(fragments, out.depth, out.places, bins, count, out.capacity)

    def _makes_room(self, count: int, size: tuple[int, int]) -> bool:
        """Make room for more fragments; return False if the limit is reached."""
        before = self._capacity(size)
        self._a_pixel = _ROOM * count / (size[0] * size[1])
        return self._capacity(size) > before

    def _capacity(self, size: tuple[int, int]) -> int:
        block = self._ctx.limits.storage_block_bytes // _FRAGMENT_BYTES
        return min(int(self._a_pixel * size[0] * size[1]) + 1, block, _FRAGMENTS_MOST)

    def _room(self, size: tuple[int, int], bank: int) -> _Room:
        pixels = size[0] * size[1]
        capacity = self._capacity(size)
        return _Room(
            self._pool.buffer(f"starts {bank}", 4 * (pixels + 1)),
            self._pool.buffer(f"words {bank}", _FRAGMENT_BYTES * capacity),
            self._pool.texture(f"depth {bank}", size, 1),
            self._pool.texture(f"places {bank}", size, 4, "f2"),
            capacity,
        )

    def _sides(self, width: int, fine: int) -> tuple[int, int]:
        """Return the samples across a pixel, of the visible surface and of those behind it."""
        most = max(1, self._ctx.limits.texture_side_px // width)
        return min(FRONT_SIDE // fine, most), min(_BEHIND_SIDE // fine, most)

    def _samples(
        self,
        view: SceneView,
        rows: Rows,
        sides: tuple[int, int],
        done: Texture,
        place: Callable[[], None],
    ) -> Generator[str, None, dict[str, Texture]]:
        """Draw a band, and return the textures by the names of lib/surface_groups.lib.glsl."""
        seen, behind = (samples_of(view, rows, side) for side in sides)
        width, height = seen.size
        front = self._pool.texture("front", (width, height * PEEL_DRAWS), 4)
        first = self._pool.texture("first", behind.size, 1)
        second, last = (self._pool.texture(name, behind.size, 4) for name in ("behind", "last"))
        for number, shift in enumerate(_SHIFTS):
            for band in self._raster.bands.of(seen.size, LARGER):
                place()
                self._surfaces.front(_shifted(seen, number, shift), front, done, band)
                yield "behind"
        for band in self._raster.bands.of(behind.size, LARGER):
            place()
            self._raster.depth(behind, first, band)
            for before, out in ((first, second), (second, last)):
                self._surfaces.behind(behind, before, out, band)
                yield "behind"
                place()
        named = {"first_tx": first, "behind_tx": second, "last_tx": last}
        return {"front_tx": front, "done_tx": done} | named

    def _list(
        self,
        samples: dict[str, Texture],
        rows: Rows,
        sides: tuple[int, int],
        picture: Overscan,
        out: _Room,
    ) -> None:
        """Count, place and write the lists of the rows of a band."""
        (width, height), first = picture.color.size, rows[0]
        end = min(rows[1], height)
        groups = pixel_groups((width, end - first))
        uniforms: dict[str, object] = {"first_row": first, "end_row": end}
        uniforms |= {"front_side": sides[0], "behind_side": sides[1], "shifts": _SHIFTS}
        kept, read = {"start_block": out.starts}, samples | {"depth_tx": picture.depth}
        self._count.dispatch(groups, textures=read, buffers=kept, uniforms=uniforms)
        self._starts.dispatch(
            (1, 1),
            buffers=kept | {"total_block": self._total},
            uniforms={
                "first_pixel": first * width,
                "pixel_count": (end - first) * width,
                "capacity": out.capacity,
                "has_end": True,
            },
        )
        self._write.dispatch(
            groups,
            textures=read,
            images={
                "out_color_img": picture.color,
                "out_depth_img": out.depth,
                "out_place_img": out.places,
            },
            buffers=kept | {"fragment_block": out.words},
            uniforms=uniforms,
        )

    def release(self) -> None:
        """Release everything on the GPU."""
        programs = self._count, self._starts, self._write
        for held in (*programs, self._total, self._surfaces, self._pool):
            held.release()


def _shifted(view: SceneView, number: int, shift: tuple[float, float]) -> SceneView:
    """Return the view of one of several draws into one texture, below those before it."""
    (right, down), (x, y) = view.jitter_px, shift
    moved = replace(view, jitter_px=(right + x, down + y), sample=number)
    return replace(moved, rows_above=number * view.size[1])
