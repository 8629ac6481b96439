"""Write files completely or not at all: beside the target, then renamed over it.

Before the work begins it is checked whether an output can be written. A file that several processes
of this user read, change and write is locked.
"""

import os
import platform
import re
import secrets
import shutil
import tempfile
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.stopping import folder_made, unfinished

try:
    import fcntl
except ImportError:  # no such module on Windows; two windows at once may then lose a change
    fcntl = None  # type: ignore[assignment]

_PART = re.compile(r"\.heatlens-[0-9a-f]{16}\.([0-9a-f]{8})\.([0-9]+)\.part")
_FORGOTTEN_S = 24 * 60 * 60.0  # a file that is being written changes more often than this
_FOR_ALL, FOR_THE_USER = 0o666, 0o600
_NEW_FILE = os.O_CREAT | os.O_EXCL | os.O_RDWR
_PATIENCE_S = 2.0  # a process that stopped in the middle must not block the others forever


def _machine() -> str:
    """Return eight digits that identify this machine or, on Linux, this container."""
    where = platform.node()
    with suppress(OSError):
        where += os.readlink("/proc/self/ns/pid")
    return f"{zlib.crc32(where.encode()):08x}"


_MACHINE = _machine()  # folders may be shared between machines, which reuse process numbers
_NEW_FILE |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


def write_whole(
    path: str | os.PathLike[str], data: bytes, mode: int = _FOR_ALL, follows_links: bool = True
) -> None:
    """Write `data` to `path`, or leave an existing file there unchanged.

    `mode` holds the permission bits of a new file, before the user's umask. Raises InputError if
    the file cannot be written completely.
    """
    with replacing(path, mode, follows_links) as beside, open(beside, "wb", buffering=0) as file:
        left = memoryview(data)
        while left:  # a full disk may accept a part, and fail only at the next write
            left = left[file.write(left) :]
        os.fsync(file.fileno())
        arrived = os.fstat(file.fileno()).st_size
        if arrived != len(data):
            raise OSError(f"only {arrived:,} of {len(data):,} bytes are on the disk")


# A rename within a folder is the only step that other programs see, and it cannot be half done;
# across disks it would be a copy, so the unfinished file lies beside its target. Its name tells
# machine and process, so that whoever finds it later can know that its writer is dead.
@contextmanager
def replacing(
    path: str | os.PathLike[str], mode: int = _FOR_ALL, follows_links: bool = True
) -> Iterator[Path]:
    """Yield a path to write to; it replaces `path` when the block ends without an error.

    The old file stays until then, and after an error. The target of a link is replaced, or, where
    others may put links, without `follows_links`, the link itself. The yielded path is an empty
    file with a short random name. Use `write_whole` if all bytes are in memory. Raises InputError
    if the file cannot be written.
    """
    target = Path(os.path.realpath(path) if follows_links else path)
    _check_target(target)
    beside = target.with_name(f".heatlens-{secrets.token_hex(8)}.{_MACHINE}.{os.getpid()}.part")
    try:
        with unfinished(beside):
            os.close(os.open(beside, _NEW_FILE, mode))
            yield beside
            _to_disk(beside)
            os.replace(beside, target)
    except (OSError, RuntimeError) as error:  # RuntimeError is what OpenEXR raises
        words = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        # The temporary name would mean nothing to the user.
        why = words.replace(str(beside), str(target)).rstrip(".")
        raise InputError(f"{target} could not be written: {why}.") from error
    finally:
        with suppress(OSError):  # if this fails, an earlier step has failed and was reported
            beside.unlink(missing_ok=True)


def remove_leftovers(folder: Path) -> None:
    """Delete unfinished files that killed processes left in a folder.

    Files of living processes on this machine stay, and files of other machines that have changed
    within a day. Files that cannot be deleted stay too: they do no harm.
    """
    with suppress(OSError):
        for name in os.listdir(folder):
            match = _PART.fullmatch(name)
            if match and _is_dead(folder / name, match[1], int(match[2])):
                (folder / name).unlink(missing_ok=True)


def _is_dead(part: Path, machine: str, process: int) -> bool:
    if machine != _MACHINE or os.name == "nt":  # on Windows, signal 0 would end the process
        return time.time() - part.stat().st_mtime > _FORGOTTEN_S
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:  # alive, and owned by another user
        return False
    return _has_ended(process)


