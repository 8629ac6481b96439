"""The textures that ImGui draws: A, B and the overlay, each drawn again only when it changed."""

import moderngl

from heatlens.defocus.layer_cuts import layer_cuts
from heatlens.defocus.optics import Optics
from heatlens.defocus.quality import layers_for
from heatlens.display.display_pass import DisplayPass
from heatlens.display.overlay_pass import OverlayPass
from heatlens.display.sharp_pass import SharpPass
from heatlens.model.coc import sharp_px
from heatlens.model.shot import Shot
from heatlens.model.view import Against, Compare, Overlay, ViewState
from heatlens.render import LoadedPlate, optics_of
from heatlens.ui.picture.live_picture import Shown

Key = tuple[object, ...]


class _Target:
    """An 8-bit texture that knows what it holds."""

    def __init__(self, ctx: moderngl.Context, label: str) -> None:
        self._ctx = ctx
        self._label = label
        self._key: Key | None = None
        self.texture: moderngl.Texture | None = None

    def needs(self, size: tuple[int, int], key: Key) -> bool:
        """Take `size`; True where what the texture holds is not `key`."""
        if self.texture is None or self.texture.size != size:
            if self.texture is not None:
                self.texture.release()
            self.texture = self._ctx.texture(size, 4)
            self.texture.build_mipmaps()  # without all levels a texture that asks for them is black
            self.texture.repeat_x = self.texture.repeat_y = False
            self.texture.label = self._label
            self._key = None
        changed, self._key = self._key != key, key
        return changed


class ScreenPictures:
    """Linear pictures in, display pictures out."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self.display = DisplayPass(ctx)
        self._overlays = OverlayPass(ctx)
        self._sharp_pass = SharpPass(ctx)
        self._sharp_of: LoadedPlate | None = None  # the plate of the hurried picture before
        self._a = _Target(ctx, "A on the screen")
        self._b = _Target(ctx, "B on the screen")
        self._pinhole = _Target(ctx, "plate on the screen")
        self._sharp = _Target(ctx, "what is sharp")
        self._overlay = _Target(ctx, "overlay")
        self.transform_version = 0  # whoever sets another view transform counts it up
        self.with_mipmaps = False  # pictures are seen so small that they would shimmer without

    def a(
        self, shown: Shown, version: int, plate: LoadedPlate, view: ViewState, b: moderngl.Texture
    ) -> moderngl.Texture:
        """A: the picture through the lens, the pinhole picture, or A's difference from B."""
        source = shown.texture if view.depth_of_field else plate.color
        look = self._look(view)
        is_difference = view.compare is Compare.DIFFERENCE
        key: Key = (version, plate, view.depth_of_field, look)
        key += (is_difference, view.difference_gain, b) if is_difference else ()
        if self._a.needs(source.size, key):
            out = self._a.texture
            assert out is not None
            if is_difference:
                self.display.run_difference(source, b, out, *look[:2], view.difference_gain)
            else:
                self.display.run(source, out, *look[:2])
            self._finish(out)
        assert self._a.texture is not None
        return self._a.texture

    def b(
        self, source: moderngl.Texture, plate: LoadedPlate, view: ViewState, version: int = 0
    ) -> moderngl.Texture:
        """B: the pinhole picture, the reference, or another method's picture of that version."""
        is_pinhole = source is plate.color
        target = self._pinhole if is_pinhole else self._b
        look = self._look(view)
        if target.needs(source.size, (plate if is_pinhole else (source, version), look)):
            assert target.texture is not None
            self.display.run(source, target.texture, *look[:2])
            self._finish(target.texture)
        assert target.texture is not None
        return target.texture

    def sharp(self, shown: Shown, plate: LoadedPlate, view: ViewState) -> moderngl.Texture | None:
        """What is in focus, to lie over a hurried picture; None where that is as sharp itself.

        With several layers a foreground may lie over what is in focus: then the preview is right.
        """
        proxy = shown.settings.proxy
        if proxy >= shown.shot.defocus.proxy or layers_for(shown.settings) > 1:
            return None
        if self._sharp_of is not plate:  # while a sequence plays, each plate is seen only once
            self._sharp_of = plate
            return None
        pinhole = self.b(plate.color, plate, view)
        key = (plate, shown.shot.lens_at(shown.frame), proxy, self._look(view))
        if self._sharp.needs(plate.depth.size, key):
            assert self._sharp.texture is not None
            optics = optics_of(plate.plate, plate.occupied, shown.shot.lens_at(shown.frame))
            self._sharp_pass.run(pinhole, plate.depth, optics, proxy, self._sharp.texture)
            self._finish(self._sharp.texture)
        return self._sharp.texture

    def _look(self, view: ViewState) -> tuple[float, float, int, bool]:
        return view.exposure_stops, view.gamma, self.transform_version, self.with_mipmaps

    def _finish(self, texture: moderngl.Texture) -> None:
        if self.with_mipmaps:
            texture.build_mipmaps()

    def overlay(
        self, plate: LoadedPlate, shot: Shot, frame: int, overlay: Overlay
    ) -> moderngl.Texture:
        """The overlay's colours, for the lens as it is now."""
        lens = shot.lens_at(frame)
        if self._overlay.needs(plate.depth.size, (plate, lens, shot.defocus, overlay)):
            assert self._overlay.texture is not None
            optics = optics_of(plate.plate, plate.occupied, lens)
            limits = layer_limits_px(optics, shot)
            sharp = sharp_px(lens, plate.plate.display_window.width)
            self._overlays.run(overlay, plate.depth, optics, sharp, limits, self._overlay.texture)
        assert self._overlay.texture is not None
        return self._overlay.texture


def layer_limits_px(optics: Optics, shot: Shot) -> tuple[float, ...]:
    """The signed diameters between the layers of a shot, ascending."""
    cuts = layer_cuts(optics.occupied_px, layers_for(shot.defocus))
    return tuple(sorted(cut.near.at_px for cut in cuts if not cut.is_nearest))


def picture_of_b(
    view: ViewState,
    plate: LoadedPlate,
    reference: moderngl.Texture | None,
    of_method: Shown | None,
) -> moderngl.Texture:
    """What B is, the pinhole picture where it is to be nothing else or that is not there."""
    if of_method is not None:
        return of_method.texture
    if view.against is Against.REFERENCE and reference is not None:
        return reference
    return plate.color
