"""Render a scene: as a pinhole picture, or through a real lens."""

import math
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import assert_never

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.framing import Framing, Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import ValueBins
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import box_around, box_corners_m, track_of
from heatlens.media.scene.scene_view import (
    SceneView,
    finer,
    nearest_seen_m,
    pupil_of,
    view_of,
    with_near_plane,
)
from heatlens.render.defocus.plate_passes import CropPass
from heatlens.render.gpu.device import Device, Texture
from heatlens.render.gpu.textures import FloatArray, TexturePool, download
from heatlens.render.scene_gpu import antialias, peel
from heatlens.render.scene_gpu.accumulation import Accumulation
from heatlens.render.scene_gpu.antialias import Antialias
from heatlens.render.scene_gpu.bands import Bands
from heatlens.render.scene_gpu.depth_survey import DepthSurvey
from heatlens.render.scene_gpu.overscan import Overscan, RingSurvey, fineness, margin_px, widened
from heatlens.render.scene_gpu.peel import FRONT_SIDE, SAMPLES, STEPS_OF_BAND, Peeled, ScenePeel
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from heatlens.render.scene_gpu.scene_plate import DrawnPixels, plate_of_scene

Drawn = tuple[Texture, Texture]  # colour and depth

# Samples of a pixel, spread evenly over it. With fewer, lamps smaller than a pixel would be dimmer
# or brighter than they are, and a blur would spread the error.
PINHOLE_VIEWS = SAMPLES
_FEW_ACROSS = 2  # samples that every pixel gets; some need no more
_GOOD_ACROSS = 4  # samples of every pixel if none gets more
_OVERSCAN_FROM_VIEWS = 16  # fewer are drawn only during movement, when nobody looks at the border


@dataclass(frozen=True, eq=False)
class DrawnScene:
    """A pinhole picture on the GPU, half and float as in a file, and as a plate."""

    plate: Plate
    pixels: DrawnPixels  # pixels of the plate
    color: Texture
    depth: Texture
    dioptres: ValueBins
    overscan: Overscan | None  # None for a hurried picture
    peeled: Peeled | None  # the hidden surfaces; None for a hurried picture


