"""wgpu (Vulkan, Metal, Direct3D 12) as a device, for pictures without a window and for windows."""

import os
import time
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, TypeVar

import wgpu

from heatlens.core.base.errors import GpuError
from heatlens.media.files.quiet import mute_libraries
from heatlens.render.gpu.device import Device, Limits, Timer
from heatlens.render.gpu.framebuffer import Blend, DepthTest, Framebuffer
from heatlens.render.gpu.resources import Data, DepthBuffer, Sampled, Texture
from heatlens.render.gpu.shader_source import ShaderSource
from heatlens.render.gpu.wgpu.area_clear import AreaClear
from heatlens.render.gpu.wgpu.buffers import WgBuffer
from heatlens.render.gpu.wgpu.clipped_triangles import ClippedTriangles
from heatlens.render.gpu.wgpu.framebuffers import WgFramebuffer
from heatlens.render.gpu.wgpu.linked import Shared
from heatlens.render.gpu.wgpu.native_library import import_native_library
from heatlens.render.gpu.wgpu.programs import WgCompute, WgDraw
from heatlens.render.gpu.wgpu.recorder import Recorder
from heatlens.render.gpu.wgpu.spirv import has_compiler
from heatlens.render.gpu.wgpu.surface import WgSurface
from heatlens.render.gpu.wgpu.textures import (
    WgDepthBuffer,
    WgShadowMap,
    WgTexture,
    WgTexture3D,
    WgTextureArray,
    bytes_of,
)

# Images that are read and written in one dispatch, filtered and blended 32-bit floats.
_FEATURES = (
    "texture-adapter-specific-format-features",
    "float32-filterable",
    "float32-blendable",
    "primitive-index",
    "shader-primitive-index",
    "indirect-first-instance",
)
_LIMITS = (
    "max-buffer-size",
    "max-storage-buffer-binding-size",
    "max-storage-buffers-per-shader-stage",
    "max-storage-textures-per-shader-stage",
    "max-sampled-textures-per-shader-stage",
    "max-samplers-per-shader-stage",
    "max-compute-invocations-per-workgroup",
    "max-compute-workgroup-size-x",
    "max-compute-workgroup-storage-size",
    "max-color-attachment-bytes-per-sample",
    "max-texture-dimension-2d",
)


Made = TypeVar("Made", bound=Sampled)


