"""Draw the command palette: typed words find commands, settings and passages of the manual."""

import webbrowser
from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.manual_search import Passage, best_passages, manual_passages, page_of
from heatlens.studio.board.command import Command
from heatlens.studio.ui import rects, texts, topmost, widgets

_TITLE = "Find a command"
_MOST_PASSAGES = 6
_MOST_CHARACTERS = 240  # of a passage that is shown
_LEAST_TYPED = 3  # characters before the manual is searched


def matches(command: Command, words: str) -> bool:
    """Return True if every typed word is in name, menu or synonyms, in any order."""
    text = " ".join((command.menu, command.name, *command.synonyms)).lower()
    return all(word in text for word in words.lower().split())


def found(commands: Sequence[Command], words: str) -> list[Command]:
    """Return the commands that match, those first to whose names the words are nearest."""
    matching = (command for command in commands if matches(command, words))
    return sorted(matching, key=lambda command: distance(command, words))


def distance(command: Command, words: str) -> int:
    """Return how far matching words are from the name of a command.

    -1 is its whole name, 0 a part of it, n its n-th synonym, and the last its menu.
    """
    if words.strip().lower() == command.name.lower():
        return -1
    names = [name.lower() for name in (command.name, *command.synonyms)]
    places = (
        next((place for place, name in enumerate(names) if word in name), len(names))
        for word in words.lower().split()
    )
    return max(places, default=0)


class Palette:
    """A popup with a text field and the list of commands that match it."""

    def __init__(self) -> None:
        self._is_opening = False
        self._text = ""
        self._passages: Sequence[Passage] = ()  # of the manual, about the text
        self._selected_row = 0
        self._has_moved = False  # whether the selected row changed in this frame

    @property
    def is_open(self) -> bool:
        """True while the palette is open or opens in the next frame."""
        return self._is_opening or bool(imgui.is_popup_open(_TITLE))

    def open(self) -> None:
        """Open the palette in the next frame."""
        self._is_opening, self._text, self._selected_row = True, "", 0
        self._passages = ()

    def draw(self, commands: Sequence[Command]) -> Command | None:
        """Draw the palette if open; return the command that was chosen, which may be barred."""
        if self._is_opening:
            imgui.open_popup(_TITLE)
        screen = imgui.get_main_viewport()
        em = imgui.get_font_size()
        middle = ImVec2(screen.get_center().x, screen.pos.y + 4 * em)
        imgui.set_next_window_pos(middle, imgui.Cond_.appearing, ImVec2(0.5, 0.0))
        imgui.set_next_window_size(ImVec2(36 * em, 26 * em))
        if not imgui.begin_popup(_TITLE):
            return None
        topmost.disable_key_navigation()
        command = self._draw_content(commands)
        if command is not None or topmost.is_escaped():
            imgui.close_current_popup()
        imgui.end_popup()
        return command

    def _draw_content(self, commands: Sequence[Command]) -> Command | None:
        """Draw the text field and the matching commands; return the chosen one, or None."""
        if self._is_opening:
            imgui.set_keyboard_focus_here()
            self._is_opening = False
        imgui.set_next_item_width(-1)
        has_changed, self._text = imgui.input_text_with_hint(
            "##words", "a command, a setting or a question", self._text
        )
        matching = found(commands, self._text)
        if (
            imgui.is_item_deactivated() and not matching
        ):  # Enter without a match: edit the text again
            imgui.set_keyboard_focus_here(-1)
        if has_changed:
            self._passages = self._find_passages()
        old_row, self._selected_row = self._selected_row, 0 if has_changed else self._selected_row
        self._move_selection(len(matching))
        self._has_moved = has_changed or self._selected_row != old_row
        picked_action = None
        imgui.begin_child("found")
        for index, command in enumerate(matching):
            if self._draw_row(command, index == self._selected_row, command.why_not()):
                picked_action = command
        if self._passages:
            self._draw_passages()
        imgui.end_child()
        if matching and imgui.is_key_pressed(imgui.Key.enter):
            picked_action = matching[self._selected_row]
        return picked_action

    def _find_passages(self) -> Sequence[Passage]:
        """Return what the manual says about the text, once it has enough characters."""
        if len(self._text) < _LEAST_TYPED:
            return ()
        return best_passages(manual_passages(has_references=False), self._text, _MOST_PASSAGES)

    def _draw_passages(self) -> None:
        """Draw the passages of the manual below the commands; a click opens the page of one."""
        imgui.separator_text("In the manual")
        for number, passage in enumerate(self._passages):
            if imgui.text_link(f"{passage.place}##{number}"):
                webbrowser.open(page_of(passage).as_uri())
            rects.note(f"page {passage.place}")
            imgui.text_wrapped(passage.shortened(_MOST_CHARACTERS))
            widgets.spacer()

    def _move_selection(self, count: int) -> None:
        """Move the selection among `count` rows with the arrow keys."""
        if imgui.is_key_pressed(imgui.Key.down_arrow):
            self._selected_row += 1
        if imgui.is_key_pressed(imgui.Key.up_arrow):
            self._selected_row -= 1
        self._selected_row = min(max(self._selected_row, 0), max(count - 1, 0))

    def _draw_row(self, command: Command, is_selected: bool, why_not: str) -> bool:
        """Draw the row of a command, barred if `why_not` has text; return True if clicked."""
        with widgets.disabled(bool(why_not)):
            is_clicked, _ = imgui.selectable(f"{command.name}##{command.menu}", is_selected)
        rects.note(f"palette {command.name}")
        texts.disabled_tip(why_not)
        if is_selected and self._has_moved:
            imgui.set_scroll_here_y()
        place = distance(command, self._text)
        if 0 < place <= len(command.synonyms):  # why it is in the list
            imgui.same_line(imgui.calc_text_size(command.name).x + 2 * imgui.get_font_size())
            imgui.text_disabled(command.synonyms[place - 1])
        right_text = f"{command.menu}   {texts.named_keys(command.key)}"
        imgui.same_line(imgui.get_window_width() - imgui.calc_text_size(right_text).x - 24)
        imgui.text_disabled(right_text)
        return bool(is_clicked)
