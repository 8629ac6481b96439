"""Draw the start screen in place of the picture: a list of cards, each of which opens something."""

from collections.abc import Sequence
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.media.scene.scene_read import DEMO
from heatlens.render.gpu.device import Device
from heatlens.studio.session.files.start_choices import Card
from heatlens.studio.ui import probe, theme
from heatlens.studio.ui.start.start_card import (
    CardPictures,
    Place,
    StartLayout,
    column_width,
    draw_card,
    lay_out,
)
from heatlens.studio.ui.texts import fitted

_K = imgui.Key
_DIGITS = (
    (_K._1, _K.keypad1), (_K._2, _K.keypad2), (_K._3, _K.keypad3), (_K._4, _K.keypad4),
    (_K._5, _K.keypad5), (_K._6, _K.keypad6), (_K._7, _K.keypad7), (_K._8, _K.keypad8),
    (_K._9, _K.keypad9),
)  # fmt: skip
_TITLE, _PROMISE = "heatlens", "What if the focus were there, at f/1.4?"
_HINT = "Then click on what is to be sharp, or drag the focus bar."
_HINT_OF_SHOTS = "Then press Space to play, click on what is to be sharp, and pull with Shift+M."
_DROP_HINT = "A file can be dropped here as well."
_TITLE_SCALE, _LINE_EM = 1.9, 1.4


@dataclass(frozen=True)
class Answer:
    """The user's choice: a card, or to go back to the picture."""

    taken: Card | None = None
    leaves: bool = False


class StartScreen:
    """Draws the start screen; holds the pictures on the cards and the selected row."""

    def __init__(self, ctx: Device) -> None:
        self._pictures = CardPictures(ctx)
        self._row = 0
        self._taken: str | None = None  # the card that was chosen, until it is open
        self._was_opening = False

    def draw(
        self, cards: Sequence[Card], opening: str | None, hears: bool, most_recent: int = 0
    ) -> Answer:
        """Draw the screen in the current ImGui window; `opening` names the file being opened.

        `hears` is False while something else takes the keys. The layout keeps room for
        `most_recent` recent files, some of which may still be looked up.
        """
        imgui.push_style_color(imgui.Col_.child_bg, theme.colors.start_ground)
        imgui.begin_child("start")
        recent = sum(bool(card.kind) for card in cards)
        room, em = imgui.get_content_region_avail(), imgui.get_font_size()
        rows = max(recent, most_recent)
        layout = lay_out(len(cards) - recent, rows, (room.x, room.y), em)
        if self._was_opening and not opening:
            self._taken = None
        self._was_opening = bool(opening)
        answer = self._draw_inside(cards[: len(layout.cards)], layout, opening, hears)
        imgui.end_child()
        imgui.pop_style_color()
        return answer

    def _draw_inside(
        self, cards: Sequence[Card], layout: StartLayout, opening: str | None, hears: bool
    ) -> Answer:
        corner, em = imgui.get_cursor_screen_pos(), imgui.get_font_size()
        corner = ImVec2(corner.x + layout.x, corner.y)
        before, self._row = self._row, min(self._row, len(cards) - 1)
        taken = self._by_keys(cards) if hears else None
        _words(layout, corner, hint_of(cards[self._row]))
        column = column_width(layout.cards[0].height, em)
        # There may be fewer cards than places while recent files are looked up.
        for row, (card, band) in enumerate(zip(cards, layout.cards, strict=False)):
            low = ImVec2(corner.x, corner.y + band.y)
            high = ImVec2(low.x + layout.width, low.y + band.height)
            taken = card if self._button(card, row, low, high) else taken
            # A shot opens its source, which may have a card of its own.
            is_coming = opening is not None and card.text == (self._taken or opening)
            is_chosen = row == self._row
            place = Place(low, high, column)
            draw_card(card, row + 1, place, self._pictures, is_chosen, is_coming)
            if is_chosen and row != before:
                imgui.set_scroll_here_y()
        imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + layout.hint.y))
        imgui.dummy(ImVec2(1.0, layout.hint.height))  # makes them scrollable in a small window
        self._taken = self._taken if taken is None else taken.text
        return Answer(taken, hears and imgui.is_key_pressed(_K.escape, False))

    def _by_keys(self, cards: Sequence[Card]) -> Card | None:
        """Handle keys: arrows select a row, Enter opens it, a digit opens its card."""
        step = imgui.is_key_pressed(_K.down_arrow) - imgui.is_key_pressed(_K.up_arrow)
        self._row = min(max(self._row + step, 0), len(cards) - 1)
        for row, keys in enumerate(_DIGITS[: len(cards)]):
            if _went_down(keys):
                self._row = row
                return cards[row]
        return cards[self._row] if _went_down((_K.enter, _K.keypad_enter)) else None

    def _button(self, card: Card, row: int, low: ImVec2, high: ImVec2) -> bool:
        """Return True if a card is clicked; select its row if the pointer moves over it."""
        imgui.set_cursor_screen_pos(low)
        size = ImVec2(high.x - low.x, high.y - low.y)
        clicked = imgui.invisible_button(f"##{row} {card.title}", size)
        probe.note(f"start {card.title}")
        moved = imgui.get_io().mouse_delta
        if imgui.is_item_activated() or (imgui.is_item_hovered() and (moved.x or moved.y)):
            self._row = row
        return bool(clicked)


def _went_down(keys: Sequence[imgui.Key]) -> bool:
    return any(imgui.is_key_pressed(key, False) for key in keys)


def hint_of(card: Card) -> str:
    """Return a hint about the first gestures for what the card opens."""
    return _HINT_OF_SHOTS if card.text == DEMO or card.kind in ("Sequence", "Shot") else _HINT


def _words(layout: StartLayout, corner: ImVec2, hint: str) -> None:
    """Draw the heading over the cards, and the hint under them."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    bright = imgui.get_color_u32(imgui.Col_.text)
    y = corner.y + layout.head.y
    draw.add_text(imgui.get_font(), _TITLE_SCALE * em, ImVec2(corner.x, y), bright, _TITLE)
    y += (_TITLE_SCALE + 0.1) * em
    draw.add_text(ImVec2(corner.x, y), theme.colors.text_dim, fitted(_PROMISE, layout.width))
    if len(layout.cards) > layout.fixed:
        y = corner.y + layout.hint.end
        draw.add_line(ImVec2(corner.x, y), ImVec2(corner.x + layout.width, y), theme.colors.box)
    y = corner.y + layout.hint.y + 0.4 * em
    is_one_line = imgui.calc_text_size(hint).x <= layout.width
    font, at = imgui.get_font(), ImVec2(corner.x, y)
    draw.add_text(font, em, at, bright, hint, wrap_width=layout.width)
    lines = imgui.calc_text_size(hint, wrap_width=layout.width)
    probe.note_at("start hint", (at.x, at.y, at.x + lines.x, at.y + lines.y))
    if layout.is_roomy and is_one_line:
        at = ImVec2(corner.x, y + _LINE_EM * em)
        draw.add_text(at, theme.colors.text_dim, fitted(_DROP_HINT, layout.width))


def hears_keys() -> bool:
    """Return True if keys are for the window: no popup, field or button takes them.

    Call this before popups are drawn: a popup that Enter closes is gone once it has been drawn.
    """
    flags, io = imgui.PopupFlags_, imgui.get_io()
    is_popup = imgui.is_popup_open("", flags.any_popup_id | flags.any_popup_level)
    is_held = io.key_ctrl or io.key_shift or io.key_alt or imgui.is_any_item_active()
    return not (is_popup or is_held or io.want_text_input)
