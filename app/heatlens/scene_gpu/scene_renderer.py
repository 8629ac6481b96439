"""A scene in front of the lens: its pinhole picture, and what a real lens would make of it."""

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import assert_never

import moderngl

from heatlens.defocus.plate_passes import CropPass
from heatlens.gpu.textures import FloatArray, TexturePool, download
from heatlens.model.boxes import Box
from heatlens.model.framing import Framing, Pose
from heatlens.model.settings import Method
from heatlens.model.shot import Shot
from heatlens.model.value_bins import ValueBins
from heatlens.plate.plate import Plate
from heatlens.scene.nearest_seen import nearest_seen_m, with_near_plane
from heatlens.scene.scene import Scene
from heatlens.scene.scene_bounds import box_around, box_corners_m, track_of
from heatlens.scene.scene_view import SceneView, finer, pupil_of, view_of
from heatlens.scene_gpu.accumulation import Accumulation
from heatlens.scene_gpu.antialias import Antialias
from heatlens.scene_gpu.depth_survey import DepthSurvey
from heatlens.scene_gpu.overscan import Overscan, RingSurvey, fineness, margin_px, widened
from heatlens.scene_gpu.peel import Peeled, ScenePeel
from heatlens.scene_gpu.raster import SceneRaster
from heatlens.scene_gpu.ray_tracer import RayTracer
from heatlens.scene_gpu.scene_plate import DrawnPixels, plate_of_scene

Drawn = tuple[moderngl.Texture, moderngl.Texture]  # colour and depth

# Views of one sample a pixel each, spread evenly over it. With fewer, lamps smaller than a pixel
# would be dimmer or brighter than they are, and a blur would spread the error.
PINHOLE_VIEWS = 64
_OVERSCAN_FROM_VIEWS = 16  # with fewer something moves, and nobody looks at the border


@dataclass(frozen=True, eq=False)
class Look:
    """A pinhole picture on the GPU, half and float as in a file, and as a plate."""

    plate: Plate
    pixels: DrawnPixels  # of the plate
    color: moderngl.Texture
    depth: moderngl.Texture
    dioptres: ValueBins
    overscan: Overscan | None  # not of a hurried picture