class WgDevice(Device):
    """A device of wgpu."""

    library = "wgpu"

    def __init__(self, adapter: Any, fills_nan: bool = False) -> None:
        info, limits = adapter.info, adapter.limits
        self.raw: Any = adapter.request_device_sync(
            required_features=[name for name in _FEATURES if name in adapter.features],
            required_limits={name: limits[name] for name in _LIMITS if name in limits},
        )
        self.name, self.vendor = str(info["device"]), str(info["vendor"])
        self.version = f"{info['backend_type']}, {info['description']}"
        self.limits = Limits(
            texture_side_px=int(limits["max-texture-dimension-2d"]),
            storage_block_bytes=int(limits["max-storage-buffer-binding-size"]),
            group_invocations=int(limits["max-compute-invocations-per-workgroup"]),
        )
        self.is_software = info["adapter_type"] == "CPU"
        self.fills_nan = fills_nan
        self._recorder = Recorder(self.raw)
        self._area_clear = AreaClear(self._recorder)
        self._shared = Shared(self._recorder)

    @property
    def error(self) -> str:
        """Nothing: wgpu raises its errors."""
        return ""

    @property
    def compiles_views(self) -> bool:
        return has_compiler()

    def texture(
        self, size: tuple[int, int], components: int, data: Data | None = None, dtype: str = "f1"
    ) -> WgTexture:
        return self._filled(WgTexture(self._recorder, size, components, dtype), data)

    def texture_array(
        self,
        size: tuple[int, int, int],
        components: int,
        data: Data | None = None,
        dtype: str = "f1",
    ) -> WgTextureArray:
        return self._filled(WgTextureArray(self._recorder, size, components, dtype), data)

    def texture3d(
        self,
        size: tuple[int, int, int],
        components: int,
        data: Data | None = None,
        dtype: str = "f1",
    ) -> WgTexture3D:
        return self._filled(WgTexture3D(self._recorder, size, components, dtype), data)

    def _filled(self, texture: Made, data: Data | None) -> Made:
        """Return a new texture with its content."""
        if data is not None:
            texture.write(data)
        elif self.fills_nan:
            texture.fill_with_nan()
        return texture

    def shadow_map(self, size: tuple[int, int]) -> WgTexture:
        return WgShadowMap(self._recorder, size)

    def depth_buffer(self, size: tuple[int, int]) -> WgDepthBuffer:
        return WgDepthBuffer(self._recorder, size)

    def buffer(self, data: Data | None = None, reserve: int = 0) -> WgBuffer:
        size = reserve if data is None else bytes_of(data).nbytes
        buffer = WgBuffer(self._recorder, size, self.fills_nan)
        if data is not None:
            buffer.write(data)
        return buffer

    def framebuffer(
        self, colors: Sequence[Texture] = (), depth: DepthBuffer | Texture | None = None
    ) -> WgFramebuffer:
        state = self._shared.draw_state
        return WgFramebuffer(self._recorder, state, self._area_clear, colors, depth)

    def simple_framebuffer(self, size: tuple[int, int]) -> WgFramebuffer:
        return self.framebuffer([self.texture(size, 4)], self.depth_buffer(size))

    def copy_framebuffer(self, target: Framebuffer, source: Framebuffer) -> None:
        assert isinstance(target, WgFramebuffer) and isinstance(source, WgFramebuffer)
        place, other = ({"texture": one.textures[0].raw} for one in (source, target))
        self._recorder.encoder().copy_texture_to_texture(place, other, (*source.size, 1))

    def compute_program(self, source: ShaderSource) -> WgCompute:
        """Build a compute program. Raises ShaderError with the compiler's log."""
        return WgCompute(self._shared, source)

    def draw_program(self, vertex: ShaderSource, fragment: ShaderSource) -> WgDraw:
        """Build a program that draws. Raises ShaderError with the compiler's log."""
        return WgDraw(self._shared, vertex, fragment)

    def draw_with(self, blend: Blend = Blend.NONE, depth: DepthTest = DepthTest.NONE) -> None:
        self._shared.draw_state.blend, self._shared.draw_state.depth = blend, depth

    def timer(self) -> Timer:
        """Return a timer, which waits for the device at both ends."""
        return _WgTimer(self)

    def finish(self) -> None:
        self._recorder.finish()

    def surface(self, present_info: Mapping[str, object], waits: bool) -> WgSurface:
        """Return the pixels of a window, which `present_info` names; see there."""
        return WgSurface(self._recorder, present_info, waits)

    def clipped_triangles(self) -> ClippedTriangles:
        """Return what draws the triangles of an interface."""
        return ClippedTriangles(self._recorder)

    def make_current(self) -> None:
        """Do nothing: each call names its device."""

    def release(self) -> None:
        self._recorder.finish()
        self._recorder.release()
        self.raw.destroy()


class _WgTimer(Timer):
    """Measures by the clock."""

    def __init__(self, device: WgDevice) -> None:
        self._device, self.seconds, self._begun = device, 0.0, 0.0

    def __enter__(self) -> Timer:
        self._device.finish()
        self._begun = time.perf_counter()
        return self

    def __exit__(self, *failed: object) -> None:
        self._device.finish()
        self.seconds = time.perf_counter() - self._begun


@cache
def _start() -> None:
    """Let wgpu use the graphics library of the system, and never OpenGL."""
    if "XDG_RUNTIME_DIR" not in os.environ:
        os.environ.setdefault("NODEVICE_SELECT", "1")  # a layer of Mesa would complain about it
    mute_libraries()
    import_native_library()
    from wgpu.backends.wgpu_native.extras import set_instance_extras

    set_instance_extras(backends=["Primary"])


def headless_device(number: int = 0) -> WgDevice:
    """Make a device that needs no window. Raises GpuError where there is none."""
    _start()
    adapters = wgpu.gpu.enumerate_adapters_sync()
    if number >= len(adapters):
        raise GpuError(
            f"wgpu found {len(adapters)} devices of Vulkan, Metal or Direct3D 12, so none has the "
            f"number {number}. On Linux without a GPU, install mesa-vulkan-drivers."
        )
    return WgDevice(adapters[number])
