"""The command `heatlens`: run the subcommand and turn errors into exit codes.

Exit codes: 0 success, 1 `compare`, `doctor` or `info` found what it looks for, 2 an error that the
user can fix, 70 a fault of heatlens, whose report is in a file, 130 stopped with Ctrl-C, 141 the
reader of the output has gone (`| head`).

Only the module of the requested command is imported. `commands.launch` calls this in a separate
process, which it ends when Ctrl-C is pressed.

For a misspelt word, the error suggests the nearest known one.
"""

import argparse
import difflib
import importlib
import os
import re
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from heatlens.core.base.errors import FAULT_CODE, FaultError, HeatlensError, InputError
from heatlens.core.base.faults import told_error
from heatlens.core.base.outside_text import printable
from heatlens.core.base.stopping import stop_was_said
from heatlens.core.model.option import OTHER_NAMES, or_meant
from heatlens.fronts.commands.options.command_parser import add_command
from heatlens.fronts.commands.options.network_option import allow_networks
from heatlens.fronts.commands.options.output_places import check_output_places
from heatlens.fronts.commands.output.say import say_nothing
from heatlens.media.files.picture_formats import movie_named
from heatlens.media.sequence.names import form_of
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
  heatlens study plate.exr --truth truth.exr -o report
  heatlens bench --bokeh disc --quality preview
  heatlens doctor

