"""The command `heatlens`: run the subcommand and turn errors into exit codes.

Exit codes: 0 success, 1 `compare`, `doctor` or `info` found what it looks for, 2 an error that the
user can fix, 70 a fault of heatlens, whose report is in a file, 130 stopped with Ctrl-C, 141 the
reader of the output has gone (`| head`).

Only the module of the requested command is imported. `commands.launch` calls this in a separate
process, which it ends when Ctrl-C is pressed.
"""

import argparse
import importlib
import os
import signal
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from heatlens.base.errors import FAULT_CODE, FaultError, HeatlensError, InputError
from heatlens.base.faults import told_error
from heatlens.base.printable import printable
from heatlens.base.stopping import stop_was_said
from heatlens.commands.output.say import say_nothing
from heatlens.commands.words import is_name_elsewhere, meant, with_command
from heatlens.model.other_names import or_meant
from heatlens.version import __version__

_EPILOG = """\
examples:
  heatlens plate.exr                        # the window; alone: with a start screen
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

_OPTIONS_LISTED = 16  # in the usage; with more of them it says [options]
_COMMANDS = (
    *("view", "render", "export", "shot", "camera", "info", "compare", "study", "bench"),
    *("kits", "doctor"),
)


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

    def format_help(self) -> str:
        """Return the help; a usage of many options would fill the first screen, so is cut short."""
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
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown and self.prog.endswith(" view") and parsed.plate in _COMMANDS:
            right = " ".join((parsed.plate, *unknown))
            self.error(f"options come after the command, as in: heatlens {right} --f-stop 2")
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, self)}")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse a value that is not among the choices, and suggest the closest one."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += or_meant(str(value), map(str, action.choices or ()))
            raise

    def _get_option_tuples(self, option_string: str) -> list[Any]:
        """Return the options that begin like this, except where other programs mean another one."""
        return [] if is_name_elsewhere(option_string) else super()._get_option_tuples(option_string)


class _Completion(argparse.Action):
    """Prints the script and ends, as --help does."""

    def __call__(self, parser: argparse.ArgumentParser, *given: Any) -> None:
        """Print the completion; `given` are the namespace, the shell and the option."""
        import shtab

        print(shtab.complete(parser, shell=given[1]))
        parser.exit()


def build_parser(names: Sequence[str] = _COMMANDS) -> argparse.ArgumentParser:
    """Build the command line of the commands `names`; the default is all of them."""
    parser = _Parser(
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
        help="print the script with which this shell completes commands and options",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in names:
        importlib.import_module(f"heatlens.commands.{name}").register(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`; returns the exit code."""
    try:
        words = _with_command(sys.argv[1:] if argv is None else argv)
        args = build_parser(_needed(words)).parse_args(words)
        say_nothing(getattr(args, "quiet", False))
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
