"""What an image of a client is called where a plate has the path of its file."""

from pathlib import Path

_NAME_LETTERS = 100  # of a plate's path: file systems take 255 bytes


def plate_path(name: str) -> Path:
    """Return the path that stands for the image `name`; no file is there.

    A client chooses the name, so nothing in it may lead out of a folder.
    """
    plain = "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in name)
    return Path(plain[-_NAME_LETTERS:].strip(". ") or "tev")
