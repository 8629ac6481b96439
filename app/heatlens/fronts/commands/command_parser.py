"""The parser of the command line, with suggestions for wrong words.

For a misspelled word, the error suggests the nearest known one.
"""

import argparse
import os
import re
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from heatlens.fronts.commands.command_table import COMMANDS, DESKTOP_OPTIONS, module_of
from heatlens.fronts.commands.options.option_suggestion import (
    is_other_program_option,
    option_suggestion,
)
from heatlens.fronts.commands.output.help_page import add_help_options
from heatlens.version import __version__

_EPILOG = """\
examples:
  heatlens plate.exr                        # the window; alone: with a start screen
  heatlens serve shot.heatlens.json         # for a tablet, in its browser
  heatlens render plate.exr -o out.exr --f-stop 2 --focus-distance 2.24 \\
      --focal-length 50 --sensor-width 36
  heatlens render plate.exr -o out.png --focus-at 960,540 --f-stop 1.4
  heatlens export shot.heatlens.json -o out/name.####.exr
  heatlens camera shot.heatlens.json -o cam.usda
  heatlens info plate.exr
  heatlens compare out.exr truth.exr --min-psnr 30
  heatlens doctor
  heatlens help unit of a table             # searches the manual

`heatlens COMMAND --help` explains each command.
"""

_MOST_LISTED_OPTIONS = 16  # options in a usage line; a longer list becomes [options]


