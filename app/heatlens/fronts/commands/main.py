"""The command `heatlens`: run the subcommand and turn errors into exit codes.

Exit codes: 0 success, 1 `compare`, `doctor` or `info` found what it looks for, 2 an error that the
user can fix, 70 a fault of heatlens, whose report is in a file, 130 stopped with Ctrl-C, 141 the
reader of the output has gone (`| head`).

`commands.launch` calls this in a separate process, which it ends when Ctrl-C is pressed.
"""

import argparse
import os
import signal
import sys
from collections.abc import Collection, Sequence

from heatlens.core.base.errors import FAULT_CODE, FaultError, HeatlensError, InputError
from heatlens.core.base.faults import told_error
from heatlens.core.base.outside_text import printable
from heatlens.core.base.stopping import stop_was_said
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.command_table import COMMANDS, with_command
from heatlens.fronts.commands.output.say import say_nothing


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`; returns the exit code."""
    try:
        words = with_command(sys.argv[1:] if argv is None else argv)
        args = _parsed(words)
        say_nothing(getattr(args, "quiet", False))
        _prepare(args)
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
        return build_parser(_needed(words[0])).parse_args(words)
    except SystemExit:
        sys.stdout.flush()
        raise


def _needed(word: str) -> Collection[str]:
    """Return the commands to import: the one that is asked for, or all for a shell's completion."""
    if word in COMMANDS:
        return (word,)
    return COMMANDS if word == "--print-completion" else ()


def _prepare(args: argparse.Namespace) -> None:
    from heatlens.fronts.commands.options.before_running import prepare  # too slow for --help

    prepare(args)


def _drop_output() -> None:
    """Discard buffered output, which would raise an error again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _failed(error: HeatlensError) -> int:
    """Print an error in one line, and return the exit code."""
    print(f"heatlens: {printable(str(error))}", file=sys.stderr)
    return FAULT_CODE if isinstance(error, FaultError) else 2
