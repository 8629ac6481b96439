"""A window drawn by OpenGL.

A second window has a context of its own, which shares textures with that of the first. The first
context draws the picture at the size of the second window, and the second one copies it to screen.
"""

from imgui_bundle import imgui  # before glfw: both then share one libglfw

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Texture
from heatlens.studio.ui.devices import GlfwHandle

import glfw  # isort: skip

from heatlens.render.gpu.opengl.gl_device import window_device
from heatlens.render.gpu.opengl.second_window import SecondWindow as Copies
from heatlens.studio.ui.window_gpu import ImGuiDrawing, SecondWindow, WindowGpu


class OpenGlWindow(WindowGpu):
    """A window with a context of OpenGL, which is current unless a second window is drawn."""

    def __init__(self, handle: GlfwHandle) -> None:
        self.handle = handle
        glfw.make_context_current(handle)
        glfw.swap_interval(1)
        self.device = self._context = window_device()

    # The viewport is set in each frame, because the screen's framebuffer keeps the size that it had
    # when the context was created. ImGui's backend restores every state that it changes, but draws
    # into the bound framebuffer: if that is not the screen's, the window stays empty.
    def begin_frame(
        self, size_px: tuple[int, int], color: tuple[float, float, float]
    ) -> Framebuffer:
        screen = self._context.screen
        screen.use()
        screen.viewport = (0, 0, *size_px)
        screen.clear(*color)
        return screen

    def show_frame(self) -> None:
        glfw.swap_buffers(self.handle)

    def second_window(
        self, size: tuple[int, int], title: str, monitor: GlfwHandle
    ) -> SecondWindow | None:
        handle = glfw.create_window(*size, title, monitor, self.handle)
        return _SharedWindow(self, handle) if handle else None

    def close(self) -> None:
        """Do nothing: the context ends with the window."""


class _SharedWindow(SecondWindow):
    """A window whose context shares textures with that of the first window."""

    def __init__(self, first: OpenGlWindow, handle: GlfwHandle) -> None:
        self._first, self.handle = first, handle
        glfw.make_context_current(handle)
        glfw.swap_interval(0)  # only the main window waits for the monitor's refresh
        try:
            self._copies = Copies()
        finally:
            glfw.make_context_current(first.handle)

    def show(self, texture: Texture, size_px: tuple[int, int]) -> None:
        self._first.device.finish()  # the other context reads the texture next
        glfw.make_context_current(self.handle)
        try:
            self._copies.show(texture, size_px)
            glfw.swap_buffers(self.handle)
        finally:
            glfw.make_context_current(self._first.handle)

    def close(self) -> None:
        glfw.destroy_window(self.handle)
        glfw.make_context_current(self._first.handle)


class OpenGlImGui(ImGuiDrawing):
    """The backend for OpenGL that comes with ImGui."""

    def __init__(self, _device: Device) -> None:
        imgui.backends.opengl3_init("#version 430")

    def begin_frame(self) -> None:
        imgui.backends.opengl3_new_frame()

    def draw(self, target: Framebuffer) -> None:
        target.use()
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())

    def close(self) -> None:
        imgui.backends.opengl3_shutdown()
