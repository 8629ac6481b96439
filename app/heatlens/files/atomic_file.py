"""Files appear whole or not at all: written beside the target, then renamed over it."""

import os
import platform
import re
import secrets
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from heatlens.errors import InputError
from heatlens.stopping import unfinished


def _machine() -> str:
    """Return eight digits for this machine; on Linux, containers number their own processes."""
    where = platform.node()
    with suppress(OSError):
        where += os.readlink("/proc/self/ns/pid")
    return f"{zlib.crc32(where.encode()):08x}"


_MACHINE = _machine()  # folders are shared, and everybody counts processes from 1
_PART = re.compile(r"\.heatlens-[0-9a-f]{16}\.([0-9a-f]{8})\.([0-9]+)\.part")
_FORGOTTEN_S = 24 * 60 * 60.0  # nobody writes one file for so long without a change to it
_FOR_ALL, FOR_THE_USER = 0o666, 0o600
_NEW_FILE = os.O_CREAT | os.O_EXCL | os.O_RDWR
_NEW_FILE |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


def write_whole(path: str | os.PathLike[str], data: bytes, mode: int = _FOR_ALL) -> None:
    """Write `data` to `path`, or leave what stood there as it was.

    `mode` is who may read and write it, less what the user's own mask takes away. Raises InputError
    where nothing can be written there, or not all of it arrives on the disk.
    """
    with replacing(path, mode) as beside, open(beside, "wb", buffering=0) as file:
        left = memoryview(data)
        while left:  # a disk that fills up may take a part and say so only at the next write
            left = left[file.write(left) :]
        os.fsync(file.fileno())
        arrived = os.fstat(file.fileno()).st_size
        if arrived != len(data):
            raise OSError(f"only {arrived:,} of {len(data):,} bytes are on the disk")


@contextmanager
def replacing(path: str | os.PathLike[str], mode: int = _FOR_ALL) -> Iterator[Path]:
    """Yield a path to write to; it replaces `path` when the block ends without an error.

    The old file stays until then, and after an error. A link keeps its target. The file to write to
    exists already, empty, under a short name that nobody can foresee; `write_whole` is for those
    who have all bytes at hand. Raises InputError where nothing can be written there.
    """
    target = Path(os.path.realpath(path))
    _check_target(target)
    beside = target.with_name(f".heatlens-{secrets.token_hex(8)}.{_MACHINE}.{os.getpid()}.part")
    try:
        with unfinished(beside):
            os.close(os.open(beside, _NEW_FILE, mode))
            yield beside
            _to_disk(beside)
            os.replace(beside, target)
    except (OSError, RuntimeError) as error:  # RuntimeError is what OpenEXR raises
        told = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        # The name that is written to for now means nothing to anybody.
        why = told.replace(str(beside), str(target)).rstrip(".")
        raise InputError(f"{target} could not be written: {why}.") from error
    finally:
        with suppress(OSError):  # a disk that refuses this, too, has refused something before
            beside.unlink(missing_ok=True)


def remove_leftovers(folder: Path) -> None:
    """Delete what killed processes left in a folder while they wrote files there.

    What a process of this machine that is alive writes stays, and of another machine what has
    changed within a day. What cannot be deleted stays too: it is in nobody's way.
    """
    with suppress(OSError):
        for name in os.listdir(folder):
            match = _PART.fullmatch(name)
            if match and _is_dead(folder / name, match[1], int(match[2])):
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
    """Return whether only the entry of a process is left, because nobody has waited for it yet."""
    with suppress(OSError, IndexError):
        status = Path(f"/proc/{process}/stat").read_text()
        return status.rpartition(")")[2].split()[0] in ("Z", "X")
    return False


def _to_disk(path: Path) -> None:
    """Flush the file to the disk: a power cut could leave the new name without its content.

    Empty files are skipped.
    """
    with open(path, "rb+") as file:
        os.fsync(file.fileno())
        if not os.fstat(file.fileno()).st_size:
            raise OSError("no bytes arrived on the disk")


def _check_target(target: Path) -> None:
    """Refuse what a rename would fail on, or destroy: folders and devices."""
    if not os.path.isdir(target.parent):
        raise InputError(f"{target} cannot be written: the folder {target.parent} does not exist.")
    if os.path.exists(target) and not os.path.isfile(target):
        raise InputError(
            f"{target} cannot be written: it is a folder or a device, not a file. "
            "Give the name of a file."
        )
