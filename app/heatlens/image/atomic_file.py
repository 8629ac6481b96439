"""Files appear whole or not at all: written beside the target, then renamed over it."""

import os
import platform
import re
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from heatlens.errors import InputError
from heatlens.stopping import unfinished


def _machine() -> str:
    """Eight digits for this machine; on Linux, containers in it count their own processes."""
    where = platform.node()
    with suppress(OSError):
        where += os.readlink("/proc/self/ns/pid")
    return f"{zlib.crc32(where.encode()):08x}"


_MACHINE = _machine()  # folders are shared, and everybody counts processes from 1
_PART = re.compile(r"\.(.+)\.([0-9a-f]{8})\.([0-9]+)\.part")
_FORGOTTEN_S = 24 * 60 * 60.0  # nobody writes one file for so long without a change to it


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A path to write to; it takes the place of `path` when the block ends well, else it goes.

    What stood at `path` stays until then. A link keeps pointing where it did.
    Raises InputError where nothing can be written there.
    """
    target = Path(os.path.realpath(path))
    _check_target(target)
    beside = target.with_name(f".{target.name}.{_MACHINE}.{os.getpid()}.part")
    try:
        with unfinished(beside):
            yield beside
            _to_disk(beside)
            os.replace(beside, target)
    except (OSError, RuntimeError) as error:  # RuntimeError is what OpenEXR raises
        told = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        # The name that is written to for now means nothing to anybody.
        why = told.replace(str(beside), str(target)).rstrip(".")
        raise InputError(f"{target} could not be written: {why}.") from error
    finally:
        beside.unlink(missing_ok=True)


def remove_leftovers(folder: Path, is_ours: Callable[[str], bool]) -> None:
    """Delete what killed processes left beside files whose names `is_ours` knows.

    What a process of this machine that is alive writes stays, and of another machine what has
    changed within a day. What cannot be deleted stays too: it is in nobody's way.
    """
    with suppress(OSError):
        for name in os.listdir(folder):
            match = _PART.fullmatch(name)
            if match and is_ours(match[1]) and _is_dead(folder / name, match[2], int(match[3])):
                (folder / name).unlink(missing_ok=True)


def _is_dead(part: Path, machine: str, process: int) -> bool:
    if machine != _MACHINE or os.name == "nt":  # where signal 0 ends the process that is asked
        return time.time() - part.stat().st_mtime > _FORGOTTEN_S
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:  # somebody else's, and alive
        return False
    return _has_ended(process)


def _has_ended(process: int) -> bool:
    """Whether only the name of a process is left: nobody has asked yet how it ended."""
    with suppress(OSError, IndexError):
        status = Path(f"/proc/{process}/stat").read_text()
        return status.rpartition(")")[2].split()[0] in ("Z", "X")
    return False


def _to_disk(path: Path) -> None:
    """Else a power cut can leave the new name without its content."""
    with open(path, "rb+") as file:
        os.fsync(file.fileno())


def _check_target(target: Path) -> None:
    """Refuse what a rename would fail on, or destroy: folders and devices."""
    if not target.parent.is_dir():
        raise InputError(f"{target} cannot be written: the folder {target.parent} does not exist.")
    if target.exists() and not target.is_file():
        raise InputError(
            f"{target} cannot be written: it is a folder or a device, not a file. "
            "Give the name of a file."
        )
