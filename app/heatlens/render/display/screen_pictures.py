"""The textures that ImGui draws: A, B and the overlay, each updated only when it has changed."""

from collections.abc import Collection

from heatlens.core.model.focus.coc import CocLine, sharp_px
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.render.defocus.focus_offset_survey import FocusOffsetSurvey
from heatlens.render.defocus.layer_cuts import layer_cuts
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.plate_passes import ProxyPass, RescalePass, proxy_size
from heatlens.render.defocus.quality import layers_for
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.display.first_uses import FirstUses
from heatlens.render.display.overlay_pass import OverlayPass
from heatlens.render.display.picture_pass import (
    CoarsePlate,
    DepthRangePass,
    Detail,
    EnlargePass,
    FocusMeanPass,
)
from heatlens.render.display.screen_frames import ScreenTransform
from heatlens.render.display.screen_target import Key, ScreenTarget
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.source.pinhole import Pinhole, optics_of, pinhole_optics

MIPMAPS_UNDER = 0.6  # screen pixels per texel below which a picture without mipmaps would alias


class ScreenPictures:
    """Converts scene-linear pictures to textures for the screen."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self.display = DisplayPass(ctx)
        self._overlays = OverlayPass(ctx)
        self._focus_offsets = FocusOffsetSurvey(ctx)
        self._proxy, self._focus_mean = ProxyPass(ctx), FocusMeanPass(ctx)
        self._depth_range = DepthRangePass(ctx)
        self._rescale = RescalePass(ctx)
        # The plate and size of which the texture "coarse plate" holds the mean.
        self._coarse_plate_key: tuple[Pinhole, tuple[int, int]] | None = None
        self._sharpen_for_enlarging = EnlargePass(ctx)
        self._pool = TexturePool(ctx)
        self._previous_plate: Pinhole | None = None  # the plate of the previous preview
        self._first_details, self._first_picture = FirstUses(), FirstUses()
        self._a = ScreenTarget(ctx, "A on the screen")
        self._b = ScreenTarget(ctx, "B on the screen")
        self._pinhole = ScreenTarget(ctx, "plate on the screen")
        self._fine = ScreenTarget(ctx, "plate at the size of the picture at rest")
        self._coarse = ScreenTarget(ctx, "plate at the preview's size")
        self._overlay = ScreenTarget(ctx, "overlay")
        self._tiles: dict[str, ScreenTarget] = {}  # pictures of looks by name
        self.transform_version = 0  # increased by the caller with each new view transform
        self.with_mipmaps = False  # True if pictures are so small that they would alias

    def take_request(self) -> bool:
        """Return True, once, if another frame should use further passes for the first time."""
        return any([uses.take_request() for uses in (self._first_details, self._first_picture)])

    def prepare(self) -> None:
        """Use the passes of a first preview before there is one, spread over frames."""
        size = 5, 3  # as of most pictures no power of two, for which drivers build another program
        light = self._pool.texture("no light", size, 4)
        small = self._pool.texture("no light small", size, 4, "f2")
        passes = (
            lambda: self.display.run(light, small, is_preview=True),
            lambda: self._sharpen_for_enlarging.run(small, self._a.resized(size)),
        )
        self._first_picture.run(passes)

    def a(
        self, shown: ShownPicture, version: object, plate: Pinhole, view: ViewState, b: Texture
    ) -> Texture:
        """Return A: the picture through the lens, the pinhole picture, or A's difference from B.

        `version` changes with the content of `shown`. `b` is the scene-linear picture of side B.
        """
        source = shown.texture if view.depth_of_field else plate.color
        transform = self._screen_transform(view)
        is_difference = view.compare is Compare.DIFFERENCE
        key: Key = (version, plate, view.depth_of_field, transform)
        key += (is_difference, view.difference_gain, b) if is_difference else ()
        if self._a.needs_update(source.size, key):
            out = self._a.texture
            assert out is not None
            if is_difference:
                self.display.run_difference(
                    source, b, out, transform.exposure_stops, transform.gamma, view.difference_gain
                )
            else:
                is_enlarged = view.depth_of_field and _is_reduced_preview(shown)
                self._display(source, out, transform, is_enlarged)
            self._update_mipmaps(out)
        assert self._a.texture is not None
        return self._a.texture

    def b(
        self, source: Texture, plate: Pinhole, view: ViewState, version: object = None
    ) -> Texture:
        """Return B: the pinhole picture, the reference, or the picture of another method.

        `source` is its scene-linear light, whose content changes with `version`.
        """
        is_pinhole = source is plate.color
        target = self._pinhole if is_pinhole else self._b
        transform = self._screen_transform(view)
        content = plate if is_pinhole else (source, version)
        if target.needs_update(source.size, (content, transform)):
            assert target.texture is not None
            self._display(source, target.texture, transform, is_enlarged=False)
            self._update_mipmaps(target.texture)
        assert target.texture is not None
        return target.texture

    def tile(self, name: str, shown: ShownPicture, view: ViewState) -> Texture:
        """Return the picture of a look, for showing several looks at once."""
        target = self._tiles.setdefault(name, ScreenTarget(self._ctx, "a look on the screen"))
        transform = self._screen_transform(view)
        if target.needs_update(shown.texture.size, (shown, transform)):
            assert target.texture is not None
            self._display(shown.texture, target.texture, transform, is_enlarged=False)
            self._update_mipmaps(target.texture)
        assert target.texture is not None
        return target.texture

    def draw_still(self, reused: Texture | None, light: Texture, view: ViewState) -> Texture:
        """Return a small scene-linear picture as the screen shows it, in `reused` if given."""
        out = reused or self._ctx.texture(light.size, 4)
        self.display.run(light, out, view.exposure_stops, view.gamma)
        return out

    def keep_tiles(self, names: Collection[str]) -> None:
        """Free the pictures of all other looks."""
        for name in [name for name in self._tiles if name not in names]:
            texture = self._tiles.pop(name).texture
            if texture is not None:
                texture.release()

    def detail(self, shown: ShownPicture, plate: Pinhole, view: ViewState) -> Detail | None:
        """Return the detail in focus that a preview lacks.

        None if the preview is whole, for a new plate, and before all passes of it were used.
        """
        if not _is_reduced_preview(shown) or shown.shot.lens.breathing != 1.0:
            return None  # breathing scales the picture relative to the plate
        if self._previous_plate is not plate:  # in playback, each plate is shown only once
            self._previous_plate = plate
            return None
        proxy, lens = shown.settings.proxy, shown.shot.lens_at(shown.frame)
        optics = optics_of(plate.plate, plate.bins, lens)
        size = proxy_size(plate.color.size, proxy)
        passes = (
            lambda: self._fine_plate(plate, shown.shot.defocus.proxy, view),
            lambda: self._reduced_with_range(plate, size, shown.diffused),
            lambda: self._coarse_plate(plate, shown, view, optics.line),
        )
        if not self._first_details.run(passes):
            return None
        fine = self._fine_plate(plate, shown.shot.defocus.proxy, view)
        shares, coarse = self._coarse_plate(plate, shown, view, optics.line)
        return Detail(fine, coarse, shares, plate.depth, optics.line, 1.0 / proxy)

    def _fine_plate(self, plate: Pinhole, proxy: float, view: ViewState) -> Texture:
        """Return the plate as display values, at the size of the picture at rest."""
        if proxy == 1.0:
            return self.b(plate.color, plate, view)
        size = proxy_size(plate.color.size, proxy)
        transform = self._screen_transform(view)
        target = self._fine
        if target.needs_update(size, (plate, transform)):
            assert target.texture is not None
            reduced = self._reduce_plate("fine plate", plate, size)
            self._display(reduced, target.texture, transform, is_enlarged=False)
            self._update_mipmaps(target.texture)
        assert target.texture is not None
        return target.texture

    def _coarse_plate(
        self, plate: Pinhole, shown: ShownPicture, view: ViewState, line: CocLine | None
    ) -> tuple[Texture, Texture]:
        """Return the part of the plate in focus as a preview has it, as light and display values.

        The light has the share of the detail as its alpha. A preview that was enlarged for its
        highlights is matched by a plate enlarged likewise.
        """
        size = proxy_size(plate.color.size, shown.settings.proxy)
        transform = self._screen_transform(view)
        focused = self._pool.texture("coarse plate in focus", size, 4)
        target = self._coarse
        if target.needs_update(shown.texture.size, (plate, shown, transform, line)):
            coarse = self._reduced_with_range(plate, size, shown.diffused)
            self._focus_mean.run(plate.color, plate.depth, line, coarse, focused)
            light = focused
            if shown.texture.size != size:
                light = self._pool.texture("enlarged", shown.texture.size, 4)
                self._rescale.enlarge(focused, light)
            assert target.texture is not None
            self._display(light, target.texture, transform, is_enlarged=True)
            self._update_mipmaps(target.texture)
        assert target.texture is not None
        return focused, target.texture

    def _reduced_with_range(
        self, plate: Pinhole, size: tuple[int, int], diffused: Texture | None
    ) -> CoarsePlate:
        """Return the plate at the size of a preview; it is kept while both are the same."""
        depth_range = self._pool.texture("depths under a pixel", size, 4)
        if self._coarse_plate_key != (plate, size):
            self._reduce_plate("coarse plate", plate, size)
            self._depth_range.run(plate.depth, depth_range)
            self._coarse_plate_key = plate, size
        mean = self._pool.texture("coarse plate", size, 4)
        is_same_light = diffused is not None and diffused.size == size and plate.cutout is None
        return CoarsePlate(
            mean, depth_range, diffused if is_same_light else None, plate.light_scale
        )

    def _reduce_plate(self, name: str, plate: Pinhole, size: tuple[int, int]) -> Texture:
        """Return the plate at a smaller size, in the texture called `name`."""
        color = self._pool.texture(name, size, 4)
        depth = self._pool.texture(f"depth of {name}", size, 1)
        self._proxy.run(plate.color, plate.depth, 1.0, color, depth)
        return color

    def _display(
        self, source: Texture, out: Texture, transform: ScreenTransform, is_enlarged: bool
    ) -> None:
        """Write display values to `out`, sharpened if the screen will enlarge them.

        The screen enlarges a small preview bilinearly, which softens it.
        """
        if not is_enlarged:
            self.display.run(source, out, transform.exposure_stops, transform.gamma)
            return
        small = self._pool.texture("shown small", source.size, 4, "f2")
        self.display.run(source, small, transform.exposure_stops, transform.gamma, is_preview=True)
        self._sharpen_for_enlarging.run(small, out)

    def _screen_transform(self, view: ViewState) -> ScreenTransform:
        """Return everything besides the light that decides how a picture looks on the screen."""
        return ScreenTransform(
            view.exposure_stops, view.gamma, self.transform_version, self.with_mipmaps
        )

    def _update_mipmaps(self, texture: Texture) -> None:
        """Build the smaller levels of a texture that may be drawn much smaller."""
        if self.with_mipmaps:
            texture.build_mipmaps()

    def overlay(
        self, plate: Pinhole, shot: Shot, frame: int, view: ViewState, shown: ShownPicture
    ) -> Texture:
        """Return the colors of the overlay and the peaking for the current lens.

        Peaking finds its edges in the picture that is `shown`, if that is not a preview.
        """
        lens, is_peaking = shot.lens_at(frame), view.is_peaking
        is_frame_shown = shown.is_whole and lens.breathing == 1.0  # pixel for pixel
        light = shown.texture if is_peaking and is_frame_shown else plate.color
        key: Key = (plate, lens, shot.defocus, view.overlay, self.transform_version)
        peaking = view.peaking if is_peaking else None
        key += (peaking, light, shown) if is_peaking else ()
        if self._overlay.needs_update(plate.depth.size, key):
            out = self._overlay.texture
            assert out is not None
            optics = pinhole_optics(self._focus_offsets, plate, lens)
            limits = layer_limits_px(optics, shot)
            sharp = sharp_px(lens, plate.plate.display_window.width)
            self._overlays.run(
                view.overlay, plate.depth, optics, sharp, limits, out, light, peaking
            )
        assert self._overlay.texture is not None
        return self._overlay.texture


def _is_reduced_preview(shown: ShownPicture) -> bool:
    """Return True for a preview that is smaller than the final picture."""
    return shown.settings.proxy < shown.shot.defocus.proxy


def layer_limits_px(optics: Optics, shot: Shot) -> tuple[float, ...]:
    """Return the signed diameters between the layers of a shot, ascending."""
    cuts = layer_cuts(optics.occupied_px, optics.gaps_px, layers_for(shot.defocus))
    return tuple(sorted(cut.near.at_px for cut in cuts if not cut.is_nearest))


def picture_of_b(
    view: ViewState,
    plate: Pinhole,
    file_picture: Texture | None,
    method_picture: ShownPicture | None,
) -> Texture:
    """Return the picture of side B: the chosen one if available, else the pinhole picture.

    `file_picture` is a reference, or a channel of the plate.
    """
    if method_picture is not None:
        return method_picture.texture
    if view.against in (Against.REFERENCE, Against.CHANNEL) and file_picture is not None:
        return file_picture
    return plate.color
