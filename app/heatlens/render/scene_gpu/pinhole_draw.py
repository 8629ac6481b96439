"""Draw the pinhole picture of a scene: fast with few samples, or complete with a margin."""

import math
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import box_around, box_corners_m, track_of
from heatlens.media.scene.scene_view import (
    SceneView,
    nearest_visible_m,
    refine_view,
    view_of,
    with_near_plane,
)
from heatlens.render.defocus.plate_passes import CropPass
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.scene_gpu import antialias, peel
from heatlens.render.scene_gpu.antialias import Antialias
from heatlens.render.scene_gpu.bands import Bands
from heatlens.render.scene_gpu.depth_survey import DepthSurvey
from heatlens.render.scene_gpu.overscan import (
    Overscan,
    RingSurvey,
    add_margin,
    margin_px,
    texels_per_pixel,
)
from heatlens.render.scene_gpu.peel import FRONT_SIDE, SAMPLES, STEPS_OF_BAND, Peeled, ScenePeel
from heatlens.render.scene_gpu.raster import SceneRaster

ColorAndDepth = tuple[Texture, Texture]  # color and depth

# Samples of a pixel, spread evenly over it. With fewer, lamps smaller than a pixel would be dimmer
# or brighter than they are, and a blur would spread the error.
PINHOLE_VIEWS = SAMPLES
_FEW_ACROSS = 2  # samples that every pixel gets; some need no more
# Fewer samples are drawn only during movement, when nobody looks at the border. A picture of so
# many is the beginning of the whole one, which does not draw these samples again.
FIRST_VIEWS = _FEW_ACROSS**2


@dataclass(frozen=True, eq=False)
class DrawnPinhole:
    """A pinhole picture in textures: RGBA in half floats, and depth in float32 meters."""

    color: Texture
    depth: Texture
    overscan: Overscan | None = None  # None for a fast preview
    peeled: Peeled | None = None  # the hidden surfaces; None for a fast preview


