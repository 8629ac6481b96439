"""Treat numbered files as a sequence only if their pictures have the same size.

hero.0720.exr and hero.1080.exr may be two sizes of the same picture. The names alone cannot decide,
so the headers of a few neighbours are read, in about a tenth of a millisecond each.
"""

import os
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.files.picture_formats import is_picture
from heatlens.plate.parts.header_read import read_headers
from heatlens.plate.picture.picture_open import picture_info
from heatlens.sequence.sequence import Sequence, find_sequence

Size = tuple[int, int]


def sequence_of_one_size(text: str) -> Sequence:
    """Find the sequence for `text`; a file whose neighbours have another size stands alone.

    A pattern or a folder means all of its files. Raises InputError as `find_sequence` does.
    """
    found = find_sequence(text)
    path = Path(os.path.expanduser(text))
    if found.is_single or found.folder == path or not os.path.isfile(path):
        return found
    named = found.frame_at(path)
    own = _size_of(path)
    others = (_size_of(found.path_at(frame)) for frame in _neighbours(found, named))
    if own is None or all(size in (None, own) for size in others):
        return found
    return find_sequence(text, whole=False)


def _neighbours(sequence: Sequence, frame: int | None) -> set[int]:
    """Return the first and last present frame, and the present ones next to `frame`."""
    present = sequence.present
    at = present.index(frame) if frame in present else 0
    return {
        present[0],
        present[-1],
        present[max(at - 1, 0)],
        present[min(at + 1, len(present) - 1)],
    }


def _size_of(path: Path) -> Size | None:
    """Return width and height of the display window; None if the header cannot be read."""
    try:
        if is_picture(path):
            return picture_info(path)[0]
        (x0, y0), (x1, y1) = read_headers(path)[0]["displayWindow"]
    except (InputError, KeyError):  # reported when the file is opened
        return None
    return int(x1 - x0) + 1, int(y1 - y0) + 1
