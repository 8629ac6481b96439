"""Show a setting that was found in the palette: scroll its panel to it and highlight its label."""

from imgui_bundle import imgui

_NOTHING = ("", "")


class _Highlight:
    """The panel and the label of the setting, kept until the next click."""

    def __init__(self) -> None:
        self.setting = _NOTHING
        self.is_scrolled = False


_highlight = _Highlight()


def show_setting(panel: str, words: str) -> None:
    """Bring a panel to the front and highlight the label `words` in it."""
    _highlight.setting, _highlight.is_scrolled = (panel, words), False
    imgui.set_window_focus(panel)


def forget_after_click() -> None:
    """End the highlight when the left mouse button is pressed; call this once a frame."""
    if imgui.is_mouse_clicked(imgui.MouseButton_.left):
        _highlight.setting = _NOTHING


def is_highlighted(words: str, scrolls: bool = True) -> bool:
    """Return True if the label drawn next is highlighted; scroll its panel to it, once."""
    if _highlight.setting[1] != words or not words:
        return False
    if imgui.internal.get_current_window().name != _highlight.setting[0]:
        return False
    if scrolls and not _highlight.is_scrolled:
        imgui.set_scroll_here_y(0.3)
        _highlight.is_scrolled = True
    return True
