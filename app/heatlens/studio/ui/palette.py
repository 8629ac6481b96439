"""Draw the command palette, in which the user finds a command by typing parts of its name."""

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from heatlens.studio.board.command import Command
from heatlens.studio.ui import probe, texts, topmost, widgets

_TITLE = "Find a command"


def matches(command: Command, words: str) -> bool:
    """Return True if every typed word is in name, menu or synonyms, in any order."""
    text = " ".join((command.menu, command.name, *command.synonyms)).lower()
    return all(word in text for word in words.lower().split())


class Palette:
    """A popup with a text field and the list of commands that match it."""

    def __init__(self) -> None:
        self._wanted = False
        self._text = ""
        self._chosen = 0
        self._moved = False  # whether the selected row changed in this frame

    @property
    def is_open(self) -> bool:
        """True while the palette is open or opens in the next frame."""
        return self._wanted or bool(imgui.is_popup_open(_TITLE))

    def open(self) -> None:
        """Open the palette in the next frame."""
        self._wanted, self._text, self._chosen = True, "", 0

    def draw(self, commands: Sequence[Command]) -> Command | None:
        """Draw the palette if open; return the command that was chosen, which may be barred."""
        if self._wanted:
            imgui.open_popup(_TITLE)
        screen = imgui.get_main_viewport()
        em = imgui.get_font_size()
        middle = ImVec2(screen.get_center().x, screen.pos.y + 4 * em)
        imgui.set_next_window_pos(middle, imgui.Cond_.appearing, ImVec2(0.5, 0.0))
        imgui.set_next_window_size(ImVec2(30 * em, 22 * em))
        if not imgui.begin_popup(_TITLE):
            return None
        topmost.answers_keys_itself()
        command = self._draw_inside(commands)
        if command is not None or topmost.is_escaped():
            imgui.close_current_popup()
        imgui.end_popup()
        return command

    def _draw_inside(self, commands: Sequence[Command]) -> Command | None:
        if self._wanted:
            imgui.set_keyboard_focus_here()
            self._wanted = False
        imgui.set_next_item_width(-1)
        changed, self._text = imgui.input_text_with_hint("##words", "what to do", self._text)
        shown = [command for command in commands if matches(command, self._text)]
        if imgui.is_item_deactivated() and not shown:  # Enter without a match: edit the text again
            imgui.set_keyboard_focus_here(-1)
        before, self._chosen = self._chosen, 0 if changed else self._chosen
        self._move(len(shown))
        self._moved = changed or self._chosen != before
        picked = None
        imgui.begin_child("found")
        for index, command in enumerate(shown):
            if self._row(command, index == self._chosen, command.why_not()):
                picked = command
        imgui.end_child()
        if shown and imgui.is_key_pressed(imgui.Key.enter):
            picked = shown[self._chosen]
        return picked

    def _move(self, count: int) -> None:
        if imgui.is_key_pressed(imgui.Key.down_arrow):
            self._chosen += 1
        if imgui.is_key_pressed(imgui.Key.up_arrow):
            self._chosen -= 1
        self._chosen = min(max(self._chosen, 0), max(count - 1, 0))

    def _row(self, command: Command, is_chosen: bool, why_not: str) -> bool:
        with widgets.disabled(bool(why_not)):
            clicked, _ = imgui.selectable(f"{command.name}##{command.menu}", is_chosen)
        probe.note(f"palette {command.name}")
        texts.tip_of_barred(why_not)
        if is_chosen and self._moved:
            imgui.set_scroll_here_y()
        aside = f"{command.menu}   {command.key}"
        imgui.same_line(imgui.get_window_width() - imgui.calc_text_size(aside).x - 24)
        imgui.text_disabled(aside)
        return bool(clicked)
