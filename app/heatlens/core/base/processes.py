"""Tell whether another process of this machine is alive."""

import os
import sys
from contextlib import suppress
from pathlib import Path


def is_running(process: int) -> bool:
    """Return whether there is a process with this number, of any user, that has not ended."""
    if sys.platform == "win32":  # signal 0 would end the process there
        from heatlens.core.base import windows_calls

        return windows_calls.is_running(process)
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # alive, and owned by another user
        return True
    return not _has_ended(process)


def _has_ended(process: int) -> bool:
    """Return whether the process is a zombie: it has ended, but its parent has not waited."""
    with suppress(OSError, IndexError):
        status = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
        return status.rpartition(")")[2].split()[0] in ("Z", "X")
    return False
