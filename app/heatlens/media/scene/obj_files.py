"""Find the files of materials and pictures that an OBJ names, without reading its triangles.

Like trimesh, this follows the first `mtllib`, and each `map_Kd` in that file.
"""

import mmap
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from heatlens.core.base.paths import open_regular_file, read_file_bytes, unreadable_error


class FolderFiles:
    """Reads the files in the folder of a scene's file for trimesh.

    `missing` lists the names for which no file was found.
    """

    def __init__(self, path: Path) -> None:
        self.folder, self.missing = path.parent.resolve(), list[str]()

    def path(self, name: str) -> Path:
        """Return the path for a name, whether the file exists or not.

        Raises OSError for a name that leads out of the folder.
        """
        try:
            path = (self.folder / name.strip().replace("\\", "/")).resolve()
        except (
            RuntimeError,
            ValueError,
        ) as error:  # a loop of links, or a zero byte within the name
            raise FileNotFoundError(name) from error
        if not path.is_relative_to(self.folder):
            raise FileNotFoundError(name)
        return path

    def get(self, name: str) -> bytes:
        """Return the bytes of a file; raise OSError where it is missing or outside the folder."""
        try:
            return read_file_bytes(self.path(name))
        except OSError as error:
            self.missing.append(name.strip()[:80])
            raise FileNotFoundError(name) from error

    __getitem__ = get


_LIBRARY, _PICTURE = b"mtllib", "map_kd"


def files_of_obj(path: Path) -> tuple[Path, ...]:
    """Return the files of materials and pictures in order, whether they exist or not.

    Files outside the folder of the OBJ are left out, because they are never read. Raises InputError
    if the OBJ cannot be opened.
    """
    folder_files = FolderFiles(path)
    files: dict[Path, None] = {}
    name = _find_library(path)
    if name is None:
        return ()
    with suppress(OSError):
        library = folder_files.path(name)
        files[library] = None
        for picture in _find_pictures(library):
            with suppress(OSError):
                files[folder_files.path(picture)] = None
    return tuple(files)


def _find_library(path: Path) -> str | None:
    """Return the name after the first `mtllib`, or None; a backslash continues a line."""
    try:
        with open_regular_file(path) as file:
            if not path.stat().st_size:
                return None
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                position = data.find(_LIBRARY)
                if position < 0:
                    return None
                data.seek(position + len(_LIBRARY))
                return _decode_text(b"".join(_continued_line(data)))
    except OSError as error:
        raise unreadable_error(path, error) from error


def _continued_line(data: mmap.mmap) -> Iterator[bytes]:
    """Yield the rest of a line and the lines that continue it."""
    while line := data.readline():
        line = line.rstrip(b"\r\n")
        yield line.removesuffix(b"\\")
        if not line.endswith(b"\\"):
            return


def _find_pictures(library: Path) -> Iterator[str]:
    """Yield the names after each `map_Kd`; raise OSError if the file cannot be read."""
    for line in _decode_text(read_file_bytes(library)).splitlines():
        if len(words := line.split()) > 1 and words[0].lower() == _PICTURE:
            yield line[line.lower().index(_PICTURE) + len(_PICTURE) :]


def _decode_text(data: bytes) -> str:
    """Decode UTF-8, or else Latin-1, which older programs write."""
    try:
        return data.decode("utf-8").strip()
    except UnicodeDecodeError:
        return data.decode("latin-1").strip()
