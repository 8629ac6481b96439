"""Open pictures and movies with the reader of their ending, and with no other.

Pillow, OpenImageIO and FFmpeg choose a reader by the content of a file. So a file called plate.png
could be PostScript, which Pillow hands to Ghostscript to run, or a playlist, with which FFmpeg
opens other files. Here the ending decides, and every picture and movie is opened here
(`tests/media/files/test_opened_by_ending.py`).
"""

import warnings
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from PIL import Image, UnidentifiedImageError

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import opened_file
from heatlens.media.files.marks import picture_marks
from heatlens.media.files.picture_formats import FORMATS, format_of

if TYPE_CHECKING:
    from av.container import InputContainer
    from OpenImageIO import ImageInput

INSIDE = ("PNG", "JPEG", "WEBP")  # pictures inside other files: maps, materials, stills
# The first bytes of files of no such format -> what they are, and the ending for heatlens.
_OTHERS = {
    b"\x76\x2f\x31\x01": ("OpenEXR", ".exr"),
    b"%!PS": ("PostScript", ""),
    b"%PDF": ("PDF", ""),
    b"GIF8": ("GIF", ""),
}
_DEMUXERS = {".mxf": "mxf", ".webm": "matroska", ".mkv": "matroska"}  # of others it is mov
_PLACES_READ = {"protocol_whitelist": "file"}  # no reference in a movie opens anything else


def picture_at(path: Path) -> Image.Image | None:
    """Open a picture without decoding it; None for a kind that Pillow lacks, such as float TIFF.

    Raises InputError for a file whose content is of another kind than its ending tells, and
    whatever Pillow raises for a damaged one.
    """
    kind = format_of(path)
    try:
        return Image.open(path, formats=() if kind is None else kind.of_pillow)
    except UnidentifiedImageError:
        check_content(path)
        return None


def picture_of(data: bytes, formats: tuple[str, ...] = INSIDE) -> Image.Image:
    """Open a picture that lies inside another file; raises what Pillow does."""
    return Image.open(BytesIO(data), formats=formats)


def marks_by_pillow(path: Path) -> dict[str, str]:
    """Return the marks of heatlens in a picture; raises ValueError or what Pillow does."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Pillow warns of files that were cut off
        image = picture_at(path)
        if image is None:
            raise ValueError(f"{path} is not a picture of an export")
        with image:
            info = {str(name): value for name, value in image.info.items()}
            return picture_marks(info, image.getexif())


def ending_of(head: bytes) -> str:
    """Return the ending for a file that begins with these bytes; "" if heatlens reads none such."""
    return _content(head)[1]


def check_content(path: Path) -> None:
    """Raise InputError for a file that begins as one of another kind than its ending tells."""
    with opened_file(path) as file:
        kind, ending = _content(file.read(16))
    own = format_of(path)
    if kind and (own is None or own is not format_of(f"a{ending}")):
        help_ = f"rename it to {path.with_suffix(ending).name}" if ending else "convert it"
        raise InputError(f"{path} is {kind}, although its name ends in {path.suffix}: {help_}.")


def _content(head: bytes) -> tuple[str, str]:
    """Return what begins with these bytes and the ending for it; "" where there is none."""
    known = (it for it in FORMATS if head.startswith(it.begins))
    others = (other for begins, other in _OTHERS.items() if head.startswith(begins))
    return next(((it.word, it.suffixes[0]) for it in known), next(others, ("", "")))


def input_by_openimageio(library: ModuleType, path: Path) -> "ImageInput | None":
    """Return an open picture of OpenImageIO by the ending; None if it cannot be opened."""
    library.attribute("try_all_readers", 0)
    opened: ImageInput | None = library.ImageInput.open(str(path))
    return opened


# A playlist in the place of a movie made FFmpeg open what it names, and wait for a pipe. With the
# demuxer named, and files as the only protocol, there is nothing to follow.
def movie_for_reading(library: ModuleType, path: Path) -> "InputContainer":
    """Open a movie with PyAV, by the demuxer of its ending; raises FFmpegError."""
    kind = _DEMUXERS.get(path.suffix.lower(), "mov")
    opened: InputContainer = library.open(f"file:{path}", format=kind, options=_PLACES_READ)
    return opened