def _has_ended(process: int) -> bool:
    """Return whether the process is a zombie: it has ended, but its parent has not waited."""
    with suppress(OSError, IndexError):
        status = Path(f"/proc/{process}/stat").read_text()
        return status.rpartition(")")[2].split()[0] in ("Z", "X")
    return False


def _to_disk(path: Path) -> None:
    """Flush the file to the disk, so that a power cut cannot leave the new name without content.

    Raises OSError if the file is empty.
    """
    with open(path, "rb+") as file:
        os.fsync(file.fileno())
        if not os.fstat(file.fileno()).st_size:
            raise OSError("no bytes were written to the disk")


def _check_target(target: Path) -> None:
    """Refuse folders and devices, on which a rename would fail or which it would destroy."""
    if not os.path.isdir(target.parent):
        raise InputError(f"{target} cannot be written: the folder {target.parent} does not exist.")
    if os.path.exists(target) and not os.path.isfile(target):
        raise InputError(
            f"{target} cannot be written: it is a folder or a device, not a file. "
            "Give the name of a file."
        )


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Wait, but not for long, until no other process is in such a block for the same `path`.

    The file system of a server may have no locks; the block is then entered at once. Raises OSError
    if the file `path`, which stays empty, cannot be made.
    """
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    opened = os.open(path, flags, 0o600)
    try:
        end = time.monotonic() + _PATIENCE_S
        while not _is_taken(opened) and time.monotonic() < end:
            time.sleep(0.02)
        yield
    finally:
        os.close(opened)  # this releases the lock


def _is_taken(opened: int) -> bool:
    """Return False while another process has the lock."""
    try:
        if fcntl is not None:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def check_folder(path: Path) -> None:
    """Raise InputError if the folder of `path` is missing, and the folder around it as well.

    `make_folder` makes one folder, but not several: a longer path that is missing is more often
    misspelt than new.
    """
    folder = path.parent
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{path}: there is no folder {folder}; that is a file.")
    if not folder.is_dir() and not folder.absolute().parent.is_dir():
        raise InputError(
            f"{path}: there is no folder {folder.parent}. heatlens makes one missing folder, "
            "not several."
        )


def make_folder(folder: Path, parents: bool = False) -> None:
    """Create the folder if it is missing, inside an existing one, or with its `parents`.

    Raises InputError.

    If the command is stopped, the folder is removed again unless it holds something.
    """
    try:
        if not folder.is_dir():
            folder_made(folder)
        folder.mkdir(exist_ok=True, parents=parents)
    except OSError as error:
        raise InputError(
            f"The folder {folder} cannot be made: {error.strerror or error}."
        ) from error


# A study worked for minutes before it found that nothing can be written in /proc, whose rights say
# otherwise. Making a file is the only proof.
def check_writable(path: Path, around: Path | None = None) -> None:
    """Raise InputError if no file can be created in the folder of `path`, or in `around` it.

    The folder must exist.
    """
    folder = around or path.parent
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: {folder} is not writable. Choose another folder.")
    try:
        # The rights of a folder do not tell everything: nobody can make a file in /proc.
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{path}: no file can be made in {folder} ({error.strerror or error}). Choose another "
            "folder."
        ) from error


def check_place(path: Path) -> None:
    """Raise InputError if nothing can be written where `path`, or its first missing folder, lies.

    It is for the beginning of a command; which missing folders it makes is its own decision.
    """
    folder = Path(os.path.realpath(path)).parent
    while not os.path.lexists(folder):
        folder = folder.parent
    if folder.is_dir():
        check_writable(path, folder)


def check_space(folder: Path, need_bytes: float, what: str) -> None:
    """Raise InputError if the disk of `folder` has less free space than `what` will need.

    A folder that will be made lies on the disk of the one around it. Nothing is refused if the free
    space is unknown, or if there is no disk.
    """
    try:
        disk = shutil.disk_usage(folder if folder.is_dir() else folder.parent)
    except OSError:
        return
    if disk.total and need_bytes > disk.free:
        raise InputError(
            f"{folder}: {what} will need about {_size(need_bytes)}, and {_size(disk.free)} are "
            "free on that disk. Free some, or choose another folder."
        )


def _size(count: float) -> str:
    for unit, name in ((1e9, "GB"), (1e6, "MB")):
        if count >= unit:
            return f"{count / unit:.1f} {name}"
    return f"{count / 1e3:.1f} kB"
