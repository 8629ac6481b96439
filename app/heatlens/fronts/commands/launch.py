"""Start the command line of the process that the user started.

On Linux the command runs in a second process (`worker_process`). Elsewhere it runs in this one:
Ctrl-C is handled when a driver or a library returns, and unfinished files are removed at the end.

Exit codes: those of `commands.main`, and 128 + N after signal N: 130 Ctrl-C, 143 SIGTERM.
"""

import atexit
import io
import os
import signal
import sys
import warnings
from typing import NoReturn

from heatlens.core.base import stopping
from heatlens.core.base.own_command import restart_python


def main() -> int:
    """Run the command line of this process; returns the exit code."""
    _use_utf8()
    if sys.platform == "linux":
        from heatlens.fronts.commands.worker_process import run_in_worker

        return run_in_worker(_run_command)
    for stop in stopping.stop_signals():
        signal.signal(stop, signal.default_int_handler)
    record = bytearray()
    stopping.begin_record(record.extend)
    atexit.register(_remove_own_leftovers, record)  # also after a thread that never ends
    return _run_command()


def _remove_own_leftovers(record: bytearray) -> None:
    """Remove what this process has not finished, as no other process waits for its end."""
    stopping.remove_leftovers(stopping.read_record(bytes(record)))


def _use_utf8() -> None:
    """Restart Python with UTF-8 file names if it uses others; libraries offer no other way.

    Text is still printed in the terminal's encoding, with the characters that it lacks escaped.
    """
    if sys.getfilesystemencoding() != "utf-8":
        terminal = f"terminal={sys.stdout.encoding}" if sys.stdout else "terminal"
        restart_python("-X", "utf8", "-X", terminal)
    encoding = sys._xoptions.get("terminal")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            encoding = encoding if isinstance(encoding, str) else None
            stream.reconfigure(encoding=encoding, errors="backslashreplace")


def _run_command() -> int:
    """Run the command in this process; return its exit code."""
    from heatlens.core.base.faults import report_from_threads
    from heatlens.core.base.memory import share_one_heap

    share_one_heap()
    from heatlens.fronts.commands.main import main as run
    from heatlens.media.files.quiet import protect_output

    protect_output()
    report_from_threads()
    if not sys.warnoptions:  # warnings show lines of source code, which do not help users
        warnings.simplefilter("ignore")

    code = run()  # --version and --help end here, before what only threads need is loaded
    from heatlens.core.base.background import has_busy_threads, wait_for_busy_threads

    if has_busy_threads():
        atexit.unregister(wait_for_busy_threads)
        _end_now(code)
    return code


def _end_now(code: int) -> NoReturn:
    """End the process even if a thread still waits for a disk that does not answer.

    Python would keep that thread running during shutdown, and abort the process if the thread is
    inside a C++ library at that moment.
    """
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    os._exit(code)
