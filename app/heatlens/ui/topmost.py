"""Track which popup is on top: Escape closes only that one, and it alone receives keys.

ImGui removes a popup as soon as Escape closes it. Code that runs later must therefore ask which
popup was on top in the last frame; `note_frame` records that at the end of each frame.
"""

from imgui_bundle import imgui

_ANY = int(imgui.PopupFlags_.any_popup)
_NAVIGATES = int(imgui.ConfigFlags_.nav_enable_keyboard)


class _LastFrame:
    """What was on top at the end of the last frame."""

    depth = 0  # number of popups that were open
    has_own_keys = False  # the popup on top handles the arrow keys itself


def depth_before() -> int:
    """Return the number of nested popups at the end of the last frame."""
    return _LastFrame.depth


def is_any_open() -> bool:
    """Return True if a popup, menu or dialog is open or was open in the last frame."""
    return bool(imgui.is_popup_open("", _ANY)) or _LastFrame.depth > 0


def answers_keys_itself() -> None:
    """Disable ImGui's keyboard navigation in the popup that is being drawn."""
    _LastFrame.has_own_keys = True


def note_frame() -> None:
    """Record what is open at the end of a frame; enable keyboard navigation for the next one.

    Without an open popup the arrow keys, Space and Tab control the shot, not the widgets.
    """
    io = imgui.get_io()
    _LastFrame.depth = len(imgui.get_current_context().open_popup_stack)
    if _LastFrame.depth and not _LastFrame.has_own_keys:
        io.config_flags |= _NAVIGATES
    else:
        io.config_flags &= ~_NAVIGATES
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
