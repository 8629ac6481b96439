"""Find the files that a scene names; only files in its folder or below it are read."""

from pathlib import Path

from heatlens.base.paths import file_bytes


class FilesBeside:
    """Reads the files beside a scene's file for trimesh.

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
            return file_bytes(self.path(name))
        except OSError as error:
            self.missing.append(name.strip()[:80])
            raise FileNotFoundError(name) from error

    __getitem__ = get