@dataclass(frozen=True)
class Request:
    """The next picture to draw, into this `bank` of textures.

    `key` is equal for an equal scene and view. With `is_for_file`, hidden surfaces are listed for
    the pixels of the picture, not for finer ones.
    """

    shot: Shot
    frame: float
    views: int
    bank: int
    is_for_file: bool
    key: object

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frame."""
        return (self.shot.framing or Framing()).size


class PinholeDraw:
    """Draws the pinhole pictures of a scene that lies on the GPU."""

    def __init__(self, ctx: Device, scene: Scene, raster: SceneRaster, survey: DepthSurvey) -> None:
        self._ctx = ctx
        self._scene = scene
        self._raster = raster
        self._survey = survey
        self._rings = RingSurvey(ctx)
        self._crop = CropPass(ctx)
        self._pool = TexturePool(ctx)
        self._pinhole = Antialias(ctx, raster)

    @cached_property
    def _peel(self) -> ScenePeel:
        return ScenePeel(self._ctx, self._raster, self._survey)

    def steps(self, request: Request) -> Generator[str, None, DrawnPinhole]:
        """Draw the requested picture and return it; the other bank of textures stays as it is."""
        is_fast = request.views < FIRST_VIEWS
        return (yield from (self._draw_fast if is_fast else self._draw_with_margin)(request))

    def release(self) -> None:
        """Release what is on the GPU, but not the scene."""
        self._rings.release()
        self._crop.release()
        self._pinhole.release()
        if "_peel" in self.__dict__:
            self._peel.release()
        self._pool.release()

    def _draw_fast(self, request: Request) -> Generator[str, None, DrawnPinhole]:
        """Draw only the frame, with few samples a pixel; a single sample is at the middle."""
        view = self._view(request)
        color, depth = self._textures("pinhole", request.bank, request.size)
        yield from self._draw_color(view, math.isqrt(request.views), 1, color, request)
        yield from self._draw_depth(view, request.frame, depth)
        return DrawnPinhole(color, depth)

    def _draw_with_margin(self, request: Request) -> Generator[str, None, DrawnPinhole]:
        """Draw the picture with a margin on every side, and list the surfaces behind it.

        Small pictures are drawn at twice their size, unless the request is for a file. Surfaces
        are listed only if all samples are requested.
        """
        fine = 1 if request.is_for_file else texels_per_pixel(self._ctx, request.size)
        margin = margin_px(self._ctx, request.size)
        view = refine_view(self._view(request, margin), fine)
        color, depth = self._textures("wide", request.bank, view.size)
        is_peeled = request.views >= PINHOLE_VIEWS
        across = _FEW_ACROSS if is_peeled else math.isqrt(request.views)
        yield from self._draw_color(view, across // fine, fine, color, request, fine * margin)
        yield from self._draw_depth(view, request.frame, depth)
        rings_m, bins = self._rings.of(depth, fine * margin), self._survey.of(depth).dioptres
        overscan, peeled = (
            Overscan(
                color=color, depth=depth, margin_px=margin, ring_m=rings_m, bins=bins, fine=fine
            ),
            None,
        )
        if is_peeled:
            done = self._pinhole.picture(view.size).done
            peeled = yield from self._peel.steps(
                view, overscan, done, lambda: self._raster.place(request.frame), request.bank
            )
        overscan = yield from self._add_picture_textures(request, overscan)
        return DrawnPinhole(*self._crop_frame(request, overscan), overscan, peeled)

    def _view(self, request: Request, margin: int = 0) -> SceneView:
        """Return the view of a requested picture with a margin on every side."""
        return shot_view(self._scene, request.shot, request.frame, request.size, margin)

    def _textures(self, name: str, bank: int, size: tuple[int, int]) -> ColorAndDepth:
        """Return the textures called `name` for color and depth, of a `bank` and `size`."""
        color = self._pool.texture(f"{name} colour {bank}", size, 4, "f2")
        return color, self._pool.texture(f"{name} depth {bank}", size, 1)

    def _draw_color(
        self,
        view: SceneView,
        across: int,
        fine: int,
        color: Texture,
        request: Request,
        margin_px: int = 0,
    ) -> Iterator[str]:
        """Draw `color` with `across` x `across` samples a pixel; see `Antialias.steps`."""
        self._raster.place(request.frame)
        if across == 1 and fine == 1:
            for band in self._raster.bands.of(color.size):
                self._raster.draw(view, color, band)
                yield "pinhole"
                self._raster.place(request.frame)
            return
        for _ in self._pinhole.steps(view, across, fine, margin_px, request.key):
            yield "pinhole"
            self._raster.place(request.frame)  # others may have drawn another frame in between
        self._crop.run(self._pinhole.picture(view.size).mean, (0, 0), color)

    def _draw_depth(self, view: SceneView, frame: float, depth: Texture) -> Iterator[str]:
        """Draw `depth`, in meters, at the middle of each pixel."""
        self._raster.place(frame)  # others may have drawn another frame in between
        for band in self._raster.bands.of(view.size):
            self._raster.depth(view, depth, band)
            yield "pinhole"
            self._raster.place(frame)

    def _add_picture_textures(
        self, request: Request, overscan: Overscan
    ) -> Generator[str, None, Overscan]:
        """Return the overscan with color and depth in the pixels of the frame too."""
        if overscan.fine == 1:
            return overscan
        view = self._view(request, overscan.margin_px)
        textures = color, depth = self._textures("own", request.bank, view.size)
        self._crop.run(overscan.color, (0, 0), color, overscan.fine)
        # Depth is drawn again, because a mean of depths would be a surface that is not there.
        yield from self._draw_depth(view, request.frame, depth)
        return replace(overscan, picture_textures=textures)

    def _crop_frame(self, request: Request, overscan: Overscan) -> ColorAndDepth:
        """Return color and depth of the frame alone."""
        textures = self._textures("pinhole", request.bank, request.size)
        picture = overscan.in_picture_pixels
        for whole, out in zip((picture.color, picture.depth), textures, strict=True):
            self._crop.run(whole, (overscan.margin_px,) * 2, out)
        return textures


def pose_of(scene: Scene, shot: Shot, frame: float) -> Pose:
    """Return the pose of a shot's camera."""
    lens = shot.lens_at(frame)
    return track_of(scene, shot.framing or Framing(), lens).pose_at(frame)


def shot_view(
    scene: Scene,
    shot: Shot,
    frame: float,
    size: tuple[int, int],
    margin: int = 0,
    lens_radius_m: float = 0.0,
) -> SceneView:
    """Return the view of a picture of `size` with a margin on every side.

    It is used from the middle of the lens, or from points up to `lens_radius_m` away from it.
    """
    corners = box_corners_m(scene, frame)
    view = view_of(pose_of(scene, shot, frame), shot.lens_at(frame), size, box_around(corners))
    view = replace(view, size=add_margin(size, margin))
    return with_near_plane(view, nearest_visible_m(view, corners, lens_radius_m))


def drawing_steps(ctx: Device, triangle_count: int, size: tuple[int, int]) -> int:
    """Return how many steps the whole pinhole picture of a scene of so many triangles takes."""
    bands, fine = Bands(ctx, triangle_count), texels_per_pixel(ctx, size)
    width, height = add_margin(size, margin_px(ctx, size))
    drawn_size = fine * width, fine * height
    first_steps = _length(bands.of_samples(drawn_size, _FEW_ACROSS // fine, antialias.LARGER))
    peel_steps = (
        _length(bands.of_samples(drawn_size, FRONT_SIDE // fine, peel.LARGER)) * STEPS_OF_BAND
    )
    depth_steps = _length(bands.of(drawn_size)) + (
        _length(bands.of((width, height))) if fine > 1 else 0
    )
    return first_steps + peel_steps + depth_steps


def _length(bands: Iterable[object]) -> int:
    """Return the number of bands."""
    return sum(1 for _ in bands)
