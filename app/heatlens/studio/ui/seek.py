"""Show a setting that was found in the palette: scroll its panel to it and highlight its label."""

from imgui_bundle import imgui

_NOTHING = ("", "")


class _Sought:
    """The panel and the label of the setting, kept until the next click."""

    def __init__(self) -> None:
        self.setting = _NOTHING
        self.is_scrolled = False


_sought = _Sought()


def seek(panel: str, words: str) -> None:
    """Bring a panel to the front and highlight the label `words` in it."""
    _sought.setting, _sought.is_scrolled = (panel, words), False
    imgui.set_window_focus(panel)


def forget_after_click() -> None:
    """End the highlight when the left mouse button is pressed; call this once a frame."""
    if imgui.is_mouse_clicked(imgui.MouseButton_.left):
        _sought.setting = _NOTHING


def is_sought(words: str, scrolls: bool = True) -> bool:
    """Return True if the label to be drawn next is highlighted; scroll its panel to it once."""
    if _sought.setting[1] != words or not words:
        return False
    if imgui.internal.get_current_window().name != _sought.setting[0]:
        return False
    if scrolls and not _sought.is_scrolled:
        imgui.set_scroll_here_y(0.3)
        _sought.is_scrolled = True
    return True
