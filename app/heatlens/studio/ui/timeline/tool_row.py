"""Draw a row of controls on one line; rare ones and those that do not fit go into a popup."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from imgui_bundle import imgui

from heatlens.studio.ui import rects, texts, widgets

_MORE = "..."


@dataclass(frozen=True)
class Tool:
    """A control of the row.

    draw     draws the control, in the row or in the popup
    width    the width in screen units
    rank     the controls of the highest rank leave the row first, all of them together
    gap      space before the control, in screen units; None for the usual space
    is_word  the control is only text, and is omitted instead of going into the popup
    is_rare  the control is in the popup whatever the width
    """

    draw: Callable[[], None]
    width: float
    rank: int
    gap: float | None = None
    is_word: bool = False
    is_rare: bool = False


def highest_fitting_rank(
    tools: Sequence[Tool], width: float, spacing: float, more_width: float
) -> int:
    """Return the highest rank that stays in a row of this width; the lowest one always stays.

    `spacing` is the usual gap, and `more_width` that of the button of the popup with its gap.
    """
    ranks = sorted({tool.rank for tool in tools if not tool.is_rare}, reverse=True)
    for rank in ranks:
        row_tools = [tool for tool in tools if _is_in_row(tool, rank)]
        gaps = [spacing if tool.gap is None else tool.gap for tool in row_tools[1:]]
        has_more = any(not (tool.is_word or _is_in_row(tool, rank)) for tool in tools)
        if sum(tool.width for tool in row_tools) + sum(gaps) + more_width * has_more <= width:
            return rank
    return ranks[-1]


def _is_in_row(tool: Tool, rank: int) -> bool:
    """Return True if a row of tools up to `rank` has this one."""
    return tool.rank <= rank and not tool.is_rare


def tool_row(name: str, tools: Sequence[Tool], tip: str = "More controls") -> None:
    """Draw the controls side by side, with a button that has `tip` for the others."""
    style, width = imgui.get_style(), imgui.get_content_region_avail().x
    spacing = style.item_spacing.x
    button_width = imgui.calc_text_size(_MORE).x + 2 * style.frame_padding.x
    rank = highest_fitting_rank(tools, width, spacing, button_width + spacing)
    row_tools = [tool for tool in tools if _is_in_row(tool, rank)]
    popup_tools = [tool for tool in tools if not (tool.is_word or _is_in_row(tool, rank))]
    _draw_tools(row_tools)
    if popup_tools:
        imgui.same_line()
        _draw_more(name, popup_tools, tip)


def _draw_tools(tools: Sequence[Tool]) -> None:
    """Draw the tools of the row side by side."""
    for index, tool in enumerate(tools):
        if index:
            imgui.same_line(0.0, -1.0 if tool.gap is None else tool.gap)
        imgui.set_next_item_width(tool.width)
        tool.draw()


def _draw_more(name: str, tools: Sequence[Tool], tip: str) -> None:
    """Draw the button and, while it is open, the popup: a line for each tool, buttons in one."""
    popup = f"more of the {name}"
    if widgets.button(f"{_MORE}##{name}", f"more {name}", tip):
        imgui.open_popup(popup)
    if imgui.begin_popup(popup):
        for last_tool, tool in zip([None, *tools], tools, strict=False):
            if last_tool is not None and last_tool.gap is not None and tool.gap is not None:
                imgui.same_line(0.0, tool.gap)
            imgui.set_next_item_width(tool.width)
            tool.draw()
        imgui.end_popup()


def text_tool(text: str, rank: int, name: str = "", tip: str = "", is_dim: bool = True) -> Tool:
    """Return a text for the row, known to `rects` by `name` or by its words."""

    def draw() -> None:
        """Draw the text with its tooltip."""
        imgui.align_text_to_frame_padding()
        (imgui.text_disabled if is_dim else imgui.text)(text)
        rects.note(name or text)
        texts.tooltip(tip)

    return Tool(draw, texts.text_width(text), rank, is_word=True)


def button_tool(
    words: str, name: str, rank: int, on_press: Callable[[], None], tip: str = ""
) -> Tool:
    """Return a button for the row, known to `rects` by `name`; pressing it calls `on_press`."""

    def draw() -> None:
        if widgets.button(words, name, tip):
            on_press()

    width = texts.text_width(words) + 2 * imgui.get_style().frame_padding.x
    return Tool(draw, width, rank)


def checkbox_tool(words: str, owner: object, field: str, rank: int, tip: str) -> Tool:
    """Return a checkbox for the row, which sets the attribute `field` of `owner`."""

    def draw() -> None:
        setattr(owner, field, widgets.check(words, bool(getattr(owner, field)), tip=tip))

    gap = imgui.get_style().item_inner_spacing.x
    return Tool(draw, imgui.get_frame_height() + gap + texts.text_width(words), rank)
