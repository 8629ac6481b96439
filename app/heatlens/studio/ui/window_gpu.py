"""What the window asks of the graphics library that draws it, and which library that is.

Nothing else in `ui` knows a library: `opengl_window.py` and `wgpu_window.py` answer these classes.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass

from heatlens.studio.ui.devices import GlfwHandle  # imports ImGui before glfw, see `window.py`

import glfw  # isort: skip

from heatlens.core.base.extras import OnUse, extra
from heatlens.render.gpu.context import Gpu, chosen_gpu, library_of
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Texture


@dataclass(frozen=True)
class _Library:
    """How a graphics library draws a window.

    hints          what GLFW must know before it makes the window
    window, imgui  the classes of the window, and of what draws ImGui in it
    """

    hints: Mapping[int, int]
    window: OnUse
    imgui: OnUse


_LIBRARIES = {
    Gpu.OPENGL: _Library(
        {
            glfw.CONTEXT_VERSION_MAJOR: 4,
            glfw.CONTEXT_VERSION_MINOR: 3,
            glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE,
            glfw.OPENGL_FORWARD_COMPAT: 1,
        },
        OnUse("studio.ui.opengl_window", "OpenGlWindow"),
        OnUse("studio.ui.opengl_window", "OpenGlImGui"),
    ),
    Gpu.WGPU: _Library(
        {glfw.CLIENT_API: glfw.NO_API},
        OnUse("studio.ui.wgpu_window", "WgpuWindow"),
        OnUse("studio.ui.wgpu_window", "WgpuImGui"),
    ),
}


class ImGuiDrawing(ABC):
    """Draws what ImGui made of a frame, with its current context."""

    @abstractmethod
    def begin_frame(self) -> None:
        """Prepare a frame; call this before ImGui's own."""

    @abstractmethod
    def draw(self, target: Framebuffer) -> None:
        """Draw the last frame over what is in `target`."""

    @abstractmethod
    def close(self) -> None:
        """Give textures and buffers back."""


class SecondWindow(ABC):
    """Another window, which shows one picture.

    handle  the window of GLFW
    """

    handle: GlfwHandle

    @abstractmethod
    def show(self, texture: Texture, size_px: tuple[int, int]) -> None:
        """Fill the window, of `size_px` pixels, with a texture of that size."""

    @abstractmethod
    def close(self) -> None:
        """Close the window."""


class WindowGpu(ABC):
    """A window, and the device that draws the pictures in it.

    handle  the window of GLFW
    """

    handle: GlfwHandle
    device: Device

    @abstractmethod
    def begin_frame(
        self, size_px: tuple[int, int], color: tuple[float, float, float]
    ) -> Framebuffer:
        """Return the pixels of the window, filled with a color, for passes to draw into."""

    @abstractmethod
    def show_frame(self) -> None:
        """Show what was drawn since `begin_frame`; wait for the refresh of the monitor."""

    @abstractmethod
    def second_window(
        self, size: tuple[int, int], title: str, monitor: GlfwHandle
    ) -> SecondWindow | None:
        """Open a window that shows textures of the device; None if that fails.

        It is full screen on `monitor`, or has a `size` in screen units if that is None.
        """

    @abstractmethod
    def close(self) -> None:
        """Give back what draws into the window, before the window itself is closed."""


def window_libraries() -> tuple[Gpu, ...]:
    """Return the libraries that may draw a window, the preferred one first."""
    gpu = chosen_gpu()
    return (Gpu.OPENGL, Gpu.WGPU) if gpu is Gpu.AUTO else (gpu,)


def hints_of(gpu: Gpu) -> dict[int, int]:
    """Return what GLFW must know before it makes a window that `gpu` draws."""
    return dict(_LIBRARIES[gpu].hints)


def attach(gpu: Gpu, handle: GlfwHandle) -> WindowGpu:
    """Let `gpu` draw a new window. Raises GpuError, or MissingPackageError, where it cannot."""
    with extra("wgpu").require() if gpu is Gpu.WGPU else nullcontext():
        window_class = _LIBRARIES[gpu].window.target
    window: WindowGpu = window_class(handle)
    return window


def imgui_drawing(device: Device) -> ImGuiDrawing:
    """Return what draws ImGui by a device, in its current context."""
    drawing: ImGuiDrawing = _LIBRARIES[library_of(device)].imgui(device)
    return drawing