@dataclass(frozen=True)
class _Request:
    """The next picture to draw, into this `bank` of textures."""

    shot: Shot
    frame: float
    views: int
    bank: int
    is_for_file: bool

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frame."""
        return (self.shot.framing or Framing()).size


class SceneRenderer:
    """Holds one scene on the GPU and renders it."""

    def __init__(self, ctx: Device, scene: Scene, raster: SceneRaster | None = None) -> None:
        """Load the scene, unless `raster`, which another renderer owns, holds it already."""
        self.scene = scene
        self._owns_raster = raster is None
        self._raster = raster or SceneRaster(ctx)
        if raster is None:
            self._raster.load(scene)
        self._survey = DepthSurvey(ctx)
        self._rings = RingSurvey(ctx)
        self._crop = CropPass(ctx)
        self._ctx = ctx
        self._pool = TexturePool(ctx)
        self._held: tuple[object, DrawnScene] | None = None
        self._views = 0  # samples in the held picture
        self._bank = 0  # index of two sets of textures: one is held while the other is drawn
        self._pinhole = Antialias(ctx, self._raster)

    @cached_property
    def _accumulation(self) -> Accumulation:
        return Accumulation(self._ctx, self._raster)

    @cached_property
    def _peel(self) -> ScenePeel:
        return ScenePeel(self._ctx, self._raster, self._survey)

    @cached_property
    def _ray_tracer(self) -> RayTracer:
        return RayTracer(self._ctx, self._raster)

    def beside(self) -> "SceneRenderer":
        """Return another renderer of the same scene, valid as long as this one holds it."""
        return SceneRenderer(self._ctx, self.scene, self._raster)

    def pose_at(self, shot: Shot, frame: float) -> Pose:
        """Return the pose of a shot's camera."""
        lens = shot.lens_at(frame)
        return track_of(self.scene, shot.framing or Framing(), lens).pose_at(frame)

    def look(
        self, shot: Shot, frame: float, views: int | None = None, is_for_file: bool = False
    ) -> Iterator[str]:
        """Draw the pinhole picture of `frame`, unless it exists; `held` has it at the end.

        A picture with fewer than `views` samples is continued; None accepts any number. If the
        steps are abandoned, `held` stays unchanged. With `is_for_file`, hidden surfaces are listed
        for the pixels of the picture, not for finer ones.
        """
        key = self._pinhole_key(shot, frame), is_for_file
        if self._held is not None and self._held[0] == key and self._views >= (views or 0):
            return
        views, bank = views or PINHOLE_VIEWS, 1 - self._bank
        drawn = self._hurried if views < _OVERSCAN_FROM_VIEWS else self._whole
        scene = yield from drawn(_Request(shot, frame, views, bank, is_for_file), key)
        self._let_go()
        self._bank, self._views = bank, views
        self._held = key, scene

    def _hurried(self, request: "_Request", key: object) -> Generator[str, None, DrawnScene]:
        """Draw only the frame, with few samples a pixel; a single sample is at the middle."""
        view = self._view(request.shot, request.frame, request.size)
        color, depth = self._textures("pinhole", request.bank, request.size)
        yield from self._colored(view, math.isqrt(request.views), 1, key, color, request.frame)
        yield from self._deep(view, request.frame, depth)
        return self._drawn(request, color, depth)

    def _whole(self, request: "_Request", key: object) -> Generator[str, None, DrawnScene]:
        """Draw the picture with a margin on every side, and list the surfaces behind it."""
        fine = 1 if request.is_for_file else fineness(self._ctx, request.size)
        margin = margin_px(self._ctx, request.size)
        view = finer(self._view(request.shot, request.frame, request.size, margin), fine)
        color, depth = self._textures("wide", request.bank, view.size)
        is_peeled = request.views >= PINHOLE_VIEWS
        across = _FEW_ACROSS if is_peeled else _GOOD_ACROSS
        yield from self._colored(view, across // fine, fine, key, color, request.frame)
        yield from self._deep(view, request.frame, depth)
        rings_m, bins = self._rings.of(depth, fine * margin), self._survey.of(depth).dioptres
        overscan, peeled = Overscan(color, depth, margin, rings_m, bins, fine), None
        if is_peeled:
            done = self._pinhole.picture(view.size).done
            peeled = yield from self._peel.steps(
                view, overscan, done, lambda: self._raster.place(request.frame), request.bank
            )
        overscan = yield from self._in_own_pixels(request, overscan)
        color, depth = self._framed(request, overscan)
        return self._drawn(request, color, depth, overscan, peeled)

    def _textures(self, name: str, bank: int, size: tuple[int, int]) -> Drawn:
        """Return textures for colour and depth."""
        color = self._pool.texture(f"{name} colour {bank}", size, 4, "f2")
        return color, self._pool.texture(f"{name} depth {bank}", size, 1)

    def _drawn(
        self,
        request: "_Request",
        color: Texture,
        depth: Texture,
        overscan: Overscan | None = None,
        peeled: Peeled | None = None,
    ) -> DrawnScene:
        surveyed, pixels = self._survey.of(depth), DrawnPixels(color, depth, self._raster.read)
        seen = (
            self.pose_at(request.shot, request.frame),
            request.shot.lens_at(request.frame),
            request.size,
        )
        plate = plate_of_scene(self.scene.path, pixels, surveyed, seen)
        notes = () if peeled is None else peeled.notes
        plate = replace(plate, notes=notes, surfaces_lost=" ".join(notes))
        return DrawnScene(plate, pixels, color, depth, surveyed.dioptres, overscan, peeled)

    def _colored(
        self,
        view: SceneView,
        across: int,
        fine: int,
        key: object,
        color: Texture,
        frame: float,
    ) -> Iterator[str]:
        """Draw `across` x `across` samples a pixel."""
        self._raster.place(frame)
        if across == 1 and fine == 1:
            for band in self._raster.bands.of(color.size):
                self._raster.draw(view, color, band)
                yield "pinhole"
                self._raster.place(frame)
            return
        for _ in self._pinhole.steps(view, across, fine, key):
            yield "pinhole"
            self._raster.place(frame)  # others may have drawn another frame in between
        self._crop.run(self._pinhole.picture(view.size).mean, (0, 0), color)

    def _deep(self, view: SceneView, frame: float, depth: Texture) -> Iterator[str]:
        """Draw depth at the middle of each pixel."""
        self._raster.place(frame)  # others may have drawn another frame in between
        for band in self._raster.bands.of(view.size):
            self._raster.depth(view, depth, band)
            yield "pinhole"
            self._raster.place(frame)

    def _in_own_pixels(
        self, request: "_Request", overscan: Overscan
    ) -> Generator[str, None, Overscan]:
        """Return the overscan with colour and depth in the pixels of the frame too."""
        if overscan.fine == 1:
            return overscan
        view = self._view(request.shot, request.frame, request.size, overscan.margin_px)
        own = color, depth = self._textures("own", request.bank, view.size)
        self._crop.run(overscan.color, (0, 0), color, overscan.fine)
        # A mean of depths would be a surface that is not there.
        yield from self._deep(view, request.frame, depth)
        return replace(overscan, own=own)

    def _framed(self, request: "_Request", overscan: Overscan) -> Drawn:
        """Return colour and depth of the frame alone."""
        framed = self._textures("pinhole", request.bank, request.size)
        own = overscan.in_own_pixels
        for whole, out in zip((own.color, own.depth), framed, strict=True):
            self._crop.run(whole, (overscan.margin_px,) * 2, out)
        return framed

    def _pinhole_key(self, shot: Shot, frame: float) -> object:
        """Return a key that is equal where the pinhole picture is."""
        lens, size = shot.lens_at(frame), (shot.framing or Framing()).size
        pose = self.pose_at(shot, frame)
        return pose, lens.focal_length_mm, lens.sensor_width_mm, size, self._moment(frame)

    @property
    def held(self) -> DrawnScene:
        """The latest pinhole picture; the steps of `look` must be complete."""
        assert self._held is not None
        return self._held[1]

    def depth_in(self, shot: Shot, frame: float, area: Box) -> FloatArray:
        """Return (h, w) planar metres of an area at any frame; `held` stays what it is."""
        width, height = size = (shot.framing or Framing()).size
        view = self._view(shot, frame, size)
        aside_px = (area.x0 + area.x1 - width) / 2, (area.y0 + area.y1 - height) / 2
        part = replace(view, size=(area.width, area.height), jitter_px=aside_px)
        depth = self._pool.texture("depth of an area", part.size, 1)
        self._raster.depth_at(part, frame, depth)
        return download(depth)

    def through_lens(
        self, shot: Shot, frame: float, size: tuple[int, int], out: Texture
    ) -> Iterator[str]:
        """Accumulate or trace rays at `size` into `out`, RGBA float32, in steps."""
        lens = shot.lens_at(frame)
        self._raster.place(frame)
        pupil = pupil_of(lens)
        view = self._view(shot, frame, size, lens_radius_m=max(pupil.half_extents_m))
        method = self._method(shot.defocus.method)
        seen = replace(lens, t_stop=None, acceptable_coc_mm=None, close_focus_m=None)
        key = (self.pose_at(shot, frame), seen, size, self._moment(frame))
        for name in method.steps(view, pupil, shot.defocus.views, out, key):
            yield name
            self._raster.place(frame)  # others may have drawn another frame in between

    def _method(self, method: Method) -> Accumulation | RayTracer:
        """Return what draws a scene by `method`."""
        match method:
            case Method.ACCUMULATION:
                return self._accumulation
            case Method.RAYTRACED:
                return self._ray_tracer
            case Method.DIFFUSION | Method.HEAT | Method.GATHER | Method.SCATTER | Method.PYRAMID:
                raise ValueError(f"{method} blurs a plate; it does not draw a scene.")
            case _:
                assert_never(method)

    def _let_go(self) -> None:
        if self._held is not None:
            self._held[1].pixels.let_go()
            self._held = None

    def pace(self, share: float) -> None:
        self._raster.bands.share = share

    def release(self) -> None:
        """Release what is on the GPU."""
        self._let_go()
        for held in (self._survey, self._rings, self._crop):
            held.release()
        self._pinhole.release()
        for made in ("_accumulation", "_ray_tracer", "_peel"):
            if made in self.__dict__:
                self.__dict__[made].release()
        self._pool.release()
        if self._owns_raster:
            self._raster.release()

    def _moment(self, frame: float) -> float:
        """Return the frame, or 0 where it makes no difference to the picture."""
        return frame if self.scene.is_moving else 0.0

    def _view(
        self,
        shot: Shot,
        frame: float,
        size: tuple[int, int],
        margin: int = 0,
        lens_radius_m: float = 0.0,
    ) -> SceneView:
        """Return the view of a picture of `size` with a margin on every side.

        It is used from the middle of the lens, or from points up to `lens_radius_m` away from it.
        """
        pose, lens = self.pose_at(shot, frame), shot.lens_at(frame)
        corners = box_corners_m(self.scene, frame)
        view = view_of(pose, lens, size, box_around(corners))
        view = replace(view, size=widened(size, margin))
        return with_near_plane(view, nearest_seen_m(view, corners, lens_radius_m))


def drawing_steps(ctx: Device, triangle_count: int, size: tuple[int, int]) -> int:
    """Return how many steps the whole pinhole picture of a scene of so many triangles takes."""
    bands, fine = Bands(ctx, triangle_count), fineness(ctx, size)
    width, height = widened(size, margin_px(ctx, size))
    drawn = fine * width, fine * height
    few = _count(bands.of_samples(drawn, _FEW_ACROSS // fine, antialias.LARGER))
    many = _count(bands.of_samples(drawn, FRONT_SIDE // fine, peel.LARGER)) * STEPS_OF_BAND
    deep = _count(bands.of(drawn)) + (_count(bands.of((width, height))) if fine > 1 else 0)
    return few + many + deep


def _count(bands: Iterable[object]) -> int:
    return sum(1 for _ in bands)
