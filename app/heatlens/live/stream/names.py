"""Give an image that a client sends a path, as plates have, although it has no file."""

from pathlib import Path

_NAME_LETTERS = 100  # longest path of a plate: file systems allow 255 bytes


def plate_path(name: str) -> Path:
    """Return a path for the image `name`, at which there is no file.

    A client chooses the name, so the path must not lead out of a folder.
    """
    plain = "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in name)
    return Path(plain[-_NAME_LETTERS:].strip(". ") or "tev")
