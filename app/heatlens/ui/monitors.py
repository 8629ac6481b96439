"""Find out the names of the monitors and how much room they have for windows."""

from typing import Any

from imgui_bundle import imgui  # noqa: F401  # before glfw: both then share one libglfw

import glfw  # isort: skip

_USUAL_ROOM = 1600, 900  # screen units, if the system does not report the size

GlfwHandle = Any  # a window or a monitor: the types of glfw leave out that there may be none


def room_of(monitor: GlfwHandle) -> tuple[int, int]:
    """Return the size of the work area of a monitor, in screen units."""
    if not monitor:
        return _USUAL_ROOM
    _, _, width, height = glfw.get_monitor_workarea(monitor)
    return (width, height) if width and height else _USUAL_ROOM


def screen_name(window: GlfwHandle) -> str:
    """Return name and size of the monitor that contains the middle of the window."""
    monitor = monitor_of(window)
    if not monitor:
        return ""
    name, size = glfw.get_monitor_name(monitor), glfw.get_video_mode(monitor).size
    text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
    return f"{text} {size.width}x{size.height}"


def monitor_of(window: GlfwHandle) -> GlfwHandle:
    """Return the monitor with the middle of the window, else the first; None if there is none."""
    (x, y), (width, height) = glfw.get_window_pos(window), glfw.get_window_size(window)
    for monitor in glfw.get_monitors():
        left, top = glfw.get_monitor_pos(monitor)
        size = glfw.get_video_mode(monitor).size
        across, down = x + width // 2 - left, y + height // 2 - top
        if 0 <= across < size.width and 0 <= down < size.height:
            return monitor
    return glfw.get_primary_monitor()
