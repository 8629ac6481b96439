"""Convert unexpected exceptions to a sentence for the user, and a full report in a file.

HEATLENS_LOG_DIR names the folder of the reports, and HEATLENS_DEBUG=1 also prints them on stderr. A
report contains no pixels, and nothing of the user's files except their names.
"""

import os
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from heatlens.core.base.errors import FaultError, HeatlensError, InputError
from heatlens.core.base.outside_text import printable
from heatlens.version import __version__

_KEPT = 20  # reports kept in the folder; older ones are deleted
_LIBRARIES = ("numpy", "moderngl", "OpenEXR", "pillow", "imgui-bundle", "usd-core", "av", "trimesh")
_WORDS_MOST = 200  # letters of an exception's message that the sentence repeats

_lock = threading.Lock()
_written: dict[
    str, Path | None
] = {}  # reports by the place of the fault, so that a repeated one is written once


@contextmanager
def faults_reported(what: str = "This could not be done") -> Iterator[None]:
    """Raise only HeatlensErrors from the block; `what` begins the sentence of a fault.

    This is also a decorator. Errors of memory and of the system become InputErrors; any other
    exception is written to a report and becomes a FaultError.
    """
    try:
        yield
    except Exception as error:
        known_error = told_error(error, what)
        if known_error is error:
            raise
        raise known_error from error


def told_error(error: Exception, what: str = "This could not be done") -> HeatlensError:
    """Return the HeatlensError for `error`; write a report if it is a fault of heatlens."""
    if isinstance(error, HeatlensError):
        return error
    if isinstance(error, MemoryError):
        return InputError(
            f"{what}: there is not enough memory. A smaller picture or fewer layers need less."
        )
    if isinstance(error, OSError) and error.strerror:
        where = f"{os.fsdecode(error.filename)}: " if error.filename else f"{what}: "
        return InputError(f"{where}{error.strerror}.")
    words = " ".join(f"{type(error).__name__}: {error}".split())[:_WORDS_MOST].rstrip(": ")
    path = write_report(error)
    where = f"The report is in {path}" if path else "No report could be written"
    return FaultError(f"{what}; this is a fault of heatlens ({words}). {where}.")


def write_report(error: BaseException) -> Path | None:
    """Write the full report of `error` and return its file; None if no folder is writable."""
    text = _report(error)
    if os.environ.get("HEATLENS_DEBUG", "0") not in ("", "0") and sys.stderr is not None:
        sys.stderr.write(text)
    place = _place(error)
    with _lock:
        if place not in _written:
            _written[place] = _in_a_file(text)
        return _written[place]


def report_from_threads() -> None:
    """Write a report and say a sentence when a thread fails; Python would print a traceback."""
    threading.excepthook = _of_thread


def _of_thread(args: threading.ExceptHookArgs) -> None:
    if not isinstance(args.exc_value, Exception):
        return
    known_error = told_error(args.exc_value, "A part of the program stopped")
    if sys.stderr is not None:  # None in a program without a terminal
        sys.stderr.write(f"heatlens: {printable(str(known_error))}\n")


def _in_a_file(text: str) -> Path | None:
    """Write a new file in the folder of reports, or else in that for temporary files."""
    # Else half of what --version imports. A command at work has loaded both, so that this succeeds
    # also when no more files can be opened.
    import tempfile

    from heatlens.core.base.paths import reports_dir

    for folder in (reports_dir(), Path(tempfile.gettempdir())):
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            begin = time.strftime("fault-%Y%m%d-%H%M%S-")
            handle, name = tempfile.mkstemp(".log", begin, folder)
            with open(handle, "w", encoding="utf-8") as file:
                file.write(text)
            _remove_old(folder)
            return Path(name)
    return None


def _remove_old(folder: Path) -> None:
    """Remove the oldest reports; the names sort by their time."""
    for path in sorted(folder.glob("fault-*.log"))[:-_KEPT]:
        path.unlink(missing_ok=True)


def _report(error: BaseException) -> str:
    import platform

    versions = (f"{name} {_version(name)}" for name in _LIBRARIES)
    text = "".join(traceback.format_exception(error))
    head = (
        f"heatlens {__version__}, {time.strftime('%Y-%m-%d %H:%M:%S')}",
        f"Python {platform.python_version()} on {platform.platform()}",
        ", ".join(versions),
        f"Command: {sys.argv!r}",
    )
    return printable("\n".join((*head, "", text)), keep="\n\t")


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version  # slow, and only faults need it

    try:
        return version(name)
    except PackageNotFoundError:
        return "is not installed"


def _place(error: BaseException) -> str:
    """Return the kind of error and where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    return f"{type(error).__name__} {[(f.filename, f.lineno) for f in frames[-1:]]}"
