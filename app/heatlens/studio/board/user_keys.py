"""Read the user's own keys from `keys.json`, and give them to the commands.

The file is one object, with the name of a command and its key, or "" for no key:

    {"Undo": "Ctrl+Y", "Grid of looks": "Shift+V", "Copy picture": ""}
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.media.files.json_record import JsonEntry, read_json
from heatlens.studio.board.command import Command

FILE = "keys.json"  # in the folder of the preferences
NAMED_KEYS = (
    *("[", "]", "+", "-", "/", ",", ".", "?", "Up", "Down", "Left", "Right", "Space", "Home"),
    *("End", "Delete", "Tab", "Backspace", "F1", "F10", "F11", "F12"),
)
_KEY = re.compile(rf"(Ctrl\+)?(Shift\+)?([A-Z0-9]|{'|'.join(map(re.escape, NAMED_KEYS))})")


def read_user_keys(preferences: Path | None) -> tuple[Mapping[str, str], str]:
    """Return the keys by command from the file beside the preferences, and what is wrong or ""."""
    path = None if preferences is None else preferences.with_name(FILE)
    if path is None or not path.is_file():
        return {}, ""
    try:
        return _checked(read_json(path)), ""
    except InputError as error:
        return {}, f"{error} The usual keys are used."


def _checked(top: JsonEntry) -> dict[str, str]:
    """Return the keys by name of the command; refuse a malformed key, or one given twice."""
    keys: dict[str, str] = {}
    for name, key in top.mapping_of(str).items():
        entry = JsonEntry(top.path, place=name, value=key)
        if key and _KEY.fullmatch(key) is None:
            entry.refuse(f"{key!r} is no key such as 'Ctrl+Shift+Z', 'F11' or '['")
        holder = next((owner for owner, its in keys.items() if key and its == key), "")
        if holder:
            entry.refuse(f"{key!r} is the key of {holder!r} already")
        keys[name] = key
    return keys


def with_user_keys(commands: Iterable[Command], keys: Mapping[str, str]) -> tuple[Command, ...]:
    """Return the commands with the user's keys.

    A command whose usual key the user gave to another one has none, unless it was given one too.
    """
    all_commands = tuple(commands)
    taken = {keys[command.name] for command in all_commands if command.name in keys}
    return tuple(
        replace(it, key=keys.get(it.name, "" if it.key in taken else it.key)) for it in all_commands
    )


def problem_of_keys(commands: Iterable[Command], keys: Mapping[str, str]) -> str:
    """Return a sentence about unknown commands and about commands that lost their key, or ""."""
    all_commands = tuple(commands)
    names = {command.name for command in all_commands}
    meaning = {key: name for name, key in keys.items() if key and name in names}
    unknown = [f"there is no command {name!r}" for name in keys if name not in names]
    lost = [
        f"{it.key} means {meaning[it.key]!r} now, and no longer {it.name!r}"
        for it in all_commands
        if it.key in meaning and it.name not in keys
    ]
    problem = "; ".join([*unknown, *lost])
    return f"{FILE}: {problem}." if problem else ""
