"""Write the keys of all commands into the table of app/MANUAL.md.

    python tests/manual_keys.py

It is made of the commands alone. Run it when a command or its key is new.
"""

from collections.abc import Iterable
from pathlib import Path

from heatlens.studio.board.command import Command, keys_by_menu
from support.commands import listed_commands

MANUAL = Path(__file__).parents[1] / "app" / "MANUAL.md"
_HEAD = "| menu | keys |\n| --- | --- |\n"


def key_table(commands: Iterable[Command]) -> str:
    """Return the table of the keys of these commands, a row for each menu."""
    rows = (
        f"| {menu} | {' · '.join(f'`{key}` {name}' for key, name in keys)} |\n"
        for menu, keys in keys_by_menu(commands).items()
    )
    return _HEAD + "".join(rows)


def with_key_table(manual: str, table: str) -> str:
    """Return the text of the manual with this table in the place of the one that it has."""
    before, head, rest = manual.partition(_HEAD)
    if not head:
        raise SystemExit(f"{MANUAL.name} has no table that begins with {_HEAD.splitlines()[0]!r}.")
    return before + table + "\n" + rest.partition("\n\n")[2]


def main() -> None:
    """Write the table of the manual."""
    text = with_key_table(MANUAL.read_text(encoding="utf-8"), key_table(listed_commands()))
    MANUAL.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