`heatlens COMMAND --help` explains each command.
"""

_OPTIONS_LISTED = 16  # options in a usage line; a longer list becomes [options]
_OF_LAB = ("bench", "compare", "study")
_COMMANDS = (
    *("view", "render", "export", "shot", "reel", "camera", "info", "compare", "study", "bench"),
    *("serve", "kits", "doctor", "worker"),
)
_ALIKE = 0.7  # of 1 for the same word; --device is 0.62 like --denoise, --f-stop 0.91 like --fstop
_QUIET = ("-q", "--quiet")
_ABOUT_ALL = ("-h", "--help", "-V", "--version", "--print-completion")
_CAMERA_SUFFIXES = (".usd", ".usda", ".usdc", ".json", ".csv")
# What people type who come from other programs.
_OTHER_NAMES = {f"--{other}": f"--{own}" for other, own in OTHER_NAMES.items()}


class _Parser(argparse.ArgumentParser):
    """Reports a wrong option in two lines; argparse would print the whole usage before them."""

    def __init__(self, *args: Any, **options: Any) -> None:
        """Make a parser with the options that all commands have."""
        super().__init__(*args, **options)
        self.add_argument(
            "-q",
            "--quiet",
            action="store_true",
            default=argparse.SUPPRESS,
            help="print only results and errors",
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
        if self.usage is None and len(self._option_string_actions) > _OPTIONS_LISTED:
            formatter = self._get_formatter()
            needed = [it for it in self._actions if it.required or not it.option_strings]
            formatter.add_usage(None, needed, [], "")
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
        words = self._with_values_joined(sys.argv[1:] if args is None else args)
        parsed, unknown = super().parse_known_args(words, namespace)
        if unknown and self.prog.endswith(" view") and parsed.plate in _COMMANDS:
            right = " ".join((parsed.plate, *unknown))
            told = f"options come after the command, as in: heatlens {right} --f-stop 2"
            self.exit(2, f"heatlens: {told}\n`heatlens {parsed.plate} --help` explains.\n")
        if len(unknown) > 1 and all(map(os.path.isfile, unknown)):
            self.error(_unquoted(unknown))
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, self)}")
        return parsed, unknown

    def _with_values_joined(self, words: Sequence[str]) -> list[str]:
        """Join an option and its value where this begins with a minus and is no option itself."""
        joined: list[str] = []
        for word in words:
            before = joined[-1] if joined else ""
            is_value = len(word) > 1 and word[0] == "-" and not self._begins_option(word)
            if is_value and "--" not in joined and self._takes_one_value(before):
                joined[-1] = f"{before}={word}" if before.startswith("--") else before + word
            else:
                joined.append(word)
        return joined

    def _begins_option(self, word: str) -> bool:
        name = word.partition("=")[0]
        is_long = word.startswith("--")
        return name in self._option_string_actions or (is_long and bool(self._named(word)))

    def _takes_one_value(self, option: str) -> bool:
        return any(action.nargs is None for action in self._named(option))

    def _named(self, option: str) -> list[argparse.Action]:
        """Return the actions that an option or its beginning names."""
        known = self._option_string_actions
        if option in known:
            return [known[option]]
        is_begun = option.startswith("--") and len(option) > 2
        name = option.partition("=")[0]
        return [it for long, it in known.items() if is_begun and long.startswith(name)]

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse a value that is not among the choices, and suggest the closest one."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += or_meant(str(value), map(str, action.choices or ()))
            raise

    def _get_option_tuples(self, option_string: str) -> list[Any]:
        """Return the options with this prefix, except those that mean something else elsewhere."""
        return [] if is_name_elsewhere(option_string) else super()._get_option_tuples(option_string)


def _unquoted(files: Sequence[str]) -> str:
    """Return the sentence for files that the shell put in the place of a pattern."""
    first = Path(files[0])
    pattern = str(first.with_name(form_of(first.name)[0].text))
    quoted = pattern if "#" in pattern else f"{first.with_name('plate')}.####{first.suffix}"
    return f"{len(files)} files too many. Put a pattern in quotes, with # for digits: '{quoted}'."


class _Completion(argparse.Action):
    """Prints the script and ends, as --help does."""

    def __call__(self, parser: argparse.ArgumentParser, *given: Any) -> None:
        """Print the completion; `given` are the namespace, the shell and the option."""
        import shtab

        print(shtab.complete(parser, shell=given[1]))
        raise SystemExit(0)


def build_parser(names: Sequence[str] = _COMMANDS) -> argparse.ArgumentParser:
    """Build the command line of the commands `names`; the default is all of them."""
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
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in names:
        add_command(commands, name, _module_of(name))
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`; returns the exit code."""
    try:
        words = _with_command(sys.argv[1:] if argv is None else argv)
        args = _parsed(words)
        say_nothing(getattr(args, "quiet", False))
        allow_networks(getattr(args, "run_networks", False), words[0] in ("view", "serve"))
        count_movie_frames(args)
        check_output_places(args)
        code = int(args.run(args))
        sys.stdout.flush()  # a closed pipe is noticed here, not when Python ends
        return code
    except HeatlensError as error:
        return _failed(error)
    except MemoryError:
        return _failed(
            InputError("there is not enough memory. A smaller --proxy or fewer --layers need less.")
        )
    except BrokenPipeError:
        _drop_output()
        return 128 + 13  # as the shell counts a program ended by SIGPIPE
    except OSError as error:  # errors of files are handled elsewhere: this is e.g. a full disk
        _drop_output()
        where = error.filename or "standard output"
        return _failed(InputError(f"{where}: {error.strerror or error}"))
    except KeyboardInterrupt as stop:
        print("heatlens: stopped", file=sys.stderr, flush=True)
        stop_was_said()
        return 128 + getattr(stop, "number", signal.SIGINT)
    except Exception as error:
        return _failed(told_error(error, "The command ended"))


def _parsed(words: Sequence[str]) -> argparse.Namespace:
    """Parse the words; raise BrokenPipeError where nobody reads what --help and others print."""
    try:
        return build_parser(_needed(words)).parse_args(words)
    except SystemExit:
        sys.stdout.flush()
        raise


def _with_command(argv: Sequence[str]) -> list[str]:
    return with_command(argv, _COMMANDS)


def _needed(words: Sequence[str]) -> tuple[str, ...]:
    """Return the requested command; all commands for the help, none for the version."""
    if words[0] in _COMMANDS:
        return (words[0],)
    return () if words[0] in ("-V", "--version") else _COMMANDS


