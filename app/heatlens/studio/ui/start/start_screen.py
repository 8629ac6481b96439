"""Draw the start screen in place of the picture: a list of cards, each of which opens something."""

from collections.abc import Sequence
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.media.scene.scene_read import DEMO
from heatlens.render.gpu.device import Device
from heatlens.studio.settings.cards import Card
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.start.start_card import (
    CardArea,
    CardPictures,
    StartLayout,
    column_width,
    draw_card,
    lay_out,
)
from heatlens.studio.ui.texts import fit_text

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

    card: Card | None = None
    leaves: bool = False


class StartScreen:
    """Draws the start screen; holds the pictures on the cards and the selected row."""

    def __init__(self, ctx: Device) -> None:
        self._pictures = CardPictures(ctx)
        self._row = 0
        self._chosen_text: str | None = None  # the card that was chosen, until it is open
        self._was_opening = False

    def draw(
        self,
        cards: Sequence[Card],
        opening: str | None,
        has_keyboard: bool,
        max_recent_count: int = 0,
    ) -> Answer:
        """Draw the screen in the current ImGui window; `opening` names the file being opened.

        `has_keyboard` is False while something else takes the keys. The layout has space for
        `max_recent_count` recent files, some of which may still be checked.
        """
        imgui.push_style_color(imgui.Col_.child_bg, theme.colors.start_ground)
        imgui.begin_child("start")
        recent_count = sum(bool(card.kind) for card in cards)
        free_size, em = imgui.get_content_region_avail(), imgui.get_font_size()
        row_count = max(recent_count, max_recent_count)
        layout = lay_out(len(cards) - recent_count, row_count, (free_size.x, free_size.y), em)
        if self._was_opening and not opening:
            self._chosen_text = None
        self._was_opening = bool(opening)
        answer = self._draw_content(cards[: len(layout.cards)], layout, opening, has_keyboard)
        imgui.end_child()
        imgui.pop_style_color()
        return answer

    def _draw_content(
        self, cards: Sequence[Card], layout: StartLayout, opening: str | None, has_keyboard: bool
    ) -> Answer:
        """Draw the cards and texts, and move the selection; return the user's choice."""
        corner, em = imgui.get_cursor_screen_pos(), imgui.get_font_size()
        corner = ImVec2(corner.x + layout.x, corner.y)
        old_row, self._row = self._row, min(self._row, len(cards) - 1)
        chosen_card = self._handle_keys(cards) if has_keyboard else None
        _draw_texts(layout, corner, hint_of(cards[self._row]))
        column = column_width(layout.cards[0].height, em)
        # There may be fewer cards than places while recent files are looked up.
        for row, (card, band) in enumerate(zip(cards, layout.cards, strict=False)):
            card_corner = ImVec2(corner.x, corner.y + band.y)
            card_end = ImVec2(card_corner.x + layout.width, card_corner.y + band.height)
            chosen_card = (
                card if self._is_card_clicked(card, row, card_corner, card_end) else chosen_card
            )
            # A shot opens its source, which may have a card of its own.
            is_opening = opening is not None and card.text == (self._chosen_text or opening)
            is_selected = row == self._row
            area = CardArea(corner=card_corner, end=card_end, column_width=column)
            draw_card(card, row + 1, area, self._pictures, is_selected, is_opening)
            if is_selected and row != old_row:
                imgui.set_scroll_here_y()
        imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + layout.hint.y))
        imgui.dummy(ImVec2(1.0, layout.hint.height))  # makes the cards scroll in a small window
        self._chosen_text = self._chosen_text if chosen_card is None else chosen_card.text
        return Answer(chosen_card, has_keyboard and imgui.is_key_pressed(_K.escape, False))

    def _handle_keys(self, cards: Sequence[Card]) -> Card | None:
        """Handle keys: arrows select a row; return the card that Enter or a digit opens."""
        step = imgui.is_key_pressed(_K.down_arrow) - imgui.is_key_pressed(_K.up_arrow)
        self._row = min(max(self._row + step, 0), len(cards) - 1)
        for row, keys in enumerate(_DIGITS[: len(cards)]):
            if _is_any_pressed(keys):
                self._row = row
                return cards[row]
        return cards[self._row] if _is_any_pressed((_K.enter, _K.keypad_enter)) else None

    def _is_card_clicked(self, card: Card, row: int, corner: ImVec2, end: ImVec2) -> bool:
        """Return True if a card is clicked; select its row if the pointer moves over it."""
        imgui.set_cursor_screen_pos(corner)
        size = ImVec2(end.x - corner.x, end.y - corner.y)
        is_clicked = imgui.invisible_button(f"##{row} {card.title}", size)
        rects.note(f"start {card.title}")
        movement = imgui.get_io().mouse_delta
        if imgui.is_item_activated() or (imgui.is_item_hovered() and (movement.x or movement.y)):
            self._row = row
        return bool(is_clicked)


def _is_any_pressed(keys: Sequence[imgui.Key]) -> bool:
    return any(imgui.is_key_pressed(key, False) for key in keys)


def hint_of(card: Card) -> str:
    """Return a hint about the first gestures for the source that a card opens."""
    return _HINT_OF_SHOTS if card.text == DEMO or card.kind in ("Sequence", "Shot") else _HINT


def _draw_texts(layout: StartLayout, corner: ImVec2, hint: str) -> None:
    """Draw the heading over the cards, and the hint under them."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    title_color = imgui.get_color_u32(imgui.Col_.text)
    y = corner.y + layout.head.y
    draw.add_text(imgui.get_font(), _TITLE_SCALE * em, ImVec2(corner.x, y), title_color, _TITLE)
    y += (_TITLE_SCALE + 0.1) * em
    draw.add_text(ImVec2(corner.x, y), theme.colors.text_dim, fit_text(_PROMISE, layout.width))
    if len(layout.cards) > layout.permanent_count:
        y = corner.y + layout.hint.end
        draw.add_line(ImVec2(corner.x, y), ImVec2(corner.x + layout.width, y), theme.colors.box)
    y = corner.y + layout.hint.y + 0.4 * em
    is_one_line = imgui.calc_text_size(hint).x <= layout.width
    font, text_corner = imgui.get_font(), ImVec2(corner.x, y)
    draw.add_text(font, em, text_corner, title_color, hint, wrap_width=layout.width)
    hint_size = imgui.calc_text_size(hint, wrap_width=layout.width)
    rects.note_at(
        "start hint",
        (text_corner.x, text_corner.y, text_corner.x + hint_size.x, text_corner.y + hint_size.y),
    )
    if layout.is_roomy and is_one_line:
        text_corner = ImVec2(corner.x, y + _LINE_EM * em)
        draw.add_text(text_corner, theme.colors.text_dim, fit_text(_DROP_HINT, layout.width))


def has_keyboard() -> bool:
    """Return True if the window has the keyboard: no popup, field or button takes the keys.

    Call this before popups are drawn, because a popup that Enter closes is gone afterwards.
    """
    flags, io = imgui.PopupFlags_, imgui.get_io()
    is_popup = imgui.is_popup_open("", flags.any_popup_id | flags.any_popup_level)
    is_modified = io.key_ctrl or io.key_shift or io.key_alt or imgui.is_any_item_active()
    return not (is_popup or is_modified or io.want_text_input)
