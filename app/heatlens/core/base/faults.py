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

_REPORTS_MOST = 20  # reports kept in the folder; older ones are deleted
_LIBRARIES = ("numpy", "moderngl", "OpenEXR", "pillow", "imgui-bundle", "usd-core", "av", "trimesh")
_MESSAGE_LETTERS_MOST = 200  # letters of an exception's message that the sentence repeats

_lock = threading.Lock()
_reports_by_location: dict[
    str, Path | None
] = {}  # reports by the location of the fault, so that a repeated one is written once


@contextmanager
def report_faults(failure: str = "This could not be done") -> Iterator[None]:
    """Raise only HeatlensErrors from the block; `failure` begins the sentence of a fault.

    This is also a decorator. Errors of memory and of the system become InputErrors; any other
    exception is written to a report and becomes a FaultError.
    """
    try:
        yield
    except Exception as error:
        known_error = to_heatlens_error(error, failure)
        if known_error is error:
            raise
        raise known_error from error


def to_heatlens_error(error: Exception, failure: str = "This could not be done") -> HeatlensError:
    """Return the HeatlensError for `error`; write a report if it is a fault of heatlens."""
    if isinstance(error, HeatlensError):
        return error
    if isinstance(error, MemoryError):
        return InputError(
            f"{failure}: there is not enough memory. A smaller picture or fewer layers need less."
        )
    if isinstance(error, OSError) and error.strerror:
        location = f"{os.fsdecode(error.filename)}: " if error.filename else f"{failure}: "
        return InputError(f"{location}{error.strerror}.")
    error_text = " ".join(f"{type(error).__name__}: {error}".split())[
        :_MESSAGE_LETTERS_MOST
    ].rstrip(": ")
    path = write_report(error)
    location = f"The report is in {path}" if path else "No report could be written"
    return FaultError(f"{failure}; this is a fault of heatlens ({error_text}). {location}.")


def write_report(error: BaseException) -> Path | None:
    """Write the full report of `error` and return its file; None if no folder is writable."""
    text = _format_report(error)
    if os.environ.get("HEATLENS_DEBUG", "0") not in ("", "0") and sys.stderr is not None:
        sys.stderr.write(text)
    location = _error_location(error)
    with _lock:
        if location not in _reports_by_location:
            _reports_by_location[location] = _save_report(text)
        return _reports_by_location[location]


def report_from_threads() -> None:
    """Write a report and say a sentence when a thread fails; Python would print a traceback."""
    threading.excepthook = _report_thread_failure


def _report_thread_failure(args: threading.ExceptHookArgs) -> None:
    """Print one sentence about the exception that ended a thread; see `threading.excepthook`."""
    if not isinstance(args.exc_value, Exception):
        return
    known_error = to_heatlens_error(args.exc_value, "A part of the program stopped")
    if sys.stderr is not None:  # None in a program without a terminal
        sys.stderr.write(f"heatlens: {printable(str(known_error))}\n")


def _save_report(text: str) -> Path | None:
    """Write a new file in the folder of reports, or else in that for temporary files."""
    # Imported here because `--version` would import twice as much. A running command has loaded
    # both modules, so that this succeeds also when no more files can be opened.
    import tempfile

    from heatlens.core.base.paths import reports_dir

    for folder in (reports_dir(), Path(tempfile.gettempdir())):
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            prefix = time.strftime("fault-%Y%m%d-%H%M%S-")
            descriptor, name = tempfile.mkstemp(".log", prefix, folder)
            with open(descriptor, "w", encoding="utf-8") as file:
                file.write(text)
            _remove_old_reports(folder)
            return Path(name)
    return None


def _remove_old_reports(folder: Path) -> None:
    """Remove the oldest reports; the names sort by their time."""
    for path in sorted(folder.glob("fault-*.log"))[:-_REPORTS_MOST]:
        path.unlink(missing_ok=True)


def _format_report(error: BaseException) -> str:
    """Return the text of a report: versions, the command and the traceback of `error`."""
    import platform

    versions = (f"{name} {_version(name)}" for name in _LIBRARIES)
    text = "".join(traceback.format_exception(error))
    header = (
        f"heatlens {__version__}, {time.strftime('%Y-%m-%d %H:%M:%S')}",
        f"Python {platform.python_version()} on {platform.platform()}",
        ", ".join(versions),
        f"Command: {sys.argv!r}",
    )
    return printable("\n".join((*header, "", text)), keep="\n\t")


def _version(name: str) -> str:
    """Return the installed version of a package, or "is not installed"."""
    from importlib.metadata import PackageNotFoundError, version  # slow, and only faults need it

    try:
        return version(name)
    except PackageNotFoundError:
        return "is not installed"


def _error_location(error: BaseException) -> str:
    """Return the type of an error, and the file and line where it was raised, as text."""
    frames = traceback.extract_tb(error.__traceback__)
    return f"{type(error).__name__} {[(f.filename, f.lineno) for f in frames[-1:]]}"
