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
from heatlens.core.base.faults import to_heatlens_error
from heatlens.core.base.log import LOG, log_end, start_log
from heatlens.core.base.outside_text import printable
from heatlens.core.base.stopping import record_stop_reported
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.command_table import COMMANDS, put_command_first
from heatlens.fronts.commands.output.say import set_quiet


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`; returns the exit code."""
    try:
        words = put_command_first(sys.argv[1:] if argv is None else argv)
        args = _parse_words(words)
        set_quiet(getattr(args, "quiet", False))
        start_log(getattr(args, "verbose", False))
        _prepare(args)
        code = int(args.run(args))
        sys.stdout.flush()  # a closed pipe is noticed here, not when Python ends
        log_end(code)
        return code
    except HeatlensError as error:
        return _report_error(error)
    except MemoryError:
        return _report_error(
            InputError("there is not enough memory. A smaller --proxy or fewer --layers need less.")
        )
    except BrokenPipeError:
        _drop_output()
        return 128 + 13  # as the shell counts a program ended by SIGPIPE
    except OSError as error:  # errors of files are handled elsewhere: this is e.g. a full disk
        _drop_output()
        file_name = error.filename or "standard output"
        return _report_error(InputError(f"{file_name}: {error.strerror or error}"))
    except KeyboardInterrupt as stop:
        print("heatlens: stopped", file=sys.stderr, flush=True)
        record_stop_reported()
        return 128 + getattr(stop, "number", signal.SIGINT)
    except Exception as error:
        return _report_error(to_heatlens_error(error, "The command ended"))


def _parse_words(words: Sequence[str]) -> argparse.Namespace:
    """Parse the words. Raises BrokenPipeError if the reader of the output of --help has gone."""
    try:
        return build_parser(_commands_to_import(words[0])).parse_args(words)
    except SystemExit:
        sys.stdout.flush()
        raise


def _commands_to_import(word: str) -> Collection[str]:
    """Return the commands to import: the requested one, or all for a completion script."""
    if word in COMMANDS:
        return (word,)
    return COMMANDS if word == "--print-completion" else ()


def _prepare(args: argparse.Namespace) -> None:
    from heatlens.fronts.commands.options.before_running import prepare  # too slow for --help

    prepare(args)


def _drop_output() -> None:
    """Discard buffered output, which would raise an error again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _report_error(error: HeatlensError) -> int:
    """Print an error in one line, and return the exit code."""
    LOG.error("%s", printable(str(error)))
    print(f"heatlens: {printable(str(error))}", file=sys.stderr)
    return FAULT_CODE if isinstance(error, FaultError) else 2
