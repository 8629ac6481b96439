"""Write app/manual/keys.md: the mouse, and all commands with their keys.

    python tests/manual_keys.py

It is made of the commands alone. Run it when a command, its key or its search words have changed.
"""

from collections.abc import Sequence
from pathlib import Path

from heatlens.studio.board.command import MENUS, Command
from heatlens.studio.ui.keys_window import mouse_sections
from support.commands import listed_commands

PAGE = Path(__file__).parents[1] / "app" / "manual" / "keys.md"
_HEAD = """\
# Mouse, keys and commands

`?` shows the keys in the window. `Ctrl+Shift+P` finds every command, also by the words of the last
column.
"""


def key_page(commands: Sequence[Command]) -> str:
    """Return the page: what the mouse does, and a table of the commands of each menu."""
    mouse = "".join(
        f"\n## {section.title}\n\n| gesture | what it does |\n| --- | --- |\n"
        + "".join(f"| {gesture} | {what} |\n" for gesture, what in section.rows)
        for section in mouse_sections(has_camera=True)
    )
    menus = (
        f"\n## {menu}\n\n| command | key | found by, too |\n| --- | --- | --- |\n"
        + "".join(_row(command) for command in commands if command.menu == menu)
        for menu in MENUS
    )
    return _HEAD + mouse + "".join(menus)


def _row(command: Command) -> str:
    key = command.key and f"`{command.key}`"
    return f"| {command.name} | {key} | {', '.join(command.synonyms)} |\n"


if __name__ == "__main__":
    PAGE.write_text(key_page(listed_commands()), encoding="utf-8")