class _Parser(argparse.ArgumentParser):
    """Reports a wrong option in two lines; argparse would print the whole usage before them."""

    def __init__(self, *args: Any, **options: Any) -> None:
        """Make a parser with the options that all commands have."""
        super().__init__(*args, **options | {"add_help": False})
        if self.prog.count(" "):
            add_help_options(self)
        else:
            self.add_argument(
                "-h",
                "--help",
                action=_ProgramHelp,
                nargs="*",
                metavar="WORD",
                help="print this, the help of a command, or what the manual says of other words",
            )
        self.add_argument(
            "-q",
            "--quiet",
            action="store_true",
            default=argparse.SUPPRESS,
            help="print only results and errors",
        )
        self.add_argument(
            "-v",
            "--verbose",
            action="store_true",
            default=argparse.SUPPRESS,
            help="print why things are done as they are, and how long they take",
        )
        self.add_argument(
            "--run-networks",
            action="store_true",
            default=argparse.SUPPRESS,
            help="run a depth network that a shot names, without asking",
        )
        # No option begins with a digit, so such a word is a value: a frame, a pixel, a number.
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")

    def format_help(self) -> str:
        """Return the help; a usage with many options is shortened, as it would fill the screen."""
        if self.usage is None and len(self._option_string_actions) > _MOST_LISTED_OPTIONS:
            formatter = self._get_formatter()
            required_actions = [it for it in self._actions if it.required or not it.option_strings]
            formatter.add_usage(None, required_actions, [], "")
            words = formatter.format_help().strip().removeprefix(self.prog)
            self.usage = f"%(prog)s [options]{words.replace('%', '%%')}"
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        """Exit with code 2. Subcommands use this class too, because argparse inherits it."""
        self.exit(2, f"heatlens: {message}\n`{self.prog} --help` explains.\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse, and refuse unknown arguments here.

        Argparse would report them for the parent command.
        """
        words = self._join_negative_values(sys.argv[1:] if args is None else args)
        parsed, unknown = super().parse_known_args(words, namespace)
        if unknown and self.prog.endswith(" view") and parsed.plate in COMMANDS:
            corrected_words = " ".join((parsed.plate, *unknown))
            advice = f"options come after the command, as in: heatlens {corrected_words} --f-stop 2"
            self.exit(2, f"heatlens: {advice}\n`heatlens {parsed.plate} --help` explains.\n")
        if len(unknown) > 1 and all(map(os.path.isfile, unknown)):
            self.error(_unquoted_pattern_message(unknown))
        if unknown:
            self.error(
                f"unrecognized arguments: {' '.join(unknown)}{option_suggestion(unknown, self)}"
            )
        return parsed, unknown

    def _join_negative_values(self, words: Sequence[str]) -> list[str]:
        """Return the words, with an option and its value joined if the value begins with a minus.

        argparse would take values such as -2-1, -70,50 and file names with a minus for options.
        """
        joined: list[str] = []
        for word in words:
            previous_word = joined[-1] if joined else ""
            is_value = len(word) > 1 and word[0] == "-" and not self._begins_option(word)
            if is_value and "--" not in joined and self._takes_one_value(previous_word):
                joined[-1] = (
                    f"{previous_word}={word}"
                    if previous_word.startswith("--")
                    else previous_word + word
                )
            else:
                joined.append(word)
        return joined

    def _begins_option(self, word: str) -> bool:
        """Return True if the word is an option or the beginning of a long one."""
        name = word.partition("=")[0]
        is_long = word.startswith("--")
        return name in self._option_string_actions or (
            is_long and bool(self._matching_actions(word))
        )

    def _takes_one_value(self, option: str) -> bool:
        """Return True if the word is an option that needs exactly one value."""
        return any(action.nargs is None for action in self._matching_actions(option))

    def _matching_actions(self, option: str) -> list[argparse.Action]:
        """Return the actions that an option or its beginning names."""
        options = self._option_string_actions
        if option in options:
            return [options[option]]
        is_long = option.startswith("--") and len(option) > 2
        name = option.partition("=")[0]
        return [it for long, it in options.items() if is_long and long.startswith(name)]

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse a value that is not among the choices, and suggest the closest one."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            from heatlens.core.model.option import suggest_similar

            error.message += suggest_similar(str(value), map(str, action.choices or ()))
            raise

    def _get_option_tuples(self, option_string: str) -> list[Any]:
        """Return the options with this prefix; none for an option of other programs."""
        return (
            []
            if is_other_program_option(option_string)
            else super()._get_option_tuples(option_string)
        )


def _unquoted_pattern_message(files: Sequence[str]) -> str:
    """Return the error message for files that the shell put in the place of a pattern."""
    # Loads fileseq, and only this needs it.
    from heatlens.media.sequence.names import parse_frame_name

    first_file = Path(files[0])
    pattern = str(first_file.with_name(parse_frame_name(first_file.name)[0].text))
    suggested_pattern = (
        pattern if "#" in pattern else f"{first_file.with_name('plate')}.####{first_file.suffix}"
    )
    return (
        f"{len(files)} files too many. Put a pattern in quotes, with # for digits: "
        f"'{suggested_pattern}'."
    )


class _ProgramHelp(argparse.Action):
    """Prints the help of the program, or what the command `help` says of the words after it."""

    def __call__(self, parser: argparse.ArgumentParser, *given: Any) -> None:
        """Print the help and end; `given` are the namespace, the words and the option."""
        if not given[1]:
            parser.print_help()
            parser.exit()
        raise SystemExit(module_of("help").run(argparse.Namespace(words=given[1])))


class _Completion(argparse.Action):
    """Prints the script and ends, as --help does."""

    def __call__(self, parser: argparse.ArgumentParser, *values: Any) -> None:
        """Print the completion; `values` are the namespace, the shell and the option."""
        import shtab

        print(shtab.complete(parser, shell=values[1]))
        raise SystemExit(0)


class _Desktop(argparse.Action):
    """Adds the program to the desktop or removes it, and ends."""

    def __call__(self, *given: Any) -> None:
        """Do what the option says, which is the last of the `given` values."""
        from heatlens.studio.ui import desktop_files

        is_install = given[-1] == DESKTOP_OPTIONS[0]
        print(desktop_files.install() if is_install else desktop_files.uninstall())
        raise SystemExit(0)


def build_parser(names: Collection[str] = COMMANDS) -> argparse.ArgumentParser:
    """Build the command line of the commands `names`; the default is all of them.

    The help names the others too, which cannot be run.
    """
    parser: argparse.ArgumentParser = _Parser(
        prog="heatlens",
        description="Puts a real lens in front of a pinhole render: depth of field by diffusion.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("-V", "--version", action="version", version=f"heatlens {__version__}")
    parser.add_argument(
        "--print-completion",
        action=_Completion,
        choices=("bash", "zsh", "tcsh"),
        help="print a completion script for this shell",
    )
    install, uninstall = DESKTOP_OPTIONS
    parser.add_argument(
        install,
        action=_Desktop,
        nargs=0,
        help="add heatlens to the menu and the file types of this user",
    )
    parser.add_argument(uninstall, action=_Desktop, nargs=0, help="undo that")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        if name in names:
            add_command(commands, name, command.help, module_of(name))
        elif not names:
            commands.add_parser(name, help=command.help)
    return parser


def add_command(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    help_line: str,
    module: ModuleType,
) -> None:
    """Add the command `name`.

    `module` has its DESCRIPTION, examples as EPILOG if there are any, `add_options(parser)` and
    `run(args)`.
    """
    parser = commands.add_parser(
        name,
        help=help_line,
        description=module.DESCRIPTION,
        epilog=getattr(module, "EPILOG", None),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    module.add_options(parser)
    parser.set_defaults(run=getattr(module, "run", None))
