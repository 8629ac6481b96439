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
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import PEEL_DRAWS, PEEL_LIST_WORDS
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.scene_gpu.bands import Rows, view_of_samples
from heatlens.render.scene_gpu.depth_survey import DepthSurvey
from heatlens.render.scene_gpu.mesh_draw import MeshDraw
from heatlens.render.scene_gpu.overscan import Overscan
from heatlens.render.scene_gpu.raster import SceneRaster, SkyDraw
from heatlens.render.scene_gpu.scene_buffers import BY_HOLES, BY_MAPS
from heatlens.render.scene_gpu.unsettled import UnsettledPixels
from heatlens.render.scene_gpu.view_uniforms import eye_uniforms

_PEEL = {"PEEL": 1}


class SurfaceRaster:
    """Draws color and dioptres into one texture: RGBA float32, whose alpha is 0 for the sky."""

    def __init__(self, ctx: Device, raster: SceneRaster) -> None:
        self._raster = raster
        self._cover = MeshDraw(ctx, raster.buffers, "scene_gpu/scene_cover", BY_HOLES, _PEEL)
        self._surface = MeshDraw(ctx, raster.buffers, "scene_gpu/scene_surface", BY_MAPS, _PEEL)
        self._sky = SkyDraw(ctx, _PEEL)

    def draw_front(self, view: SceneView, out: Texture, done: Texture, band: Box) -> None:
        """Draw the visible surfaces of a band, except in pixels where `done`, R, is not 0.

        The view takes its rows of `out`, whose depths are the farthest.
        """
        target = self._raster.targets.of(out)
        target.viewport = 0, view.rows_above, *view.size
        with self._raster.bind_band(target, view, band):
            self._raster.hide_done_pixels(target, view, done)
            self._raster.draw_into(target, view, self._raster.cover, self._surface, self._sky)
        target.viewport = 0, 0, *out.size

    def draw_behind(self, view: SceneView, previous: Texture, out: Texture, band: Box) -> None:
        """Draw into `out` the next surface behind that in `previous`, for each pixel of a band.

        `previous` is a texture of `draw_front` or `draw_behind`, or of depths in meters (R). The
        backs of closed meshes are left out. Behind the sky comes the sky again.
        """
        self._raster.buffers.write_back_rules(view.eye_m)
        peel_uniforms = eye_uniforms(view) | {"before_is_depth": previous.components == 1}
        with self._raster.bind_band(self._raster.targets.of(out), view, band) as target:
            target.clear()
            self._raster.draw_into(
                target,
                view,
                self._cover,
                self._surface,
                self._sky,
                peel_uniforms,
                {"before_tx": previous},
            )

    def release(self) -> None:
        for resource in (self._cover, self._surface, self._sky):
            resource.release()


# Samples across a pixel of the picture: of the visible surface in each of several draws, and of the
# surfaces behind it.
FRONT_SIDE, _BEHIND_SIDE = 4, 2
# Shift of each draw in sample distances: no two draws share a row or a column, so that axis-aligned
# edges are resolved as finely as others.
_SHIFTS = ((-1 / 3, 0.0), (0.0, 1 / 3), (1 / 3, -1 / 3))
STEPS_OF_BAND = PEEL_DRAWS + 3  # the draws, two surfaces behind them, and the lists
SAMPLES = PEEL_DRAWS * FRONT_SIDE**2  # in a pixel that needs all of them
LARGER = 8  # size of a band on a processor: most of its pixels are done already
_FRAGMENTS_PER_PIXEL = 2.0  # initial capacity in fragments per pixel, on average
_CAPACITY_FACTOR = 1.1  # capacity for the next picture, relative to the fragments of the last one
_FRAGMENTS_MOST = 1 << 26  # fragments of a picture: 800 MB
_FRAGMENT_BYTES = 12  # bytes of a fragment in a list


@dataclass(frozen=True, eq=False)
class Peeled:
    """The fragment lists of a picture: the surfaces along the ray of each pixel, near to far.

    fragments   the lists of all pixels
    depth       R, meters of the picture, or of the nearest surface if the list begins with that
    positions   RGBA: position of the light within each pixel, see peel_lists.comp.glsl
    bins        dioptres of the visible surfaces and of those behind them
    count       number of fragments that were found
    capacity    number of fragments that fit into memory
    """

    fragments: FragmentBuffers
    depth: Texture
    positions: Texture
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
        """Return the lists, downloaded from the GPU."""
        starts = np.frombuffer(self.fragments.starts.read(), np.uint32)
        pixels = self.fragments.size[0] * self.fragments.size[1]
        size = _FRAGMENT_BYTES * min(self.count, self.capacity)
        words = np.frombuffer(self.fragments.words.read(size) if size else b"", np.uint32)
        return FragmentLists(starts[: pixels + 1], words.reshape(-1, 3), is_measured=True)


