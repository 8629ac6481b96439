"""OpenGL 4.3 by moderngl as a device, without a window (by EGL) or in that of the program.

New textures and buffers can be filled with NaN, to find passes that read before they write: Mesa's
llvmpipe returns zeroed memory, other drivers old contents. With HEATLENS_FILL_NAN=1 in the
environment, such a mistake is visible in every picture and test.
"""

import os
import sys
from collections.abc import Sequence
from typing import Any

import moderngl

from heatlens.core.base.errors import GpuError
from heatlens.core.base.log import LOG
from heatlens.core.base.stopping import delay_interrupts
from heatlens.core.base.system_packages import driver_advice, opengl_advice
from heatlens.render.gpu.device import Device, Limits, Timer
from heatlens.render.gpu.framebuffer import Blend, DepthTest, Framebuffer
from heatlens.render.gpu.opengl.objects import (
    GlBuffer,
    GlDepthBuffer,
    GlFramebuffer,
    GlTexture,
    GlTexture3D,
    GlTextureArray,
)
from heatlens.render.gpu.opengl.programs import GlCompute, GlDraw
from heatlens.render.gpu.resources import Data, DepthBuffer, Sampling, Texture
from heatlens.render.gpu.shader_source import ShaderSource

NAN_VARIABLE = "HEATLENS_FILL_NAN"
# Reaches glcontext, whose wheels have EGL on Linux alone. moderngl's stub has no name for it.
_WITHOUT_DISPLAY: dict[str, Any] = {"backend": "egl"} if sys.platform == "linux" else {}
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader")
# Straight alpha over the content below; the screen stays opaque, so the desktop never shows.
_BLENDS: dict[Blend, tuple[int, ...]] = {
    Blend.ADD: (moderngl.ONE, moderngl.ONE),
    Blend.OVER: (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ZERO, moderngl.ONE),
}
# moderngl's names of the comparisons; "1" is always true.
_COMPARISONS = {
    DepthTest.LESS: "<",
    DepthTest.EQUAL: "==",
    DepthTest.AT_MOST: "<=",
    DepthTest.ALWAYS: "1",
}


