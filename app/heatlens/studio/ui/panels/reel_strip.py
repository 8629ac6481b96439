"""Draw the strip of a reel: its shots side by side, with the focus at both ends of each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.shot.reel import CutFocus, Reel, ReelShot
from heatlens.core.model.units import label_distance
from heatlens.render.gpu.resources import Texture
from heatlens.studio.board.controls import FileControl
from heatlens.studio.ui import texts, theme, widgets
from heatlens.studio.ui.panels.reel_stills import ReelStills

_HEAD_EM, _CARD_EM, _GAP_EM, _PADDING_EM, _CROSS_EM = 10.4, 12.4, 0.4, 0.25, 1.3
_STILL_SHARE = 0.42  # of the width of a card, at most
_DRAG_EM = 0.8  # a card is moved by a drag that is so long at least
_CHILD = imgui.WindowFlags_.horizontal_scrollbar | imgui.WindowFlags_.no_scroll_with_mouse


@dataclass(frozen=True)
class StripButtons:
    """What the buttons of the strip do."""

    add: Callable[[], None]
    save: Callable[[], None]


class ReelStrip:
    """Draws the strip of the open reel, and applies what the mouse does in it."""

    def __init__(self, files: FileControl, stills: ReelStills, buttons: StripButtons) -> None:
        self._files, self._stills, self._buttons = files, stills, buttons
        self._shown_number = -1  # the shot that was scrolled to

    def draw(self, unit: str) -> None:
        """Draw the name of the reel with its buttons, and a card for each shot."""
        reel = self._files.reel.reel
        if reel is None:
            return
        em = imgui.get_font_size()
        imgui.begin_group()
        self._draw_head(reel)
        imgui.end_group()
        imgui.same_line(_HEAD_EM * em + 2 * imgui.get_style().window_padding.x)
        if imgui.begin_child("shots", ImVec2(0, 0), imgui.ChildFlags_.none, _CHILD):
            self._draw_cards(reel, unit)
        imgui.end_child()

    def _draw_head(self, reel: Reel) -> None:
        """Draw the name of the reel, which shot is open, and the buttons."""
        count = f"{self._files.reel.number + 1} of {len(reel.shots)}"
        width = _HEAD_EM * imgui.get_font_size() - texts.text_width(f"  {count}")
        imgui.text(texts.fit_text(printable(self._files.reel.name), width))
        texts.tooltip(str(self._files.reel.path or "This reel has no file yet."))
        imgui.same_line()
        imgui.text_disabled(count)
        if widgets.small_button("Add...", "add shots", "Add shots, or drop files here"):
            self._buttons.add()
        imgui.same_line()
        if widgets.small_button("Save", "save reel", "Save the order of the shots as a reel"):
            self._buttons.save()
        imgui.same_line()
        if widgets.small_button("Leave", "leave reel", "Go on with this shot alone"):
            self._files.reel.leave()

    def _draw_cards(self, reel: Reel, unit: str) -> None:
        """Draw the cards side by side; the wheel scrolls, and the open shot comes into sight."""
        em, corner = imgui.get_font_size(), imgui.get_cursor_screen_pos()
        height = max(imgui.get_window_height() - imgui.get_style().scrollbar_size, em)
        row = _Row(corner.x, corner.y, _CARD_EM * em, height, _GAP_EM * em)
        for number, shot in enumerate(reel.shots):
            card = _Card(number, shot, row.corner(number), row.end(number))
            if imgui.is_rect_visible(card.corner, card.end):
                self._draw_card(card, unit)
            self._press_card(card, row, len(reel.shots))
        notches = imgui.get_io().mouse_wheel
        if notches and imgui.is_window_hovered():
            imgui.set_scroll_x(imgui.get_scroll_x() - notches * row.pitch)
        if self._shown_number != self._files.reel.number:
            self._shown_number = self._files.reel.number
            middle = (self._shown_number + 0.5) * row.pitch
            imgui.set_scroll_x(max(middle - imgui.get_window_width() / 2, 0.0))

    def _draw_card(self, card: "_Card", unit: str) -> None:
        """Draw a shot: its still, name, frames and focus; a cross removes it."""
        is_open, is_pointed = card.number == self._files.reel.number, card.is_pointed
        slot = imgui.Col_.header_active if is_open else imgui.Col_.frame_bg
        slot = imgui.Col_.header_hovered if is_pointed and not is_open else slot
        rim = theme.colors.handle if is_open else imgui.get_color_u32(imgui.Col_.border)
        draw, rounding = imgui.get_window_draw_list(), imgui.get_style().frame_rounding
        draw.add_rect_filled(card.corner, card.end, imgui.get_color_u32(slot), rounding)
        draw.add_rect(card.corner, card.end, rim, rounding, 2.0 if is_open else 1.0)
        texture = self._stills.texture_of(self._files, card.number)
        if texture is not None:
            _draw_still(card, texture)
        dim = imgui.get_color_u32(imgui.Col_.text_disabled)
        focus = _focus_text(self._files.reel.focus_of(card.number), unit), dim
        lines = [
            (printable(card.shot.name), imgui.get_color_u32(imgui.Col_.text)),
            focus if card.shot.source else ("no media", theme.colors.damaged),
            (_frames_text(card.shot), dim),
        ]
        _draw_lines(card, lines)

    def _press_card(self, card: "_Card", row: "_Row", count: int) -> None:
        """Open a card that is clicked; move one that is dragged; remove one by its cross."""
        shot, editing = card.shot, self._files.commands.reel_editing
        if card.is_pointed and _cross(card):
            editing.remove(card.number)
            return
        size = ImVec2(row.width, row.height)
        notes = "\n".join((*shot.marks, *shot.notes))
        widgets.invisible_button(f"shot {shot.name}", card.corner, size, notes)
        way = imgui.get_mouse_drag_delta(imgui.MouseButton_.left, _DRAG_EM * imgui.get_font_size())
        place = min(max(round((imgui.get_mouse_pos().x - row.x) / row.pitch), 0), count)
        if imgui.is_item_active() and way.x:
            row.draw_place(place)
        elif imgui.is_item_deactivated() and way.x:
            new_number = place - (place > card.number)
            if new_number != card.number:
                editing.move(card.number, new_number)
        elif imgui.is_item_deactivated() and imgui.is_item_hovered():
            self._files.reel.go(card.number)


@dataclass(frozen=True)
class _Row:
    """Where the cards are, in screen units."""

    x: float
    y: float
    width: float
    height: float
    gap: float

    @property
    def pitch(self) -> float:
        return self.width + self.gap

    def corner(self, number: int) -> ImVec2:
        return ImVec2(self.x + number * self.pitch, self.y)

    def end(self, number: int) -> ImVec2:
        return ImVec2(self.x + number * self.pitch + self.width, self.y + self.height)

    def draw_place(self, number: int) -> None:
        """Draw the line that shows before which card a dragged one will be."""
        x = self.x + number * self.pitch - self.gap / 2
        ends = ImVec2(x, self.y), ImVec2(x, self.y + self.height)
        imgui.get_window_draw_list().add_line(*ends, theme.colors.handle, self.gap)


@dataclass(frozen=True)
class _Card:
    """A shot of the strip and its place on the screen."""

    number: int
    shot: ReelShot
    corner: ImVec2
    end: ImVec2

    @property
    def is_pointed(self) -> bool:
        """True if the pointer is over the card and drags nothing."""
        is_over = imgui.is_mouse_hovering_rect(self.corner, self.end)
        is_free = imgui.is_window_hovered(imgui.HoveredFlags_.allow_when_blocked_by_active_item)
        return is_over and is_free and not imgui.is_mouse_dragging(imgui.MouseButton_.left)


def _draw_still(card: _Card, texture: Texture) -> None:
    """Draw the first picture of a shot at the left of its card."""
    padding, height = _PADDING_EM * imgui.get_font_size(), card.end.y - card.corner.y
    free_width = _STILL_SHARE * (card.end.x - card.corner.x) - padding
    scale = min(free_width / texture.width, (height - 2 * padding) / texture.height)
    left = card.corner.x + padding
    top = card.corner.y + (height - scale * texture.height) / 2
    end = ImVec2(left + scale * texture.width, top + scale * texture.height)
    flipped_corners = ImVec2(0, 1), ImVec2(1, 0)
    picture = imgui.ImTextureRef(texture.handle)
    imgui.get_window_draw_list().add_image(picture, ImVec2(left, top), end, *flipped_corners)


def _draw_lines(card: _Card, lines: Sequence[tuple[str, int]]) -> None:
    """Draw as many lines, each with its color, beside the still as there is room for."""
    em, line_height = imgui.get_font_size(), imgui.get_text_line_height()
    height = card.end.y - card.corner.y
    x = card.corner.x + _STILL_SHARE * (card.end.x - card.corner.x) + _PADDING_EM * em
    shown_lines = [line for line in lines if line[0]][: max(int(height / line_height), 1)]
    y = card.corner.y + (height - len(shown_lines) * line_height) / 2
    for index, (text, color) in enumerate(shown_lines):
        has_cross = card.is_pointed and index == 0
        room = card.end.x - x - (_CROSS_EM if has_cross else _PADDING_EM) * em
        at = ImVec2(x, y + index * line_height)
        imgui.get_window_draw_list().add_text(at, color, texts.fit_text(text, room))


def _cross(card: _Card) -> bool:
    """Draw the cross that removes a shot; return True if it was pressed."""
    side = _CROSS_EM * imgui.get_font_size()
    corner = ImVec2(card.end.x - side, card.corner.y)
    tip = "Remove this shot from the reel; its files stay"
    name = f"remove {card.shot.name}"
    is_pressed = widgets.invisible_button(name, corner, ImVec2(side, side), tip)
    x, y, arm = corner.x + side / 2, corner.y + side / 2, 0.2 * side
    color, draw = imgui.get_color_u32(imgui.Col_.text), imgui.get_window_draw_list()
    for slope in (arm, -arm):
        ends = ImVec2(x - arm, y - slope), ImVec2(x + arm, y + slope)
        draw.add_line(*ends, color, 0.1 * side)
    return is_pressed


def _frames_text(shot: ReelShot) -> str:
    """Return the frames of the cut, and how it plays them."""
    if shot.frames is None:
        return "all frames"
    return str(shot.frames) if shot.retime is None else f"{shot.frames} at {shot.retime.speed:g}x"


def _focus_text(focus: CutFocus, unit: str) -> str:
    """Return the focus at both ends of a shot; "" if it is not known."""
    ends = [label_distance(m, unit) for m in (focus.first_m, focus.last_m) if m is not None]
    return " to ".join(dict.fromkeys(ends))
