"""Hold one plate on the GPU, in textures that the next plate of the same size uses again."""

import math

import numpy as np
import numpy.typing as npt

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Pixels, Plate
from heatlens.render.defocus.cutout_pass import CutoutTextures
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.context import check_storage_fits
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import FloatArray, new_texture, upload, upload_steps
from heatlens.render.source.pinhole import Pinhole

_BRIGHT_SHARE = 0.9  # share of the pixels that are darker than what counts as bright
_BRIGHT_MOST = 4.0  # bright light up to here is taken as relative to a white surface
_STEP = 16.0  # a power of two, so that scaling is exact; and coarse, so that it is steady in a shot
_SAMPLES_PER_SIDE = 128  # pixels along each side at which light is measured, about
_Textures = tuple[Texture, Texture]  # color, depth
_PartTextures = list[
    tuple[Plate, _Textures]
]  # of the plate, and of the one with a border if it is known


def light_scale(color: npt.NDArray[np.float32]) -> float:
    """Return the factor, a power of two, on the light of a picture before it is blurred.

    `color` is (H, W, 4), scene-linear. It is 1 for pictures in which a white surface is about 1,
    and less for those in physical units, such as candela per square meter, so that highlights and
    similar colors are found as in any other picture.
    """
    rows, columns = (max(1, side // _SAMPLES_PER_SIDE) for side in color.shape[:2])
    luminance = color[::rows, ::columns, :3].mean(axis=2)
    rank = int((luminance.size - 1) * _BRIGHT_SHARE)
    # np.percentile does the same, but loads a part of NumPy first, which takes longer than this.
    bright = float(np.partition(luminance, rank, axis=None)[rank])
    if bright <= _BRIGHT_MOST:
        return 1.0
    return float(_STEP ** -math.ceil(math.log(bright / _BRIGHT_MOST, _STEP)))


class PlateOnGpu:
    """Holds the plate that was loaded last, or none. Implements `SourceOnGpu`."""

    scene = None
    has_many_views = False

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._loaded: Pinhole | None = None

    @property
    def loaded(self) -> Pinhole:
        """The loaded plate. Raises InputError while there is none."""
        if self._loaded is None:
            raise InputError("No plate is loaded.")
        return self._loaded

    def load_steps(self, plate: Plate) -> Steps[Pinhole]:
        """Upload a plate to the GPU in short steps.

        If the steps are not completed, nothing is loaded.
        """
        part_textures = self._textures(plate)
        self._release_lists()
        self._loaded = None
        try:
            for part, (color, depth) in part_textures:
                for texture, pixels in ((color, part.color), (depth, _depth_or_coc(part))):
                    for _ in upload_steps(texture, pixels):
                        yield "upload"
            self._loaded = self._pinhole(plate, part_textures)
        finally:
            if self._loaded is None:
                for _, textures in part_textures:
                    _release(textures)
        return self._loaded

    def _pinhole(self, plate: Plate, part_textures: _PartTextures) -> Pinhole:
        """Return the pinhole picture of a plate whose pixels have been uploaded.

        If the plate has a border, `part_textures` ends with the plate and its border together.
        """
        scale, (widest, textures) = light_scale(plate.color), part_textures[-1]
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
            fragments = fragments.crop(plate.data_window.relative_to(widest.data_window))
        frame_textures = part_textures[0][1]
        return Pinhole(
            plate,
            *frame_textures,
            plate.bins,
            fragments,
            light_scale=scale,
            wide_pinhole=wide,
            cutout=self._cutout_of(plate, scale),
        )

    def _cutout_of(self, plate: Plate, light_scale: float) -> CutoutTextures | None:
        """Upload the part of the plate that stays sharp, with its light times `light_scale`.

        Return None if the whole plate is blurred.
        """
        if (cutout := plate.cutout) is None:
            return None
        size, share = (plate.data_window.width, plate.data_window.height), cutout.share[..., None]
        factor = np.array([light_scale] * 3 + [1.0], np.float32)

        def new_uploaded(pixels: FloatArray) -> Texture:
            """Return a texture with these pixels."""
            channels = pixels.size // (size[0] * size[1])
            texture = new_texture(self._ctx, size, channels, label="cutout")
            upload(texture, np.ascontiguousarray(pixels, np.float32))
            return texture

        light, alpha = cutout.light[..., :3] * factor[:3], cutout.light[..., 3:]
        return CutoutTextures(
            light=new_uploaded(np.concatenate([light, share], axis=-1)),
            alpha=new_uploaded(np.concatenate([alpha] * 3 + [share], axis=-1))
            if plate.has_alpha or cutout.backdrop is not None
            else None,
            depth=new_uploaded(cutout.depth),
            clean_color=new_uploaded(cutout.surroundings.color * factor),
            clean_depth=new_uploaded(_depth_or_coc(cutout.surroundings)),
            backdrop=None if cutout.backdrop is None else new_uploaded(cutout.backdrop * factor),
        )

    def _fragments_of(self, plate: Plate, light_scale: float) -> FragmentBuffers | None:
        """Upload the plate's fragment lists, with their light times `light_scale`.

        Return None if it has none. Raises GpuError if they do not fit.
        """
        if plate.fragments is None:
            return None
        lists, window = plate.fragments.scale_light(light_scale), plate.data_window
        largest = max(lists.words.nbytes, lists.starts.nbytes)
        check_storage_fits(self._ctx, largest, "surfaces behind the picture")
        return FragmentBuffers(
            starts=self._ctx.buffer(lists.starts),
            words=self._ctx.buffer(lists.words),
            size=(window.width, window.height),
            is_measured=lists.is_measured,
            is_exact=lists.is_measured,  # all surfaces of a deep file come from one render
        )

    def _release_lists(self) -> None:
        """Release fragment lists and cutouts; textures of the pictures stay for the next plate."""
        if self._loaded is None:
            return
        if self._loaded.fragments is not None:
            self._loaded.fragments.release()
        for pinhole in (self._loaded, self._loaded.wide_pinhole):
            if pinhole is not None and pinhole.cutout is not None:
                pinhole.cutout.release()

    def _textures(self, plate: Plate) -> _PartTextures:
        """Return textures for the plate and its border: the previous ones if all sizes fit."""
        parts = [item for item in (plate, plate.with_border) if item is not None]
        sizes = [(item.data_window.width, item.data_window.height) for item in parts]
        loaded = [
            item
            for item in (self._loaded, self._loaded and self._loaded.wide_pinhole)
            if item is not None
        ]
        if [item.color.size for item in loaded] == sizes:
            return [
                (part, (item.color, item.depth)) for part, item in zip(parts, loaded, strict=True)
            ]
        self.release()
        return [(part, self._new_textures(size)) for part, size in zip(parts, sizes, strict=True)]

    def _new_textures(self, size: tuple[int, int]) -> _Textures:
        """Return new textures for color and depth of a plate."""
        color = new_texture(self._ctx, size, 4, label="plate colour")
        return color, new_texture(self._ctx, size, 1, label="plate depth")

    def size(self, shot: Shot) -> tuple[int, int]:
        return self.loaded.color.size

    def check_method(self, method: Method) -> None:
        """Raise InputError for a method that needs views from many points of the lens."""
        if method.needs_scene:
            raise InputError(
                f"The method {method} needs a 3D scene, seen from many points of the lens; "
                f"{self.loaded.plate.path.name} is seen from one."
            )

    def pinhole_steps(
        self, shot: Shot, frame: int, views: int | None, is_for_file: bool = False
    ) -> Steps[Pinhole]:
        """Return the loaded plate; the caller has loaded that of `frame`."""
        yield from ()
        return self.loaded

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

    def set_step_size(self, share: float) -> None:
        """See `SourceOnGpu`; a plate is not drawn."""

    def share(self) -> "PlateOnGpu":
        """Raise InputError, because plates are not shared."""
        raise InputError("No scene is loaded.")

    def release(self) -> None:
        if self._loaded is not None:
            self._release_lists()
            for pinhole in (self._loaded, self._loaded.wide_pinhole):
                if pinhole is not None:
                    _release((pinhole.color, pinhole.depth))
            self._loaded = None


def _release(textures: _Textures) -> None:
    for texture in textures:
        texture.release()


def _depth_or_coc(plate: Plate | Pixels) -> FloatArray:
    """Return the depth in meters, or the coc of a plate without depth, (H, W) float32."""
    depth = plate.depth_m if plate.depth_m is not None else plate.coc_px
    assert depth is not None
    return np.ascontiguousarray(depth, np.float32)
