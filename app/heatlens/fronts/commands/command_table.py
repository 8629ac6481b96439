"""The table of the commands, and the choice of the command from the words of a command line.

Importing a command takes up to a second. Therefore its name, its line in the help and its wing are
listed here, and only the module of the requested command is imported.
"""

import difflib
import importlib
import os
from collections.abc import Sequence
from types import ModuleType
from typing import NamedTuple

from heatlens.core.base.errors import InputError

_GENERAL_OPTIONS = ("-q", "--quiet", "-v", "--verbose")  # may stand before the command
DESKTOP_OPTIONS = ("--install-desktop", "--uninstall-desktop")
_PROGRAM_OPTIONS = ("-h", "--help", "-V", "--version", "--print-completion", *DESKTOP_OPTIONS)


class Command(NamedTuple):
    """A command before its module is imported."""

    help: str  # its line in `heatlens --help`
    wing: str = "fronts"


COMMANDS = {
    "view": Command("open the window (also: heatlens plate.exr)"),
    "render": Command("render a plate with depth of field"),
    "export": Command("render the frames of a shot to files or a movie"),
    "shot": Command("make a shot with keys and marks, show it, write its pull sheet"),
    "reel": Command("make a reel of shots, or follow a changed edit"),
    "camera": Command("write the lens of a shot as a camera for USD, Nuke, Blender and scripts"),
    "info": Command("show the contents of a render or a 3D scene, and how its depth is read"),
    "compare": Command("measure how far a picture is from its truth", "lab"),
    "study": Command("compare every method on one frame, as a page", "lab"),
    "bench": Command("measure how long a frame takes on this machine", "lab"),
    "serve": Command("share a picture with tablets and browsers"),
    "help": Command("find options, keys and sections of the manual by words"),
    "kits": Command("list the lens kits"),
    "doctor": Command("check that everything works on this machine"),
    "report": Command("pack doctor, log and headers for a bug report"),
    "addon": Command("write the add-on for Blender as a file to install"),
    "worker": Command("make frames for exports on other machines"),
}


def module_of(name: str) -> ModuleType:
    """Import the module of a command; it is found by name, also in the laboratory wing."""
    return importlib.import_module(f"heatlens.{COMMANDS[name].wing}.commands.{name}")


def put_command_first(argv: Sequence[str]) -> list[str]:
    """Put the command first: `view` if none is named.

    Raises InputError for a misspelt command that is not a file.
    """
    words = list(argv)
    if not words:
        return ["view"]
    first = words[0]
    if first in _GENERAL_OPTIONS:
        command, *command_words = put_command_first(words[1:])
        return [command, first, *command_words]
    if first in (*COMMANDS, *_PROGRAM_OPTIONS):
        return words
    if first == "version" and not os.path.exists(first):
        return ["--version"]
    similar = difflib.get_close_matches(first, COMMANDS, 1)
    if similar and not os.path.exists(first):
        raise InputError(f"There is no command or file {first!r}. Did you mean {similar[0]}?")
    return ["view", *words]