class GlDevice(Device):
    """A context of OpenGL; `Device` says what its methods do."""

    library = "OpenGL"

    def __init__(self, raw: moderngl.Context) -> None:
        self.raw: Any = raw  # the stub of moderngl misses what it takes
        info = raw.info
        self.name, self.vendor = str(info["GL_RENDERER"]), str(info["GL_VENDOR"])
        self.version = str(info["GL_VERSION"])
        self.limits = Limits(
            texture_side_px=int(info["GL_MAX_TEXTURE_SIZE"]),
            storage_block_bytes=int(info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]),
            group_invocations=int(info["GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS"]),
        )
        self.is_software = any(name in self.name.lower() for name in _SOFTWARE)
        LOG.debug("device: %s, %s, OpenGL %s", self.name, self.vendor, self.version)
        self.fills_nan = bool(os.environ.get(NAN_VARIABLE))
        self._screen: GlFramebuffer | None = None

    @property
    def error(self) -> str:
        error = str(self.raw.error)
        return "" if error == "GL_NO_ERROR" else error

    @property
    def screen(self) -> Framebuffer:
        """The window."""
        if self._screen is None:
            self._screen = GlFramebuffer(self.raw.screen)
        return self._screen

    def texture(
        self, size: tuple[int, int], components: int, data: Data | None = None, dtype: str = "f1"
    ) -> GlTexture:
        texture = GlTexture(self.raw.texture(size, components, data, dtype=dtype))
        if self.fills_nan and data is None:
            texture.fill_with_nan()
        return texture

    def texture_array(
        self,
        size: tuple[int, int, int],
        components: int,
        data: Data | None = None,
        dtype: str = "f1",
    ) -> GlTextureArray:
        array = GlTextureArray(self.raw.texture_array(size, components, data, dtype=dtype))
        if self.fills_nan and data is None:
            array.fill_with_nan()
        return array

    def texture3d(
        self,
        size: tuple[int, int, int],
        components: int,
        data: Data | None = None,
        dtype: str = "f1",
    ) -> GlTexture3D:
        texture = GlTexture3D(self.raw.texture3d(size, components, data, dtype=dtype))
        if self.fills_nan and data is None:
            texture.fill_with_nan()
        return texture

    def shadow_map(self, size: tuple[int, int]) -> GlTexture:
        raw = self.raw.depth_texture(size)
        raw.compare_func = "<="
        texture = GlTexture(raw)
        texture.sampling, texture.repeats = Sampling.LINEAR, False
        return texture

    def depth_buffer(self, size: tuple[int, int]) -> GlDepthBuffer:
        return GlDepthBuffer(self.raw.depth_renderbuffer(size))

    def buffer(self, data: Data | None = None, reserve: int = 0) -> GlBuffer:
        buffer = GlBuffer(self.raw.buffer(data, reserve=reserve), self.fills_nan)
        if self.fills_nan and data is None:
            buffer.fill_with_nan()
        return buffer

    def framebuffer(
        self, colors: Sequence[Texture] = (), depth: DepthBuffer | Texture | None = None
    ) -> GlFramebuffer:
        raw_depth = None if depth is None else _raw(depth)
        return GlFramebuffer(
            self.raw.framebuffer([_raw(color) for color in colors], raw_depth), colors
        )

    def simple_framebuffer(self, size: tuple[int, int]) -> GlFramebuffer:
        return GlFramebuffer(self.raw.simple_framebuffer(size))

    def copy_framebuffer(self, target: Framebuffer, source: Framebuffer) -> None:
        self.raw.copy_framebuffer(_raw(target), _raw(source))

    def compute_program(self, source: ShaderSource) -> GlCompute:
        return GlCompute(self.raw, source)

    def draw_program(self, vertex: ShaderSource, fragment: ShaderSource) -> GlDraw:
        return GlDraw(self.raw, vertex, fragment)

    def draw_with(self, blend: Blend = Blend.NONE, depth: DepthTest = DepthTest.NONE) -> None:
        flags: int = moderngl.NOTHING
        if blend is not Blend.NONE:
            flags |= moderngl.BLEND
            self.raw.blend_func = _BLENDS[blend]
        if depth is not DepthTest.NONE:
            flags |= moderngl.DEPTH_TEST
            self.raw.depth_func = _COMPARISONS[depth]
        self.raw.enable_only(flags)

    def timer(self) -> Timer:
        return _GlTimer(self.raw.query(time=True))

    def finish(self) -> None:
        self.raw.finish()

    def make_current(self) -> None:
        self.raw.__enter__()

    def release(self) -> None:
        self.raw.release()


class _GlTimer(Timer):
    """A query of OpenGL for the time."""

    def __init__(self, query: Any) -> None:
        self._query, self.seconds = query, 0.0

    def __enter__(self) -> Timer:
        self._query.__enter__()
        return self

    def __exit__(self, *failed: object) -> None:
        self._query.__exit__(*failed)
        self.seconds = self._query.elapsed * 1e-9


def _raw(wrapper: Any) -> Any:
    """Return the object of moderngl that a texture, buffer or framebuffer wraps."""
    return wrapper.raw


def headless_device() -> GlDevice:
    """Make a device that needs no window. Raises GpuError that says what to install."""
    try:
        with delay_interrupts():
            context = moderngl.create_context(standalone=True, require=430, **_WITHOUT_DISPLAY)
        return GlDevice(context)
    except Exception as error:  # moderngl and glcontext raise bare Exception
        raise GpuError(f"No OpenGL 4.3 ({error}). {_help(str(error))}") from error


def _help(error_text: str) -> str:
    """Return what to install, or what to try if the installed driver is too old."""
    if "device index" in error_text:
        return "--device counts the devices of EGL from 0."
    is_old = "eglCreateContext" in error_text or "got version" in error_text
    return f"{driver_advice() if is_old else opengl_advice()}."


def window_device() -> GlDevice:
    """Return the device of the current window."""
    with delay_interrupts():
        context = moderngl.create_context(require=430)
    return GlDevice(context)