class SceneRenderer:
    """Holds one scene on the GPU and renders it."""

    def __init__(
        self, ctx: moderngl.Context, scene: Scene, raster: SceneRaster | None = None
    ) -> None:
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
        self._held: tuple[object, Look] | None = None
        self._peeled: Peeled | None = None  # behind it
        self._views = 0  # in it
        self._bank = 0  # of two sets of textures: one is held while the other is drawn
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
        steps are abandoned, `held` stays what it was. `is_for_file`: the overscan has the pixels of
        the picture, and no finer ones.
        """
        size = (shot.framing or Framing()).size
        key = self._pinhole_key(shot, frame), is_for_file
        if self._held is not None and self._held[0] == key and self._views >= (views or 0):
            return
        views, bank = views or PINHOLE_VIEWS, 1 - self._bank
        is_hurried = views < _OVERSCAN_FROM_VIEWS
        fine = 1 if is_hurried or is_for_file else fineness(self._ctx, size)
        margin = 0 if is_hurried else margin_px(self._ctx, size)
        color, depth = yield from self._drawn(shot, frame, views, bank, margin, fine)
        overscan = None if is_hurried else self._overscan(color, depth, margin, fine)
        if overscan is not None:
            color, depth = yield from self._framed(shot, frame, overscan, bank)
        surveyed, pixels = self._survey.of(depth), DrawnPixels(color, depth, self._raster.read)
        seen = self.pose_at(shot, frame), shot.lens_at(frame), size
        plate = plate_of_scene(self.scene.path, pixels, surveyed, seen)
        self._let_go()
        self._bank, self._views = bank, views
        self._held = key, Look(plate, pixels, color, depth, surveyed.dioptres, overscan)

    def _drawn(
        self, shot: Shot, frame: float, views: int, bank: int, margin: int, fine: int
    ) -> Generator[str, None, Drawn]:
        """Draw colour and depth with a margin on every side, and return both."""
        view = finer(self._view(shot, frame, (shot.framing or Framing()).size, margin), fine)
        name = "pinhole" if views < _OVERSCAN_FROM_VIEWS else "wide"
        color = self._pool.texture(f"{name} colour {bank}", view.size, 4, "f2")
        depth = self._pool.texture(f"{name} depth {bank}", view.size, 1)
        yield from self._colored(shot, frame, max(views // fine**2, 1), view, color)
        yield from self._deep(view, frame, depth)
        return color, depth

    def _deep(self, view: SceneView, frame: float, depth: moderngl.Texture) -> Iterator[str]:
        """Draw depth at the middle of each pixel."""
        for band in self._raster.bands.of(view.size):
            self._raster.depth(view, depth, band)
            yield "pinhole"
            self._raster.place(frame)

    def _overscan(
        self, color: moderngl.Texture, depth: moderngl.Texture, margin: int, fine: int
    ) -> Overscan:
        rings_m, bins = self._rings.of(depth, fine * margin), self._survey.of(depth).dioptres
        return Overscan(color, depth, margin, rings_m, bins, fine)

    def _framed(
        self, shot: Shot, frame: float, overscan: Overscan, bank: int
    ) -> Generator[str, None, Drawn]:
        """Return colour and depth of the frame alone, in its own pixels."""
        size, fine = (shot.framing or Framing()).size, overscan.fine
        color = self._pool.texture(f"pinhole colour {bank}", size, 4, "f2")
        depth = self._pool.texture(f"pinhole depth {bank}", size, 1)
        begin = (fine * overscan.margin_px,) * 2
        self._crop.run(overscan.color, begin, color, fine)
        if fine == 1:
            self._crop.run(overscan.depth, begin, depth)
        else:  # a mean of depths would be a surface that is not there
            yield from self._deep(self._view(shot, frame, size), frame, depth)
        return color, depth

    def behind(self, shot: Shot, frame: float) -> Generator[str, None, Peeled | None]:
        """Return in steps what lies behind the latest pinhole picture, which is of this frame.

        None for a hurried picture.
        """
        look = self.held
        if look.overscan is None or self._views < PINHOLE_VIEWS:
            return None
        if self._peeled is None:
            wide, size = look.overscan, (shot.framing or Framing()).size
            view = finer(self._view(shot, frame, size, wide.margin_px), wide.fine)
            self._peeled = yield from self._peel.steps(
                view, wide, lambda: self._raster.place(frame)
            )
        return self._peeled

    def _pinhole_key(self, shot: Shot, frame: float) -> object:
        """Return a key that is equal where the pinhole picture is."""
        lens, size = shot.lens_at(frame), (shot.framing or Framing()).size
        pose = self.pose_at(shot, frame)
        return pose, lens.focal_length_mm, lens.sensor_width_mm, size, self._moment(frame)

    def _colored(
        self, shot: Shot, frame: float, views: int, view: SceneView, color: moderngl.Texture
    ) -> Iterator[str]:
        """Draw at most `views` samples a pixel, spread over it; a single one is at its middle."""
        self._raster.place(frame)
        if views == 1:
            for band in self._raster.bands.of(color.size):
                self._raster.draw(view, color, band)
                yield "pinhole"
                self._raster.place(frame)
            return
        key = self._pinhole_key(shot, frame)
        for _ in self._pinhole.steps(view, views, color, key):
            yield "pinhole"
            self._raster.place(frame)  # others may have drawn another frame in between

    @property
    def held(self) -> Look:
        """The latest pinhole picture; `look` has to have been at its end."""
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
        self, shot: Shot, frame: float, size: tuple[int, int], out: moderngl.Texture
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
            self._held = self._peeled = None

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
