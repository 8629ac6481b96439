"""Hold one plate on the GPU, in textures that the next plate of the same size uses again."""

import math

import numpy as np
import numpy.typing as npt

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.framing import Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Pixels, Plate
from heatlens.render.defocus.cutout_pass import CutoutTextures
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.context import check_storage_fits
from heatlens.render.gpu.device import Device, Texture
from heatlens.render.gpu.textures import FloatArray, new_texture, upload, uploading
from heatlens.render.source.pinhole import Pinhole

_BRIGHT_PERCENT = 90.0  # percentile of the light that counts as bright
_BRIGHT_MOST = 4.0  # up to here the light counts as relative to a white surface
_STEP = 16.0  # a power of two, so that scaling is exact; and coarse, so that it is steady in a shot
_SAMPLES_A_SIDE = 128
_Textures = tuple[Texture, Texture]  # colour, depth
_Room = list[tuple[Plate, _Textures]]  # the plate, and what is beyond if that is known


def light_scale(color: npt.NDArray[np.float32]) -> float:
    """Return the factor, a power of two, on the light of a picture before it is blurred.

    `color` is (H, W, 4), scene-linear. It is 1 for pictures in which a white surface is about 1,
    and less for those in physical units, such as candela per square metre, so that highlights and
    similar colours are found as in any other picture.
    """
    rows, columns = (max(1, side // _SAMPLES_A_SIDE) for side in color.shape[:2])
    luminance = color[::rows, ::columns, :3].mean(axis=2)
    bright = float(np.percentile(luminance, _BRIGHT_PERCENT))
    if bright <= _BRIGHT_MOST:
        return 1.0
    return float(_STEP ** -math.ceil(math.log(bright / _BRIGHT_MOST, _STEP)))


class PlateOnGpu:
    """Holds the plate that was loaded last, or none. Implements `SourceOnGpu`."""

    scene = None
    has_many_views = False

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._held: Pinhole | None = None

    @property
    def held(self) -> Pinhole:
        """The loaded plate. Raises InputError while there is none."""
        if self._held is None:
            raise InputError("No plate is loaded.")
        return self._held

    def loading(self, plate: Plate) -> Steps[Pinhole]:
        """Upload a plate to the GPU in short steps.

        If the steps are not completed, nothing is loaded.
        """
        room = self._textures(plate)
        self._release_parts()
        self._held = None
        try:
            for part, (color, depth) in room:
                for texture, pixels in ((color, part.color), (depth, _depth_or_coc(part))):
                    for _ in uploading(texture, pixels):
                        yield "upload"
            self._held = self._pinhole(plate, room)
        finally:
            if self._held is None:
                for _, textures in room:
                    _release(textures)
        return self._held

    def _pinhole(self, plate: Plate, room: _Room) -> Pinhole:
        """Return the pinhole picture of a plate whose pixels have been uploaded."""
        scale, (widest, textures) = light_scale(plate.color), room[-1]
        fragments = self._fragments_of(widest, scale)
        wide = Pinhole(
            widest,
            *textures,
            widest.bins,
            fragments,
            light_scale=scale,
            cutout=self._cutout_of(widest, scale),
        )
        if widest is plate:
            return wide
        if fragments is not None:  # lists of the whole serve the frame as well
            own, all_ = plate.data_window, widest.data_window
            x, y = own.x0 - all_.x0, own.y0 - all_.y0
            fragments = fragments.part(Box(x, y, x + own.width, y + own.height))
        framed = room[0][1]
        return Pinhole(
            plate,
            *framed,
            plate.bins,
            fragments,
            light_scale=scale,
            beyond=wide,
            cutout=self._cutout_of(plate, scale),
        )

    def _cutout_of(self, plate: Plate, light_scale: float) -> CutoutTextures | None:
        """Upload what the plate keeps from the blur, with its light multiplied."""
        if (cutout := plate.cutout) is None:
            return None
        size, share = (plate.data_window.width, plate.data_window.height), cutout.share[..., None]
        factor = np.array([light_scale] * 3 + [1.0], np.float32)

        def held(pixels: FloatArray) -> Texture:
            channels = pixels.size // (size[0] * size[1])
            texture = new_texture(self._ctx, size, channels, label="cutout")
            upload(texture, np.ascontiguousarray(pixels, np.float32))
            return texture

        light, alpha = cutout.light[..., :3] * factor[:3], cutout.light[..., 3:]
        return CutoutTextures(
            held(np.concatenate([light, share], axis=-1)),
            held(np.concatenate([alpha] * 3 + [share], axis=-1))
            if plate.has_alpha or cutout.ground is not None
            else None,
            held(cutout.depth),
            held(cutout.rest.color * factor),
            held(_depth_or_coc(cutout.rest)),
            None if cutout.ground is None else held(cutout.ground * factor),
        )

    def _fragments_of(self, plate: Plate, light_scale: float) -> FragmentBuffers | None:
        """Upload the plate's fragment lists to the GPU. Raises GpuError if they do not fit."""
        if plate.fragments is None:
            return None
        lists, window = plate.fragments.scaled(light_scale), plate.data_window
        largest = max(lists.words.nbytes, lists.starts.nbytes)
        check_storage_fits(self._ctx, largest, "surfaces behind the picture")
        return FragmentBuffers(
            self._ctx.buffer(lists.starts),
            self._ctx.buffer(lists.words),
            (window.width, window.height),
            lists.is_measured,
            is_exact=lists.is_measured,  # all surfaces of a deep file come from one render
        )

    def _release_parts(self) -> None:
        if self._held is None:
            return
        if self._held.fragments is not None:
            self._held.fragments.release()
        for it in (self._held, self._held.beyond):
            if it is not None and it.cutout is not None:
                it.cutout.release()

    def _textures(self, plate: Plate) -> _Room:
        """Return textures for the plate and what is beyond: the previous ones if all sizes fit."""
        parts = [it for it in (plate, plate.beyond) if it is not None]
        sizes = [(it.data_window.width, it.data_window.height) for it in parts]
        held = [it for it in (self._held, self._held and self._held.beyond) if it is not None]
        if [it.color.size for it in held] == sizes:
            return [(part, (it.color, it.depth)) for part, it in zip(parts, held, strict=True)]
        self.release()
        return [(part, self._new(size)) for part, size in zip(parts, sizes, strict=True)]

    def _new(self, size: tuple[int, int]) -> _Textures:
        color = new_texture(self._ctx, size, 4, label="plate colour")
        return color, new_texture(self._ctx, size, 1, label="plate depth")

    def size(self, shot: Shot) -> tuple[int, int]:
        return self.held.color.size

    def check_method(self, method: Method) -> None:
        """Raise InputError for a method that needs views from many points of the lens."""
        if method.needs_scene:
            raise InputError(
                f"The method {method} needs a 3D scene, seen from many points of the lens; "
                f"{self.held.plate.path.name} is seen from one."
            )

    def look(
        self, shot: Shot, frame: int, views: int | None, is_for_file: bool = False
    ) -> Steps[Pinhole]:
        """Return the loaded plate; the caller has loaded that of `frame`."""
        yield from ()
        return self.held

    def through_lens(
        self, shot: Shot, frame: int, size: tuple[int, int], out: Texture
    ) -> Steps[None]:
        """Raise InputError, because a plate is a picture from a single point."""
        yield from ()
        self.check_method(shot.defocus.method)

    def pose_at(self, shot: Shot, frame: float) -> Pose | None:
        """Return None, because the camera of a plate is unknown."""
        return None

    def depth_m_at(self, shot: Shot, frame: float, x: int, y: int) -> float:
        """Raise InputError, because only the loaded frame is known."""
        raise InputError("No scene is loaded.")

    def pace(self, share: float) -> None:
        """See `SourceOnGpu`; a plate is not drawn."""

    def beside(self) -> "PlateOnGpu":
        """Raise InputError, because plates are not shared."""
        raise InputError("No scene is loaded.")

    def release(self) -> None:
        if self._held is not None:
            self._release_parts()
            for it in (self._held, self._held.beyond):
                if it is not None:
                    _release((it.color, it.depth))
            self._held = None


def _release(textures: _Textures) -> None:
    for texture in textures:
        texture.release()


def _depth_or_coc(plate: Plate | Pixels) -> FloatArray:
    depth = plate.depth_m if plate.depth_m is not None else plate.coc_px
    assert depth is not None
    return np.ascontiguousarray(depth, np.float32)
