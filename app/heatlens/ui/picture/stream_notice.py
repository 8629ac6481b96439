"""Draw the notices of a stream: why nothing, or not the newest picture, is shown."""

from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.model.view.view_geometry import Viewport
from heatlens.session.loop.messages import window_words
from heatlens.source.stream_source import StreamSource
from heatlens.ui import theme, widgets

_WIDTH_EM = 44.0  # longest line that is still easy to read
_LINES = (
    "A renderer that speaks the protocol of the viewer tev sends its picture to this address.",
    "It needs colour (R, G, B) and depth (Z), in one image or in two; --depth FILE brings the "
    "depth of a renderer that sends none.",
    "Ctrl+O opens a file instead.",
)


def draw_waiting(stream: StreamSource) -> None:
    """Draw in the middle of the window what the stream waits for, and what it could not show."""
    room, em = imgui.get_content_region_avail(), imgui.get_font_size()
    width = min(_WIDTH_EM * em, room.x - 2 * em)
    said = window_words(stream.refusal)
    told = [(f"Listening on {stream.address} ...", theme.OVER_PICTURE.dim)]
    told += [(said, theme.OVER_PICTURE.told)] if said else []
    told += [(line, theme.OVER_PICTURE.dim) for line in _LINES]
    heights = [imgui.calc_text_size(text, False, width).y for text, _ in told]
    y = max(0.5 * (room.y - sum(heights) - em * len(told)), 0.0)
    corner = imgui.get_cursor_pos()
    for (text, color), height in zip(told, heights, strict=True):
        _draw_wrapped(text, color, ImVec2(corner.x + 0.5 * (room.x - width), corner.y + y), width)
        y += height + em


class StreamNotice:
    """A notice over the picture why the latest data is not shown, until the user dismisses it."""

    def __init__(self) -> None:
        self._dismissed = ""

    def draw(self, stream: StreamSource, viewport: Viewport) -> None:
        """Draw the notice over the top of the picture, if there is one."""
        said = window_words(stream.refusal)
        if not said or said == self._dismissed:
            return
        em, (x, y), width = imgui.get_font_size(), viewport.corner, viewport.size[0]
        imgui.set_cursor_screen_pos(ImVec2(x + 0.5 * em, y + 0.5 * em))
        imgui.push_style_color(imgui.Col_.child_bg, theme.OVER_PICTURE.shadow)
        flags = imgui.ChildFlags_.auto_resize_y | imgui.ChildFlags_.always_use_window_padding
        imgui.begin_child("stream notice", ImVec2(min(_WIDTH_EM * em, width - em), 0.0), flags)
        widgets.colored_text(said, theme.OVER_PICTURE.told)
        if widgets.small_button("Dismiss", "stream notice"):
            self._dismissed = said
        imgui.end_child()
        imgui.pop_style_color()


def _draw_wrapped(text: str, color: ImVec4, at: ImVec2, width: float) -> None:
    imgui.set_cursor_pos(at)
    imgui.push_text_wrap_pos(at.x + width)
    widgets.colored_text(text, color)
    imgui.pop_text_wrap_pos()
