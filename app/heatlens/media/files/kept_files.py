"""Files of the cache folder that are deleted when they were not used for longest.

A folder of such files never grows beyond a limit. What cannot be written is not kept.
"""

import os
from contextlib import suppress
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import read_file_bytes
from heatlens.media.files.atomic_file import FOR_THE_USER, write_atomically


def read_kept_file(path: Path) -> bytes | None:
    """Return the content of a file, which now counts as just used, or None if there is none."""
    try:
        content = read_file_bytes(path)
    except OSError:
        return None
    with suppress(OSError):  # a folder that can only be read
        os.utime(path)
    return content


def keep_file(path: Path, content: bytes, most_bytes: int) -> None:
    """Write a file, after others of its folder are deleted until all have at most `most_bytes`."""
    with suppress(OSError, InputError):  # a full or read-only disk
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        _delete_oldest(path.parent, most_bytes - len(content))
        write_atomically(path, content, FOR_THE_USER)


def _delete_oldest(folder: Path, most_bytes: int) -> None:
    """Delete the files that were not used for longest until at most `most_bytes` are left."""
    statuses = [(file.stat(), file) for file in folder.iterdir() if file.is_file()]
    total = sum(status.st_size for status, _ in statuses)
    for status, file in sorted(statuses, key=lambda it: it[0].st_mtime_ns):
        if total <= most_bytes:
            return
        file.unlink(missing_ok=True)
        total -= status.st_size
