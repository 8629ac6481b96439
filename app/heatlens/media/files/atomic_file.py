"""Write files completely or not at all: beside the target, then renamed over it.

Other functions check before a long work whether its output can be written.
"""

import os
import platform
import re
import secrets
import shutil
import sys
import tempfile
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.named_paths import path_note
from heatlens.core.base.processes import is_running
from heatlens.core.base.stopping import mark_unfinished, record_new_folder

_UNFINISHED_NAME = re.compile(r"\.heatlens-[0-9a-f]{16}\.([0-9a-f]{8})\.([0-9]+)\.part")
_ABANDONED_AFTER_S = 24 * 60 * 60.0  # a file that is being written changes more often than this
_FOR_ALL, FOR_THE_USER = 0o666, 0o600
_NEW_FILE = os.O_CREAT | os.O_EXCL | os.O_RDWR
_OPEN_WAIT_S = 2.0  # time for another program to close the target


def _machine_digits() -> str:
    """Return eight digits that identify this machine or, on Linux, this container."""
    identity = platform.node()
    with suppress(OSError):
        identity += os.readlink("/proc/self/ns/pid")
    return f"{zlib.crc32(identity.encode()):08x}"


_MACHINE = _machine_digits()  # folders may be shared between machines, which reuse process numbers
_NEW_FILE |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


def write_atomically(
    path: str | os.PathLike[str], data: bytes, mode: int = _FOR_ALL, follows_links: bool = True
) -> None:
    """Write `data` to `path`, or leave an existing file there unchanged.

    `mode` holds the permission bits of a new file, before the user's umask. Raises InputError if
    the file cannot be written completely.
    """
    with (
        replace_atomically(path, mode, follows_links) as temporary_path,
        open(temporary_path, "wb", buffering=0) as file,
    ):
        unwritten = memoryview(data)
        while unwritten:  # a full disk may accept a part, and fail only at the next write
            unwritten = unwritten[file.write(unwritten) :]
        os.fsync(file.fileno())
        file_size = os.fstat(file.fileno()).st_size
        if file_size != len(data):
            raise OSError(f"only {file_size:,} of {len(data):,} bytes are on the disk")


# Other programs see only the final rename within the folder, which cannot be half done. Across
# disks it would be a copy, so the unfinished file lies beside its target. Its name contains machine
# and process, which tells `remove_leftovers` whether its writer still runs.
@contextmanager
def replace_atomically(
    path: str | os.PathLike[str], mode: int = _FOR_ALL, follows_links: bool = True
) -> Iterator[Path]:
    """Yield a path to write to; it replaces `path` when the block ends without an error.

    The old file stays until then, and after an error. If `path` is a link, its target is replaced;
    without `follows_links`, for folders in which others may put links, the link itself. The yielded
    path is an empty file with a short random name. `write_atomically` writes bytes from memory.
    Raises InputError if the file cannot be written.
    """
    target = Path(os.path.realpath(path) if follows_links else path)
    _check_target(target)
    temporary_path = target.with_name(
        f".heatlens-{secrets.token_hex(8)}.{_MACHINE}.{os.getpid()}.part"
    )
    try:
        with mark_unfinished(temporary_path):
            os.close(os.open(temporary_path, _NEW_FILE, mode))
            yield temporary_path
            _flush_to_disk(temporary_path)
            _replace(temporary_path, target)
    except (OSError, RuntimeError) as error:  # RuntimeError is what OpenEXR raises
        error_text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        # The temporary name would mean nothing to the user.
        reason = error_text.replace(str(temporary_path), str(target)).rstrip(".")
        note = path_note(temporary_path)
        raise InputError(f"{target} could not be written: {reason}.{note}") from error
    finally:
        with suppress(OSError):  # if this fails, an earlier step has failed and was reported
            temporary_path.unlink(missing_ok=True)


def _replace(temporary_path: Path, target: Path) -> None:
    """Rename over the target; on Windows, wait while another program has the target open.

    Viewers and virus scanners have files open for moments. Raises OSError.
    """
    deadline = time.monotonic() + _OPEN_WAIT_S
    while True:
        try:
            os.replace(temporary_path, target)
            return
        except PermissionError as error:
            if sys.platform != "win32":
                raise
            if time.monotonic() > deadline:
                raise PermissionError(
                    "another program has it open. Close it there, and write it again"
                ) from error
        time.sleep(0.05)


def remove_leftovers(folder: Path) -> None:
    """Delete unfinished files that killed processes left in a folder.

    Files of living processes on this machine stay, and files of other machines that have changed
    within a day. Files that cannot be deleted stay too: they do no harm.
    """
    with suppress(OSError):
        for name in os.listdir(folder):
            match = _UNFINISHED_NAME.fullmatch(name)
            if match and _is_abandoned(folder / name, match[1], int(match[2])):
                (folder / name).unlink(missing_ok=True)


def _is_abandoned(path: Path, machine: str, process: int) -> bool:
    """Return True if the process that wrote an unfinished file has ended, or probably has."""
    if machine != _MACHINE:
        return time.time() - path.stat().st_mtime > _ABANDONED_AFTER_S
    return not is_running(process)


def _flush_to_disk(path: Path) -> None:
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
        raise InputError(
            f"{target} cannot be written: the folder {target.parent} does not exist."
            f"{path_note(target)}"
        )
    if os.path.exists(target) and not os.path.isfile(target):
        raise InputError(
            f"{target} cannot be written: it is a folder or a device, not a file. "
            "Give the name of a file."
        )


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
            record_new_folder(folder)
        folder.mkdir(exist_ok=True, parents=parents)
    except OSError as error:
        raise InputError(
            f"The folder {folder} cannot be made: {error.strerror or error}."
        ) from error


# The check creates a file, because the rights of a folder prove nothing: those of /proc allow files
# that nobody can create. Without it a study worked for minutes before its output failed there.
def check_writable(path: Path, existing_folder: Path | None = None) -> None:
    """Raise InputError if no file can be created in the folder of `path`, which must exist.

    `existing_folder` is checked instead, if it is given.
    """
    folder = existing_folder or path.parent
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: {folder} is not writable. Choose another folder.")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{path}: no file can be made in {folder} ({error.strerror or error}). Choose another "
            "folder."
        ) from error


def check_output_path(path: Path) -> None:
    """Raise InputError if nothing can be written in the first existing folder above `path`.

    A command calls this at its beginning; it decides itself which missing folders it makes.
    """
    folder = Path(os.path.realpath(path)).parent
    while not os.path.lexists(folder):
        folder = folder.parent
    if folder.is_dir():
        check_writable(path, folder)


def check_space(folder: Path, need_bytes: float, product: str) -> None:
    """Raise InputError if the disk of `folder` has less free space than `product` will need.

    A folder that will be made lies on the disk of the one around it. Nothing is refused if the free
    space is unknown, or if there is no disk.
    """
    try:
        disk = shutil.disk_usage(folder if folder.is_dir() else folder.parent)
    except OSError:
        return
    if disk.total and need_bytes > disk.free:
        raise InputError(
            f"{folder}: {product} will need about {_size_text(need_bytes)}, and "
            f"{_size_text(disk.free)} are "
            "free on that disk. Free some, or choose another folder."
        )


def _size_text(count: float) -> str:
    """Return a number of bytes as text in GB, MB or kB."""
    for unit, name in ((1e9, "GB"), (1e6, "MB")):
        if count >= unit:
            return f"{count / unit:.1f} {name}"
    return f"{count / 1e3:.1f} kB"
