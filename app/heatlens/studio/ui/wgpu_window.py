"""A window drawn by wgpu: Vulkan, Metal or Direct3D 12.

The device draws the window into a texture, which its surface copies to the screen. A second window
has a surface of its own, and both show textures of the same device.
"""

import ctypes
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from imgui_bundle import imgui  # before glfw: both then share one libglfw

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Sampling, Texture
from heatlens.studio.ui.devices import GlfwHandle

import glfw  # isort: skip

from heatlens.render.gpu.context import new_wgpu_device
from heatlens.render.gpu.wgpu.clipped_triangles import Clipped
from heatlens.render.gpu.wgpu.surface import WgSurface
from heatlens.render.gpu.wgpu.textures import WgTexture
from heatlens.render.gpu.wgpu.wgpu_device import WgDevice
from heatlens.studio.ui.window_gpu import ImGuiDrawing, SecondWindow, WindowGpu


def present_info(handle: GlfwHandle) -> dict[str, object]:
    """Return how wgpu finds a window of GLFW."""
    native: Any = glfw  # each system has its own functions, some without types
    if sys.platform == "win32":
        return {"platform": "windows", "window": native.get_win32_window(handle)}
    if sys.platform == "darwin":
        return {"platform": "cocoa", "window": native.get_cocoa_window(handle)}
    if native.get_platform() == glfw.PLATFORM_WAYLAND:
        display, window = native.get_wayland_display(), native.get_wayland_window(handle)
        return {"platform": "wayland", "window": window, "display": display}
    display, window = native.get_x11_display(), native.get_x11_window(handle)
    return {"platform": "x11", "window": window, "display": display}


class WgpuWindow(WindowGpu):
    """A window with a surface of wgpu."""

    def __init__(self, handle: GlfwHandle) -> None:
        self.handle = handle
        device = new_wgpu_device()
        assert isinstance(device, WgDevice)
        self.device = self._device = device
        self._surface = device.surface(present_info(handle), waits=True)
        self._surfaces = [self._surface]  # with those of second windows
        self._texture: WgTexture | None = None
        self._target: Framebuffer | None = None
        self._is_hidden = False

    def begin_frame(
        self, size_px: tuple[int, int], color: tuple[float, float, float]
    ) -> Framebuffer:
        self._is_hidden = min(size_px) < 1  # it is minimised
        size_px = max(1, size_px[0]), max(1, size_px[1])
        if self._target is None or self._target.size != size_px:
            self._release_texture()
            self._texture = self._device.texture(size_px, 4)
            self._target = self._device.framebuffer([self._texture])
        self._target.use()
        self._target.viewport = (0, 0, *size_px)
        self._target.clear(*color)
        return self._target

    def show_frame(self) -> None:
        if self._texture is not None and not self._is_hidden:
            self._surface.show(self._texture)

    def second_window(
        self, size: tuple[int, int], title: str, monitor: GlfwHandle
    ) -> SecondWindow | None:
        handle = glfw.create_window(*size, title, monitor, None)
        if not handle:
            return None
        # only the main window waits for the monitor's refresh
        surface = self._device.surface(present_info(handle), waits=False)
        self._surfaces.append(surface)
        return _OtherWindow(handle, surface)

    def _release_texture(self) -> None:
        if self._target is not None and self._texture is not None:
            self._target.release()
            self._texture.release()
        self._target = self._texture = None

    def close(self) -> None:
        self._release_texture()
        for surface in self._surfaces:
            surface.release()


class _OtherWindow(SecondWindow):
    """A window with another surface of the same device."""

    def __init__(self, handle: GlfwHandle, surface: WgSurface) -> None:
        self.handle, self._surface = handle, surface

    def show(self, texture: Texture, size_px: tuple[int, int]) -> None:
        assert isinstance(texture, WgTexture)
        self._surface.show(texture)

    def close(self) -> None:
        self._surface.release()
        glfw.destroy_window(self.handle)


