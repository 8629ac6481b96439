"""Convert a scene-linear picture to display values: exposure, view transform, gamma."""

from collections import OrderedDict
from functools import cached_property

import numpy as np

from heatlens.media.color.view_table import PREVIEW_SIDE, SIDE, as_table
from heatlens.media.color.view_transform import Lut, ViewTransform, srgb_transform
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Image, Sampling, Texture, Texture3D

_PICTURE = "display/display.comp.glsl"
_DIFFERENCE = "display/display_difference.comp.glsl"
_TRANSFORMS_MAX = 6  # transforms whose programs stay compiled, for switching back quickly


class _BuiltTransform:
    """A transform on the GPU: its tables, and a program for each shader that was used."""

    def __init__(self, ctx: Device, transform: ViewTransform, is_preview: bool = False) -> None:
        self._ctx, self._transform = ctx, transform
        side = _table_side(ctx, transform, is_preview)
        if side is not None:
            transform = as_table(transform, side)
        self._functions = transform.glsl
        self._programs: dict[str, ComputeProgram] = {}
        self.program(_PICTURE).link()  # now, so that GLSL errors are raised at once
        self.luts: dict[str, Image] = {
            lut.sampler: _make_lut_texture(ctx, lut) for lut in transform.luts
        }

    @cached_property
    def of_previews(self) -> "_BuiltTransform":
        """The same transform, where a processor draws from a small table of it."""
        has_own = _table_side(self._ctx, self._transform, True) == PREVIEW_SIDE
        return _BuiltTransform(self._ctx, self._transform, True) if has_own else self

    def program(self, name: str) -> ComputeProgram:
        """Return the shader `name` with the transform's functions, compiled on first use."""
        if name not in self._programs:
            self._programs[name] = ComputeProgram(self._ctx, name, functions=self._functions)
        return self._programs[name]

    def release(self) -> None:
        """Release programs and tables."""
        if self.__dict__.get("of_previews", self) is not self:
            self.of_previews.release()
        for resource in (*self._programs.values(), *self.luts.values()):
            resource.release()


# A processor takes 14 ms for 480x270 pixels of the ACES 2.0 view, and 5 ms for a table of it. Each
# picture of a drag shows two such.
def _table_side(ctx: Device, transform: ViewTransform, is_preview: bool) -> int | None:
    """Return the side of the table that a transform is drawn from; None: from its own GLSL."""
    if transform.key == srgb_transform().key:
        return None
    if is_preview and ctx.is_software:
        return PREVIEW_SIDE
    return None if ctx.compiles_views else SIDE


class DisplayPass:
    """Converts scene-linear premultiplied RGBA to display values over black.

    It starts with the plain sRGB curve. Exposure and gamma are uniforms; only a new transform has
    to be compiled.
    """

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._transforms: OrderedDict[str, _BuiltTransform] = OrderedDict()  # latest used last
        self.set_transform(srgb_transform())

    def set_transform(self, transform: ViewTransform) -> None:
        """Draw with `transform` from now on. Raises ShaderError if the driver rejects it."""
        if transform.key not in self._transforms:
            self._transforms[transform.key] = _BuiltTransform(self._ctx, transform)
        self._transforms.move_to_end(transform.key)
        if len(self._transforms) > _TRANSFORMS_MAX:
            self._transforms.popitem(last=False)[1].release()
        self._current = self._transforms[transform.key]

    def run(
        self,
        picture: Texture,
        out: Texture,
        exposure_stops: float = 0.0,
        gamma: float = 1.0,
        is_preview: bool = False,
    ) -> None:
        """Write `picture` to `out` of the same size, RGBA of 8 bits (or float, not clamped).

        Where a processor draws, extreme colors of previews are off by up to 0.03.
        """
        uniforms = _view_uniforms(exposure_stops, gamma)
        built = self._current.of_previews if is_preview else self._current
        _draw(built, _PICTURE, {"picture_tx": picture}, out, uniforms)

    def run_difference(
        self,
        a: Texture,
        b: Texture,
        out: Texture,
        exposure_stops: float = 0.0,
        gamma: float = 1.0,
        gain: float = 1.0,
    ) -> None:
        """Write |a - b| * gain, computed in scene-linear light, to `out` of the size of `a`.

        If `b` has another size, it is stretched over `a`.
        """
        textures: dict[str, Image] = {"a_tx": a, "b_tx": b}
        uniforms = _view_uniforms(exposure_stops, gamma) | {"gain": gain}
        _draw(self._current, _DIFFERENCE, textures, out, uniforms)

    def release(self) -> None:
        """Delete all programs and tables."""
        while self._transforms:
            self._transforms.popitem()[1].release()


def _draw(
    built: _BuiltTransform,
    name: str,
    textures: dict[str, Image],
    out: Texture,
    uniforms: dict[str, object],
) -> None:
    """Run the shader `name` with a transform over all pixels of `out`."""
    built.program(name).dispatch(
        pixel_groups(out.size),
        textures=textures | built.luts,
        images={"out_display_img": out},
        uniforms=uniforms,
    )


def _view_uniforms(exposure_stops: float, gamma: float) -> dict[str, object]:
    """Return the uniforms of lib/view.lib.glsl."""
    return {"exposure_scale": 2.0**exposure_stops, "inverse_gamma": 1.0 / gamma}


def _make_lut_texture(ctx: Device, lut: Lut) -> Image:
    """Return a table of a view transform as a texture in two or three dimensions."""
    data = np.ascontiguousarray(lut.values).tobytes()
    texture: Texture | Texture3D
    if lut.values.ndim == 4:
        depth, height, width, components = lut.values.shape
        texture = ctx.texture3d((width, height, depth), components, data, dtype="f4")
    else:
        height, width, components = (*lut.values.shape, 1)[:3]
        texture = ctx.texture((width, height), components, data, dtype="f4")
    texture.sampling = Sampling.LINEAR if lut.is_linear else Sampling.NEAREST
    texture.repeats = False
    return texture
