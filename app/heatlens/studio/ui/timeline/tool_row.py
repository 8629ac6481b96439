"""Draw a row of controls on one line; controls without room go into a popup at its end."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from imgui_bundle import imgui

from heatlens.studio.ui import probe, texts, widgets

_MORE = "..."


@dataclass(frozen=True)
class Tool:
    """A control of the row.

    draw     draws it, in the row or in the popup
    width    in screen units
    rank     the controls of the highest rank leave the row first, all of them together
    gap      space before it, in screen units; None for the usual space
    is_word  it is text only, and is left out instead of going into the popup
    """

    draw: Callable[[], None]
    width: float
    rank: int
    gap: float | None = None
    is_word: bool = False


def ranks_kept(tools: Sequence[Tool], room: float, spacing: float, more: float) -> int:
    """Return the highest rank that stays in a row of width `room`; the lowest one always stays.

    `spacing` is the usual gap, and `more` the width of the button of the popup with its gap.
    """
    ranks = sorted({tool.rank for tool in tools}, reverse=True)
    for rank in ranks:
        kept = [tool for tool in tools if tool.rank <= rank]
        gaps = [spacing if tool.gap is None else tool.gap for tool in kept[1:]]
        has_more = any(tool.rank > rank and not tool.is_word for tool in tools)
        if sum(tool.width for tool in kept) + sum(gaps) + more * has_more <= room:
            return rank
    return ranks[-1]


def tool_row(name: str, tools: Sequence[Tool]) -> None:
    """Draw the controls side by side, with a button for those that have no room."""
    style, room = imgui.get_style(), imgui.get_content_region_avail().x
    spacing = style.item_spacing.x
    button = imgui.calc_text_size(_MORE).x + 2 * style.frame_padding.x
    rank = ranks_kept(tools, room, spacing, button + spacing)
    kept = [tool for tool in tools if tool.rank <= rank]
    left = [tool for tool in tools if tool.rank > rank and not tool.is_word]
    _draw(kept)
    if left:
        imgui.same_line()
        _more(name, left)


def _draw(tools: Sequence[Tool]) -> None:
    for index, tool in enumerate(tools):
        if index:
            imgui.same_line(0.0, -1.0 if tool.gap is None else tool.gap)
        imgui.set_next_item_width(tool.width)
        tool.draw()


def _more(name: str, tools: Sequence[Tool]) -> None:
    """Draw the button and, while it is open, the popup: a line each, buttons in one line."""
    popup = f"more of the {name}"
    tip = "More controls that do not fit here"
    if widgets.button(f"{_MORE}##{name}", f"more {name}", tip):
        imgui.open_popup(popup)
    if imgui.begin_popup(popup):
        for before, tool in zip([None, *tools], tools, strict=False):
            if before is not None and before.gap is not None and tool.gap is not None:
                imgui.same_line(0.0, tool.gap)
            imgui.set_next_item_width(tool.width)
            tool.draw()
        imgui.end_popup()


def word(text: str, rank: int, name: str = "", tip: str = "", is_dim: bool = True) -> Tool:
    """Return a text for the row, known to `probe` by `name` or by its words."""

    def draw() -> None:
        imgui.align_text_to_frame_padding()
        (imgui.text_disabled if is_dim else imgui.text)(text)
        probe.note(name or text)
        texts.tooltip(tip)

    return Tool(draw, texts.text_width(text), rank, is_word=True)


def push(words: str, name: str, rank: int, do: Callable[[], None], tip: str = "") -> Tool:
    """Return a button for the row, known to `probe` by `name`; pressing it calls `do`."""

    def draw() -> None:
        if widgets.button(words, name, tip):
            do()

    width = texts.text_width(words) + 2 * imgui.get_style().frame_padding.x
    return Tool(draw, width, rank)


def tick(words: str, of: object, field: str, rank: int, tip: str) -> Tool:
    """Return a checkbox for the row, which sets an attribute `field` of `of`."""

    def draw() -> None:
        setattr(of, field, widgets.check(words, bool(getattr(of, field)), tip=tip))

    gap = imgui.get_style().item_inner_spacing.x
    return Tool(draw, imgui.get_frame_height() + gap + texts.text_width(words), rank)
