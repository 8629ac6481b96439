"""Open pictures and movies with the reader of their ending, and with no other.

Pillow, OpenImageIO and FFmpeg choose a reader by the content of a file. So a file called plate.png
could be PostScript, which Pillow hands to Ghostscript to run, or a playlist, with which FFmpeg
opens other files. Here the ending decides, and every picture and movie is opened here
(`tests/files/test_opened_by_ending.py`).
"""

from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from PIL import Image, UnidentifiedImageError

from heatlens.base.errors import InputError
from heatlens.base.paths import opened_file

if TYPE_CHECKING:
    from av.container import InputContainer
    from OpenImageIO import ImageInput

# Pillow's names. It has no other for a JPEG with further pictures behind the first, as of phones.
_OF_PILLOW: dict[str, tuple[str, ...]] = {
    ".avif": ("AVIF",),
    ".bmp": ("BMP", "DIB"),
    ".heic": ("HEIF",),
    ".heif": ("HEIF",),
    ".jpeg": ("JPEG",),
    ".jpg": ("JPEG",),
    ".png": ("PNG",),
    ".tga": ("TGA",),
    ".tif": ("TIFF",),
    ".tiff": ("TIFF",),
    ".webp": ("WEBP",),
}
INSIDE = ("PNG", "JPEG", "WEBP")  # pictures inside other files: maps, materials, stills
# The first bytes of files -> what they are, and the ending with which heatlens reads them.
_BEGINNINGS = {
    b"\x89PNG": ("PNG", ".png"),
    b"\xff\xd8\xff": ("JPEG", ".jpg"),
    b"II*\0": ("TIFF", ".tif"),
    b"MM\0*": ("TIFF", ".tif"),
    b"RIFF": ("WebP", ".webp"),
    b"BM": ("BMP", ".bmp"),
    b"\x76\x2f\x31\x01": ("OpenEXR", ".exr"),
    b"\x93NUMPY": ("NumPy", ".npy"),
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
    formats = _OF_PILLOW.get(path.suffix.lower(), ())
    try:
        return Image.open(path, formats=formats)
    except UnidentifiedImageError:
        check_content(path)
        return None


def picture_of(data: bytes, formats: tuple[str, ...] = INSIDE) -> Image.Image:
    """Open a picture that lies inside another file; raises what Pillow does."""
    return Image.open(BytesIO(data), formats=formats)


def ending_of(head: bytes) -> str:
    """Return the ending for a file that begins with these bytes; "" if heatlens reads none such."""
    return next((it for begins, (_, it) in _BEGINNINGS.items() if head.startswith(begins)), "")


def check_content(path: Path) -> None:
    """Raise InputError for a file that begins as one of another kind than its ending tells."""
    with opened_file(path) as file:
        head = file.read(16)
    for begins, (kind, ending) in _BEGINNINGS.items():
        if head.startswith(begins) and not _is_one(path, ending):
            help_ = f"rename it to {path.with_suffix(ending).name}" if ending else "convert it"
            raise InputError(f"{path} is {kind}, although its name ends in {path.suffix}: {help_}.")


def _is_one(path: Path, ending: str) -> bool:
    own = _OF_PILLOW.get(path.suffix.lower())
    return own is not None and own == _OF_PILLOW.get(ending)


def input_by_openimageio(library: ModuleType, path: Path) -> "ImageInput | None":
    """Return an open picture of OpenImageIO by the ending; None if it cannot be opened."""
    library.attribute("try_all_readers", 0)
    opened: ImageInput | None = library.ImageInput.open(str(path))
    return opened


def movie_for_reading(library: ModuleType, path: Path) -> "InputContainer":
    """Open a movie with PyAV, by the demuxer of its ending; raises FFmpegError."""
    kind = _DEMUXERS.get(path.suffix.lower(), "mov")
    opened: InputContainer = library.open(f"file:{path}", format=kind, options=_PLACES_READ)
    return opened
