"""Show the picture without any interface in a second window, for a client's monitor."""

from imgui_bundle import imgui  # noqa: F401  # before glfw: both then share one libglfw

from heatlens.studio.ui.devices import GlfwHandle, monitor_of

import glfw  # isort: skip

from heatlens.core.model.view.view import ViewState
from heatlens.studio.ui.open_window import wake_window
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.picture.picture_alone import PictureAlone
from heatlens.studio.ui.window_gpu import SecondWindow, WindowGpu

_SIZE = 1280, 720
_TITLE = "heatlens picture"


class CleanFeed:
    """The second window, which exists while the user has it switched on."""

    def __init__(self, main_window: WindowGpu) -> None:
        self._main_window = main_window
        self._picture = PictureAlone(main_window.device)
        self._window: SecondWindow | None = None

    def draw(
        self, is_requested: bool, pictures: Pictures | None, view: ViewState, has_labels: bool
    ) -> bool:
        """Open, draw or close the window; return whether it is still open.

        `has_labels` writes the names of the looks into the grid.
        """
        if self._window is not None and glfw.window_should_close(self._window.handle):
            is_requested = False
        if is_requested and self._window is None:
            self._open_window()
        if not is_requested:
            self.close()
        elif self._window is not None:
            self._draw_picture(self._window, pictures, view, has_labels)
        return self._window is not None

    def _open_window(self) -> None:
        """Open the window full screen on another monitor, or as a normal window without one."""
        main_monitor = monitor_of(self._main_window.handle)
        monitors = glfw.get_monitors()
        other_monitors = [
            monitor
            for monitor in monitors
            if main_monitor and glfw.get_monitor_pos(monitor) != glfw.get_monitor_pos(main_monitor)
        ]
        screen: GlfwHandle = other_monitors[0] if other_monitors else None
        mode = glfw.get_video_mode(screen).size if screen else None
        size = (mode.width, mode.height) if mode else _SIZE
        glfw.window_hint(glfw.AUTO_ICONIFY, 0)
        self._window = self._main_window.second_window(size, _TITLE, screen)
        if self._window is not None:
            glfw.set_key_callback(self._window.handle, self._key_changed)

    def _key_changed(
        self, window: GlfwHandle, key: int, _code: int, action: int, _mods: int
    ) -> None:
        """Close the window on Escape or F12; toggle full screen on F11."""
        if action != glfw.PRESS:
            return
        if key in (glfw.KEY_ESCAPE, glfw.KEY_F12):
            glfw.set_window_should_close(window, True)
        elif key == glfw.KEY_F11:
            fill_screen(window, not glfw.get_window_monitor(window), _SIZE)
        wake_window()

    def _draw_picture(
        self, window: SecondWindow, pictures: Pictures | None, view: ViewState, has_labels: bool
    ) -> None:
        """Draw the picture at the size of the second window, and show it there."""
        size = glfw.get_framebuffer_size(window.handle)
        if min(size) < 1:
            return
        self._picture.draw(pictures, view, size, has_labels)
        assert self._picture.texture is not None
        window.show(self._picture.texture, size)

    def close(self) -> None:
        """Close the window if it is open."""
        if self._window is not None:
            self._picture.release()
            self._window.close()
            self._window = None


def fill_screen(
    window: GlfwHandle,
    is_full: bool,
    size: tuple[int, int],
    position: tuple[int, int] | None = None,
) -> None:
    """Switch a window to full screen on its monitor, or back to a window of `size` screen units.

    `position` is where the window was before, None for the middle of the monitor.
    """
    monitor = monitor_of(window)
    if not monitor:
        return
    if is_full:
        mode = glfw.get_video_mode(monitor)
        rate = mode.refresh_rate
        glfw.set_window_monitor(window, monitor, 0, 0, mode.size.width, mode.size.height, rate)
    else:
        x, y, width, height = glfw.get_monitor_workarea(monitor)
        window_size = min(size[0], width), min(size[1], height)
        middle = x + (width - window_size[0]) // 2, y + (height - window_size[1]) // 2
        no_monitor: GlfwHandle = None  # the stub of glfw does not allow None for "no monitor"
        glfw.set_window_monitor(window, no_monitor, *(position or middle), *window_size, 0)