@dataclass(frozen=True)
class _ListMemory:
    """Memory for the lists of a picture; see `FragmentBuffers` and `Peeled`."""

    starts: Buffer
    words: Buffer
    depth: Texture
    positions: Texture
    capacity: int


class ScenePeel:
    """Makes the lists of successive pictures in the same two banks of memory."""

    def __init__(self, ctx: Device, raster: SceneRaster, survey: DepthSurvey) -> None:
        self._ctx = ctx
        self._raster, self._survey = raster, survey
        self._surfaces = SurfaceRaster(ctx, raster)
        self._lists = ComputeProgram(ctx, "scene_gpu/peel_lists.comp.glsl")
        self._starts = ComputeProgram(ctx, "defocus/peel_starts.comp.glsl")
        self._pack = ComputeProgram(ctx, "scene_gpu/peel_pack.comp.glsl")
        self._total = ctx.buffer(reserve=4)
        self._pool = TexturePool(ctx)
        self._fragments_per_pixel = _FRAGMENTS_PER_PIXEL

    # The number of surfaces behind a picture is known only after they have been drawn. Memory for
    # two per pixel is allocated at first. A picture that needs more is drawn again with as much as
    # was counted, up to 800 MB; further surfaces are left out, and the notes say so.
    def steps(
        self,
        view: SceneView,
        picture: Overscan,
        done: Texture,
        place_scene: Callable[[], None],
        bank: int,
    ) -> Generator[str, None, Peeled]:
        """Make the lists of a picture in steps; return them at the end.

        `view` is that of the picture. Where `done` is 0, the color becomes the mean of the samples
        drawn. `place_scene` moves the scene back to its frame, because others may move it between
        two steps. Lists in the other `bank` stay as they are.
        """
        out = self._allocate(view.size, bank)
        sides = self._sample_sides(view.size[0], picture.fine)
        self._total.write(np.zeros(1, np.uint32))
        unsettled = UnsettledPixels(done, self._raster.bands.are_small)
        for rows in self._raster.bands.of_samples(view.size, sides[0], LARGER):
            samples = yield from self._draw_samples(view, rows, sides, unsettled, place_scene)
            self._write_lists(samples, rows, sides, picture, out)
            yield "behind"
        count = int(np.frombuffer(self._total.read(), np.uint32)[0])
        if count > out.capacity and self._grow_capacity(count, view.size):
            return (yield from self.steps(view, picture, done, place_scene, bank))
        nearest, stored = float(picture.bins.high), min(count, out.capacity)
        bins = self._survey.with_fragments(out.depth, out.words, stored, nearest)
        fragments = FragmentBuffers(
            out.starts, out.words, view.size, is_measured=False, is_exact=True
        )
        return Peeled(fragments, out.depth, out.positions, bins, count, out.capacity)

    def _grow_capacity(self, count: int, size: tuple[int, int]) -> bool:
        """Increase the capacity to `count` fragments; return False if the limit is reached."""
        previous = self._capacity(size)
        self._fragments_per_pixel = _CAPACITY_FACTOR * count / (size[0] * size[1])
        return self._capacity(size) > previous

    def _capacity(self, size: tuple[int, int]) -> int:
        """Return for how many fragments of a picture of `size` memory is allocated."""
        block = self._ctx.limits.storage_block_bytes // _FRAGMENT_BYTES
        return min(int(self._fragments_per_pixel * size[0] * size[1]) + 1, block, _FRAGMENTS_MOST)

    def _allocate(self, size: tuple[int, int], bank: int) -> _ListMemory:
        """Return the memory of a bank for the lists of a picture of `size`."""
        pixels = size[0] * size[1]
        capacity = self._capacity(size)
        return _ListMemory(
            starts=self._pool.buffer(f"starts {bank}", 4 * (pixels + 1)),
            words=self._pool.buffer(f"words {bank}", _FRAGMENT_BYTES * capacity),
            depth=self._pool.texture(f"depth {bank}", size, 1),
            positions=self._pool.texture(f"positions {bank}", size, 4, "f2"),
            capacity=capacity,
        )

    def _sample_sides(self, width: int, fine: int) -> tuple[int, int]:
        """Return the samples across a pixel, of the visible surface and of those behind it."""
        side_max = max(1, self._ctx.limits.texture_side_px // width)
        return min(FRONT_SIDE // fine, side_max), min(_BEHIND_SIDE // fine, side_max)

    def _draw_samples(
        self,
        view: SceneView,
        rows: Rows,
        sides: tuple[int, int],
        unsettled: UnsettledPixels,
        place_scene: Callable[[], None],
    ) -> Generator[str, None, dict[str, Texture]]:
        """Draw a band, and return the textures by the names of lib/surface_groups.lib.glsl.

        `sides` are the samples across a pixel, of the visible surface and of those behind it. The
        other arguments are those of `steps`.
        """
        front_view, behind_view = (view_of_samples(view, rows, side) for side in sides)
        width, height = front_view.size
        front = self._pool.texture("front", (width, height * PEEL_DRAWS), 4)
        first = self._pool.texture("first", behind_view.size, 1)
        second, third = (
            self._pool.texture(name, behind_view.size, 4) for name in ("behind", "last")
        )
        runs = [(sides[0] * x0, sides[0] * x1) for x0, x1 in unsettled.runs(rows)]
        if runs:
            self._raster.targets.of(front).clear()
        for index, shift in enumerate(_SHIFTS):
            shifted = _shift_view(front_view, index, shift)
            for band in self._raster.bands.of(front_view.size, LARGER):
                place_scene()
                for x0, x1 in runs:
                    pixels = Box(x0, band.y0, x1, band.y1)
                    self._surfaces.draw_front(shifted, front, unsettled.done, pixels)
                yield "behind"
        for band in self._raster.bands.of(behind_view.size, LARGER):
            place_scene()
            self._raster.depth(behind_view, first, band)
            for previous, out in ((first, second), (second, third)):
                self._surfaces.draw_behind(behind_view, previous, out, band)
                yield "behind"
                place_scene()
        behind_textures = {"first_tx": first, "behind_tx": second, "last_tx": third}
        return {"front_tx": front, "done_tx": unsettled.done} | behind_textures

    def _write_lists(
        self,
        samples: dict[str, Texture],
        rows: Rows,
        sides: tuple[int, int],
        picture: Overscan,
        out: _ListMemory,
    ) -> None:
        """List the fragments of the rows of a band, find the start of each list, and pack them.

        `samples` are the textures of the band, and `sides` the samples across a pixel: of the
        visible surface, and of those behind it.
        """
        (width, height), first_row = picture.color.size, rows[0]
        end_row = min(rows[1], height)
        groups = pixel_groups((width, end_row - first_row))
        uniforms: dict[str, object] = {"first_row": first_row, "end_row": end_row}
        band_lists = self._pool.buffer("lists", 4 * PEEL_LIST_WORDS * width * (end_row - first_row))
        list_buffers = {"start_block": out.starts, "group_block": band_lists}
        self._lists.version(FRONT_SIDE=sides[0], BEHIND_SIDE=sides[1]).dispatch(
            groups,
            textures=samples | {"depth_tx": picture.depth},
            images={
                "out_color_img": picture.color,
                "out_depth_img": out.depth,
                "out_position_img": out.positions,
            },
            buffers=list_buffers,
            uniforms=uniforms | {"shifts": _SHIFTS},
        )
        self._find_starts(first_row * width, (end_row - first_row) * width, out)
        self._pack.dispatch(
            groups,
            textures={"depth_tx": picture.depth},
            images={"out_depth_img": out.depth},
            buffers=list_buffers | {"fragment_block": out.words},
            uniforms=uniforms,
        )

    def _find_starts(self, first_pixel: int, pixel_count: int, out: _ListMemory) -> None:
        """Turn the lengths of the lists of a band into their starts."""
        self._starts.dispatch(
            (1, 1),
            buffers={"start_block": out.starts, "total_block": self._total},
            uniforms={
                "first_pixel": first_pixel,
                "pixel_count": pixel_count,
                "capacity": out.capacity,
                "has_end": True,
            },
        )

    def release(self) -> None:
        """Release everything on the GPU."""
        programs = self._lists, self._starts, self._pack
        for resource in (*programs, self._total, self._surfaces, self._pool):
            resource.release()


def _shift_view(view: SceneView, index: int, shift: tuple[float, float]) -> SceneView:
    """Return the view for draw `index`, whose samples are shifted by `shift` (right, down).

    All draws go into one texture, each below the previous ones.
    """
    (right, down), (x, y) = view.jitter_px, shift
    shifted = replace(view, jitter_px=(right + x, down + y), sample=index)
    return replace(shifted, rows_above=index * view.size[1])
