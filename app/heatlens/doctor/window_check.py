"""Check what the window needs besides OpenGL: its libraries, fonts and a display."""

import subprocess
import sys
from collections.abc import Iterator

from heatlens.base.errors import GpuError
from heatlens.doctor.finding import Finding

_PATIENCE_S = 60.0
_INSTALL = "pip install 'heatlens[gui]', on Debian or Ubuntu also: apt-get install libgl1 libegl1"


def fonts() -> Iterator[Finding]:
    """Look for the fonts that come with the library of the window."""
    try:
        from heatlens.ui.window_try import fonts_found
    except ImportError as error:
        yield Finding("fonts", "note", f"no window ({error}). {_INSTALL}")
        return
    yield Finding("fonts", "ok", fonts_found())


def display() -> Iterator[Finding]:
    """Open an invisible window, and close it again."""
    try:
        from heatlens.ui import window_try
    except ImportError as error:
        yield Finding("display", "note", f"no window ({error}). {_INSTALL}")
        return
    named = window_try.display_named()
    if named is None:
        yield Finding("display", "note", "none here; `heatlens render` works without")
        return
    details = {"display": named, "renderer": _renderer_of_a_window(window_try.__name__)}
    yield Finding("display", "ok", f"{named}, drawn by {details['renderer']}", details)


def _renderer_of_a_window(module: str) -> str:
    """Return the OpenGL renderer of a window in a separate process. Raises GpuError if that fails.

    X kills a process on errors, and with Mesa no window can draw on a thread that also has a
    context without a window.
    """
    # -P: a file in the current folder that has the name of a Python module must not be run.
    command = [sys.executable, "-P", "-m", module]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE_S)
    except subprocess.TimeoutExpired:
        raise GpuError(f"No window opened within {_PATIENCE_S:g} s.") from None
    if run.returncode:
        said = " ".join(run.stderr.split()) or f"exit code {run.returncode}"
        raise GpuError(f"No window can be opened: {said}")
    return run.stdout.strip()
