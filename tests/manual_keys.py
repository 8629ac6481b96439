"""Write app/manual/keys.md: the mouse, all commands with their keys, and all settings.

    python tests/manual_keys.py

It is made of the commands alone. Run it when a command, its key or its search words have changed.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

from heatlens.studio.board.command import MENUS, Command
from heatlens.studio.ui.keys_window import mouse_sections
from heatlens.studio.ui.setting_places import FORMER_PANELS
from support.commands import listed_commands, listed_settings

PAGE = Path(__file__).parents[1] / "app" / "manual" / "keys.md"
_HEAD = """\
# Mouse, keys and commands

`F1` shows these keyboard shortcuts in the window. `?` finds every command and setting, also by the
words of the last column. `keys.json` in the folder of the preferences gives commands other keys.
"""


def key_page(commands: Sequence[Command]) -> str:
    """Return the page: what the mouse does, a table of each menu, and the settings of the tabs."""
    sections = [
        _section(it.title, ("gesture", "what it does"), it.rows)
        for it in mouse_sections(has_camera=True)
    ]
    for menu in MENUS:
        rows = [
            (it.name, it.key and f"`{it.key}`", ", ".join(it.synonyms))
            for it in commands
            if it.menu == menu
        ]
        sections.append(_section(menu, ("command", "key", "found by, too"), rows))
    settings = [
        (it.name, it.menu, ", ".join(word for word in it.synonyms if word not in FORMER_PANELS))
        for it in commands
        if it.menu not in MENUS and it.name not in FORMER_PANELS
    ]
    return (
        _HEAD
        + "".join(sections)
        + _section("Settings", ("setting", "where", "found by, too"), settings)
    )


def _section(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(row)} |\n" for row in (head, ["---"] * len(head), *rows)]
    return f"\n## {title}\n\n{''.join(lines)}"


if __name__ == "__main__":
    PAGE.write_text(key_page((*listed_commands(), *listed_settings())), encoding="utf-8")
