"""A setting that was looked for in the palette: its panel scrolls to it, and its words are lit."""

from imgui_bundle import imgui

_NOTHING = ("", "")


class _Sought:
    """The panel and the words of the setting, until the next click."""

    def __init__(self) -> None:
        self.setting = _NOTHING
        self.is_scrolled = False


_sought = _Sought()


def seek(panel: str, words: str) -> None:
    """Bring a panel to the front, and light the words of a setting in it."""
    _sought.setting, _sought.is_scrolled = (panel, words), False
    imgui.set_window_focus(panel)


def forget_after_click() -> None:
    """Light nothing any more once a button of the mouse went down; call this once a frame."""
    if imgui.is_mouse_clicked(imgui.MouseButton_.left):
        _sought.setting = _NOTHING


def is_sought(words: str) -> bool:
    """Return True where the words about to be drawn are looked for; their panel scrolls there."""
    if _sought.setting[1] != words or not words:
        return False
    if imgui.internal.get_current_window().name != _sought.setting[0]:
        return False
    if not _sought.is_scrolled:
        imgui.set_scroll_here_y(0.3)
        _sought.is_scrolled = True
    return True
