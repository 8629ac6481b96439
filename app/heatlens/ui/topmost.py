"""Which popup lies on top: Escape closes that one, and no key reaches what lies under it.

A popup that Escape has closed is gone when the next frame is drawn, so what lay under it must ask
what was on top before. `note_frame` is called at the end of every frame for that.
"""

from imgui_bundle import imgui

_ANY = int(imgui.PopupFlags_.any_popup)
_NAVIGATES = int(imgui.ConfigFlags_.nav_enable_keyboard)


class _Seen:
    """What was on top at the end of the last frame."""

    depth = 0  # popups that were open
    has_own_keys = False  # the one on top answers the arrow keys itself


def depth_before() -> int:
    """Return how many popups lay one over the other at the end of the last frame."""
    return _Seen.depth


def is_any_open() -> bool:
    """Return True while a popup, a menu or a dialog is open, or was in the frame before."""
    return bool(imgui.is_popup_open("", _ANY)) or _Seen.depth > 0


def answers_keys_itself() -> None:
    """Keep ImGui's navigation by keyboard out of the popup that is being drawn."""
    _Seen.has_own_keys = True


def note_frame() -> None:
    """Note what is open at the end of a frame, and let keys move through it in the next one.

    Without a popup, arrows, Space and Tab belong to the shot and not to the controls.
    """
    io = imgui.get_io()
    _Seen.depth = len(imgui.get_current_context().open_popup_stack)
    if _Seen.depth and not _Seen.has_own_keys:
        io.config_flags |= _NAVIGATES
    else:
        io.config_flags &= ~_NAVIGATES
    # Tab goes from field to field only where one is typed in or a dialog is open.
    context = imgui.get_current_context()
    context.config_nav_enable_tabbing = bool(_Seen.depth or io.want_text_input)
    _Seen.has_own_keys = False


def is_escaped() -> bool:
    """Return True where Escape was pressed for the popup that is being drawn."""
    depth = len(imgui.get_current_context().begin_popup_stack)
    return bool(imgui.is_key_pressed(imgui.Key.escape, False)) and _Seen.depth == depth


def close_escaped() -> None:
    """Close the popup on top where Escape was pressed and it does not answer that itself."""
    stack = imgui.get_current_context().open_popup_stack
    if not imgui.is_key_pressed(imgui.Key.escape, False) or not 0 < _Seen.depth <= len(stack):
        return
    window = stack[len(stack) - 1].window
    if window is not None and not window.flags & imgui.WindowFlags_.modal:
        imgui.internal.close_popup_to_level(len(stack) - 1, True)