def _drop_output() -> None:
    """Discard buffered output, which would raise an error again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _failed(error: HeatlensError) -> int:
    """Print an error in one line, and return the exit code."""
    print(f"heatlens: {printable(str(error))}", file=sys.stderr)
    return FAULT_CODE if isinstance(error, FaultError) else 2


def with_command(argv: Sequence[str], commands: Sequence[str]) -> list[str]:
    """Put the command first: `view` if none is named, and --help for `help`.

    Raises InputError for a misspelt command that is not a file.
    """
    words = list(argv)
    if not words:
        return ["view"]
    first, rest = words[0], words[1:]
    if first in _QUIET:
        command, *others = with_command(rest, commands)
        return [command, first, *others]
    if first in (*commands, *_ABOUT_ALL):
        return words
    if first in ("help", "version") and not os.path.exists(first):
        if first == "help" and rest and rest[0] not in commands:
            raise InputError(f"There is no command {rest[0]!r}{_near(rest[0], commands)}")
        return [*rest, "--help"] if first == "help" else ["--version"]
    near = difflib.get_close_matches(first, commands, 1)
    if near and not os.path.exists(first):
        raise InputError(f"There is no command or file {first!r}. Did you mean {near[0]}?")
    return ["view", *words]


def _near(word: str, commands: Sequence[str]) -> str:
    """Return the end of a sentence: the command most like `word`, or else all commands."""
    near = difflib.get_close_matches(word, commands, 1)
    return f". Did you mean {near[0]}?" if near else f"; there are {', '.join(commands)}."


def is_name_elsewhere(option: str) -> bool:
    """Return True for an option of other programs that is called something else here.

    "--aperture" is one, although it is also the beginning of --aperture-image.
    """
    name = option.partition("=")[0]
    return not _OTHER_NAMES.get(name, name).startswith(name)


def _elsewhere(option: str, value: str, prog: str) -> str:
    """Return the end of a sentence on the command that takes an option, or ""."""
    is_file = os.path.splitext(value)[1].lower() in _CAMERA_SUFFIXES
    if option == "--lens-from" or (option == "--camera" and is_file):
        return f". {option} gives the lens of a file to `heatlens shot new` and `heatlens view`."
    if prog.endswith(" camera") and option in _lens_flags():
        return f". The lens is that of the shot: `heatlens shot new` takes {option}."
    return ""


def _lens_flags() -> set[str]:
    from heatlens.fronts.commands.options.lens_options import (
        add_lens_options,  # slow, and seldom needed
    )

    parser = argparse.ArgumentParser(add_help=False)
    add_lens_options(parser)
    return set(parser._option_string_actions)


def meant(unknown: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """Return a sentence that suggests an option like the wrong one, or the command that has it."""
    known = [name for name in parser._option_string_actions if name.startswith("--")]
    for word, after in zip(unknown, (*unknown[1:], ""), strict=True):
        option, _, value = word.partition("=")
        if not option.startswith("--"):
            continue
        if elsewhere := _elsewhere(option, value or after, parser.prog):
            return elsewhere
        other = _OTHER_NAMES.get(option)
        near = [other] if other in known else _like(option, known)
        if near:
            return f". Did you mean {' or '.join(near)}?"
        if having := _commands_with(option):
            return f". It is an option of {' and '.join(f'`heatlens {name}`' for name in having)}."
    return ""


def _like(option: str, known: Sequence[str]) -> list[str]:
    """Return the two options that begin with the same word, or else the one most like it.

    The dashes are left out, because they would make every two short words alike.
    """
    longer = [name for name in known if name.startswith(f"{option}-")]
    if 0 < len(longer) <= 2:
        return sorted(longer, reverse=True)
    names = [name.lstrip("-") for name in known]
    return [f"--{it}" for it in difflib.get_close_matches(option.lstrip("-"), names, 1, _ALIKE)]


def _module_of(name: str) -> ModuleType:
    """Import the module of a command. Those of the laboratory are known here by name alone."""
    wing = "lab" if name in _OF_LAB else "fronts"
    return importlib.import_module(f"heatlens.{wing}.commands.{name}")


def _commands_with(option: str) -> list[str]:
    """Return the commands that have an option, which another one was given."""
    found = []
    for name in _COMMANDS:
        own = argparse.ArgumentParser(add_help=False)
        _module_of(name).add_options(own)
        found += [name] if option in own._option_string_actions else []
    return found


def count_movie_frames(args: argparse.Namespace) -> None:
    """Count the frames of a movie that is named in `args` from --first-frame."""
    first = getattr(args, "first_frame", None)
    for name in ("plate", "shot"):
        text = getattr(args, name, None)
        movie = None if text is None else movie_named(Path(text))
        if text is not None and movie is not None and first is not None and first >= 0:
            setattr(args, name, type(text)(f"{movie[0]}@{first}"))
            args.first_frame = None