class WgpuImGui(ImGuiDrawing):
    """Draws ImGui's lists of triangles, and keeps its textures, of fonts above all."""

    def __init__(self, device: Device) -> None:
        assert isinstance(device, WgDevice)
        self._device, self._triangles = device, device.clipped_triangles()
        self._textures: dict[int, WgTexture] = {}  # those of ImGui, by its own numbers
        flags = imgui.BackendFlags_
        imgui.get_io().backend_flags |= flags.renderer_has_vtx_offset | flags.renderer_has_textures

    def begin_frame(self) -> None:
        """Do nothing: all is made when a frame is drawn."""

    def draw(self, target: Framebuffer) -> None:
        data = imgui.get_draw_data()
        for texture in data.textures or ():
            self._update_texture(texture)
        left, top = data.display_pos
        width, height = data.display_size
        size_px = round(width * data.framebuffer_scale.x), round(height * data.framebuffer_scale.y)
        lists = data.cmd_lists
        if min(size_px) > 0 and data.total_idx_count:
            self._triangles.draw(
                target,
                (left, top, width, height),
                size_px,
                b"".join(_content(one.vtx_buffer, imgui.VERTEX_SIZE) for one in lists),
                b"".join(_content(one.idx_buffer, imgui.INDEX_SIZE) for one in lists),
                _clipped(data),
            )

    def _update_texture(self, data: imgui.ImTextureData) -> None:
        """Make, change or release one of ImGui's textures, as it wishes."""
        wishes = imgui.ImTextureStatus
        if data.status == wishes.want_create:
            texture = self._device.texture((data.width, data.height), 4, data.get_pixels_array())
            texture.sampling, texture.repeats = Sampling.LINEAR, False
            self._textures[data.unique_id] = texture
            data.set_tex_id(texture.handle)
            data.set_status(wishes.ok)
        elif data.status == wishes.want_updates:
            area = data.update_rect
            pixels = data.get_pixels_array().reshape(data.height, data.width, 4)
            pixels = pixels[area.y : area.y + area.h, area.x : area.x + area.w]
            place = area.x, area.y, area.w, area.h
            self._textures[data.unique_id].write(np.ascontiguousarray(pixels), place)
            data.set_status(wishes.ok)
        elif data.status == wishes.want_destroy and data.unused_frames > 0:
            self._release_texture(data)

    def _release_texture(self, data: imgui.ImTextureData) -> None:
        self._textures.pop(data.unique_id).release()
        data.set_tex_id(0)
        data.set_status(imgui.ImTextureStatus.destroyed)

    def close(self) -> None:
        for data in imgui.get_platform_io().textures:
            if data.unique_id in self._textures:
                self._release_texture(data)
        self._triangles.release()


def _content(buffer: imgui.ImVector_ImDrawVert | imgui.ImVector_uint, item_bytes: int) -> bytes:
    """Return the bytes of one of ImGui's arrays."""
    return ctypes.string_at(buffer.data_address(), buffer.size() * item_bytes)


def _clipped(data: imgui.ImDrawData) -> Iterator[Clipped]:
    """Return all that is to be drawn, with clips in pixels."""
    (left, top), scale = data.display_pos, data.framebuffer_scale
    width, height = data.display_size
    first_vertex = first_index = 0
    for one in data.cmd_lists:
        for command in one.cmd_buffer:
            x0, y0, x1, y1 = command.clip_rect
            yield Clipped(
                command.get_tex_id(),
                (
                    max((x0 - left) * scale.x, 0.0),
                    max((y0 - top) * scale.y, 0.0),
                    min((x1 - left) * scale.x, width * scale.x),
                    min((y1 - top) * scale.y, height * scale.y),
                ),
                command.elem_count,
                first_index + command.idx_offset,
                first_vertex + command.vtx_offset,
            )
        first_vertex += one.vtx_buffer.size()
        first_index += one.idx_buffer.size()
