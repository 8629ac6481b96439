"""The list of commands without a window: for tests that need only their names, menus and keys."""

from typing import Any

from heatlens.studio.board.command import Command, in_menu_order
from heatlens.studio.board.commands import named_commands
from heatlens.studio.ui.setting_places import setting_places
from heatlens.studio.ui.window_commands import window_commands


class _Nothing:
    """Has every attribute, and each is nothing again: commands can be bound to it, not done."""

    def __getattr__(self, name: str) -> "_Nothing":
        return self

    def __call__(self, *_: object) -> "_Nothing":
        raise AssertionError("This command is bound to no session.")


def listed_commands() -> tuple[Command, ...]:
    """Return every command, in the order of the menus; none of them can be done."""
    nothing: Any = _Nothing()
    return in_menu_order((*named_commands(nothing), *window_commands(nothing)))


def listed_settings() -> tuple[Command, ...]:
    """Return a command for each setting of a panel, which would show it; none can be done."""
    nothing: Any = _Nothing()
    return setting_places(nothing, nothing, nothing)
