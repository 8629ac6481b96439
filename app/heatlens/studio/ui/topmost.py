"""Track which popup is on top: Escape closes only that one, and it alone receives keys.

ImGui removes a popup as soon as Escape closes it. Code that runs later must therefore ask which
popup was on top in the last frame; `note_frame` records that at the end of each frame.
"""

from imgui_bundle import ImVec2, imgui

_ANY = int(imgui.PopupFlags_.any_popup)
_NAVIGATION_FLAG = int(imgui.ConfigFlags_.nav_enable_keyboard)


class _LastFrame:
    """The popups at the end of the last frame."""

    depth = 0  # number of popups that were open
    has_own_keys = False  # the popup on top handles the arrow keys itself


def last_popup_depth() -> int:
    """Return the number of nested popups at the end of the last frame."""
    return _LastFrame.depth


def is_any_open() -> bool:
    """Return True if a popup, menu or dialog is open or was open in the last frame."""
    return bool(imgui.is_popup_open("", _ANY)) or _LastFrame.depth > 0


# All dialogs begin here, so that all of them are kept in view.
def begin_modal(title: str, can_close: bool, flags: int) -> tuple[bool, bool]:
    """Begin a dialog that takes all input; return whether it is visible, and whether it stays open.

    The dialog is kept in view. Outside, it could not be answered, and because it takes all input,
    nothing else in the window could be used either.
    """
    window = imgui.internal.find_window_by_name(title)
    if window is not None and window.was_active:
        _keep_in_view(window)
    is_visible, stays_open = imgui.begin_popup_modal(title, True if can_close else None, flags)
    return bool(is_visible), stays_open is not False


def _keep_in_view(window: imgui.internal.Window) -> None:
    """Move a window that was dragged out of view back into it, before the window is drawn."""
    screen = imgui.get_main_viewport()
    first, size = screen.work_pos, screen.work_size
    x = max(min(window.pos.x, first.x + size.x - window.size.x), first.x)
    y = max(min(window.pos.y, first.y + size.y - window.size.y), first.y)
    if (x, y) != (window.pos.x, window.pos.y):
        imgui.set_next_window_pos(ImVec2(x, y))


def disable_key_navigation() -> None:
    """Disable ImGui's keyboard navigation in the popup that is being drawn."""
    _LastFrame.has_own_keys = True


def note_frame() -> None:
    """Record what is open at the end of a frame; enable keyboard navigation for the next one.

    Without an open popup the arrow keys, Space and Tab control the shot, not the widgets.
    """
    io = imgui.get_io()
    _LastFrame.depth = len(imgui.get_current_context().open_popup_stack)
    if _LastFrame.depth and not _LastFrame.has_own_keys:
        io.config_flags |= _NAVIGATION_FLAG
    else:
        io.config_flags &= ~_NAVIGATION_FLAG
    # Tab moves between fields only while a field is edited or a dialog is open.
    context = imgui.get_current_context()
    context.config_nav_enable_tabbing = bool(_LastFrame.depth or io.want_text_input)
    _LastFrame.has_own_keys = False


def is_escaped() -> bool:
    """Return True if Escape was pressed and the popup being drawn is on top."""
    depth = len(imgui.get_current_context().begin_popup_stack)
    return bool(imgui.is_key_pressed(imgui.Key.escape, False)) and _LastFrame.depth == depth


def close_escaped() -> None:
    """Close the popup on top if Escape was pressed; modal popups handle Escape themselves."""
    stack = imgui.get_current_context().open_popup_stack
    if not imgui.is_key_pressed(imgui.Key.escape, False) or not 0 < _LastFrame.depth <= len(stack):
        return
    window = stack[len(stack) - 1].window
    if window is not None and not window.flags & imgui.WindowFlags_.modal:
        imgui.internal.close_popup_to_level(len(stack) - 1, True)
