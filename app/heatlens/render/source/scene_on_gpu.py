"""A 3D scene on the GPU, drawn on request: as a pinhole picture, or through a real lens."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import assert_never

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.coc_line import area_at, upper_median_m
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_view import pupil_of
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.context import check_plate_fits
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import FloatArray, TexturePool, download
from heatlens.render.scene_gpu.accumulation import Accumulation
from heatlens.render.scene_gpu.depth_survey import DepthSurvey
from heatlens.render.scene_gpu.pinhole_draw import (
    PINHOLE_VIEWS,
    DrawnPinhole,
    PinholeDraw,
    Request,
    pose_of,
    shot_view,
)
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from heatlens.render.scene_gpu.scene_plate import DrawnPixels, plate_of_scene
from heatlens.render.source.pinhole import Pinhole


@dataclass(frozen=True, eq=False)
class _DrawnPicture:
    """The latest picture; a request with an equal `key` need not be drawn again."""

    key: object
    views: int  # samples a pixel
    pinhole: Pinhole
    pixels: DrawnPixels  # pixels of the plate


class SceneOnGpu:
    """Holds one scene. Implements `SourceOnGpu`."""

    has_many_views = True

    def __init__(self, ctx: Device, scene: Scene, raster: SceneRaster | None = None) -> None:
        """Upload the scene, unless `raster`, which another source owns, holds it already."""
        self.scene = scene
        self._owns_raster = raster is None
        self._raster = raster or SceneRaster(ctx)
        if raster is None:
            self._raster.load(scene)
        self._ctx = ctx
        self._survey = DepthSurvey(ctx)
        self._pinholes = PinholeDraw(ctx, scene, self._raster, self._survey)
        self._pool = TexturePool(ctx)
        self._latest: _DrawnPicture | None = None
        self._bank = 0  # index of two sets of textures: one has the latest, the other is drawn

    @cached_property
    def _accumulation(self) -> Accumulation:
        """The accumulation of views, made at its first use."""
        return Accumulation(self._ctx, self._raster)

    @cached_property
    def _ray_tracer(self) -> RayTracer:
        """The ray tracer, made at its first use."""
        return RayTracer(self._ctx, self._raster)

    def size(self, shot: Shot) -> tuple[int, int]:
        return (shot.framing or Framing()).size

    def check_method(self, method: Method) -> None:
        """Accept every method, because scenes can be rendered by all of them."""

    def pinhole_steps(
        self, shot: Shot, frame: int, views: int | None, is_for_file: bool = False
    ) -> Steps[Pinhole]:
        """See `SourceOnGpu`; an unchanged picture is returned as the same object."""
        check_plate_fits(self._ctx, *self.size(shot))
        key = self._pinhole_key(shot, frame), is_for_file
        latest = self._latest
        if latest is not None and latest.key == key and latest.views >= (views or 0):
            return latest.pinhole
        views, bank = views or PINHOLE_VIEWS, 1 - self._bank
        drawn = yield from self._pinholes.steps(Request(shot, frame, views, bank, is_for_file, key))
        pixels = DrawnPixels(drawn.color, drawn.depth, self._raster.read)
        pinhole = self._pinhole(shot, frame, drawn, pixels)
        self._forget_latest()
        self._bank, self._latest = bank, _DrawnPicture(key, views, pinhole, pixels)
        return pinhole

    def _pinhole(
        self, shot: Shot, frame: float, drawn: DrawnPinhole, pixels: DrawnPixels
    ) -> Pinhole:
        """Return a drawn picture as a pinhole, with a plate that describes it."""
        depths = self._survey.of(drawn.depth)
        view = self.pose_at(shot, frame), shot.lens_at(frame), self.size(shot)
        notes = () if drawn.peeled is None else drawn.peeled.notes
        plate = plate_of_scene(self.scene.path, pixels, depths, view, notes)
        surfaces = drawn.overscan, drawn.peeled
        return Pinhole(plate, drawn.color, drawn.depth, depths.dioptres, None, *surfaces)

    def _pinhole_key(self, shot: Shot, frame: float) -> object:
        """Return a key that is equal for equal pinhole pictures."""
        lens, camera_state = shot.lens_at(frame), (self.pose_at(shot, frame), self._moment(frame))
        return *camera_state, lens.focal_length_mm, lens.sensor_width_mm, self.size(shot)

    def through_lens(
        self, shot: Shot, frame: int, size: tuple[int, int], out: Texture
    ) -> Steps[None]:
        """See `SourceOnGpu`; views are accumulated or rays traced, by the method of the shot."""
        lens = shot.lens_at(frame)
        self._raster.place(frame)
        pupil = pupil_of(lens)
        view = shot_view(self.scene, shot, frame, size, 0, max(pupil.half_extents_m))
        relevant_lens = replace(lens, t_stop=None, acceptable_coc_mm=None, close_focus_m=None)
        key = (self.pose_at(shot, frame), relevant_lens, size, self._moment(frame))
        drawer = self._drawer_of(shot.defocus.method)
        for name in drawer.steps(view, pupil, shot.defocus.views, out, key):
            yield name
            self._raster.place(frame)  # others may have drawn another frame in between

    def _drawer_of(self, method: Method) -> Accumulation | RayTracer:
        """Return the object that draws a scene by `method`. Raises ValueError."""
        match method:
            case Method.ACCUMULATION:
                return self._accumulation
            case Method.RAYTRACED:
                return self._ray_tracer
            case Method.DIFFUSION | Method.HEAT | Method.GATHER | Method.SCATTER | Method.PYRAMID:
                raise ValueError(f"{method} blurs a plate; it does not draw a scene.")
            case _:
                assert_never(method)

    def _moment(self, frame: float) -> float:
        """Return the frame, or 0 where it makes no difference to the picture."""
        return frame if self.scene.is_moving else 0.0

    def pose_at(self, shot: Shot, frame: float) -> Pose:
        return pose_of(self.scene, shot, frame)

    def depth_m_at(self, shot: Shot, frame: float, x: int, y: int) -> float:
        window = Box(0, 0, *self.size(shot))
        return upper_median_m(self._depth_in(shot, frame, area_at(x, y, window, window)))

    def _depth_in(self, shot: Shot, frame: float, area: Box) -> FloatArray:
        """Return the planar meters (h, w) of an area of the picture at `frame`.

        The latest picture stays as it is.
        """
        width, height = size = self.size(shot)
        offset_px = (area.x0 + area.x1 - width) / 2, (area.y0 + area.y1 - height) / 2
        view = shot_view(self.scene, shot, frame, size)
        area_view = replace(view, size=(area.width, area.height), jitter_px=offset_px)
        depth = self._pool.texture("depth of an area", area_view.size, 1)
        self._raster.depth_at(area_view, frame, depth)
        return download(depth)

    def set_step_size(self, share: float) -> None:
        self._raster.bands.share = share

    def share(self) -> "SceneOnGpu":
        return SceneOnGpu(self._ctx, self.scene, self._raster)

    def _forget_latest(self) -> None:
        """Forget the latest picture, whose textures will be overwritten."""
        if self._latest is not None:
            self._latest.pixels.invalidate()
            self._latest = None

    def release(self) -> None:
        self._forget_latest()
        self._survey.release()
        self._pinholes.release()
        for name in ("_accumulation", "_ray_tracer"):
            if name in self.__dict__:
                self.__dict__[name].release()
        self._pool.release()
        if self._owns_raster:
            self._raster.release()
