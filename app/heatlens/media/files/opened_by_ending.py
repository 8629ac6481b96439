"""Open pictures and movies with the reader of their ending, and with no other.

The ending alone decides, and every picture and movie is opened here
(`tests/media/files/test_opened_by_ending.py`). Pillow, OpenImageIO and FFmpeg would choose a reader
by the content of a file: a file called plate.png could be PostScript, which Pillow hands to
Ghostscript to run, or a playlist, with which FFmpeg opens other files.
"""

import warnings
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file
from heatlens.media.files.marks import picture_marks
from heatlens.media.files.picture_formats import FORMATS, format_of

if TYPE_CHECKING:
    from av.container import InputContainer
    from OpenImageIO import ImageInput
    from PIL import Image

EMBEDDED_FORMATS = ("PNG", "JPEG", "WEBP")  # pictures inside other files: maps, materials, stills
# First bytes of files in none of `FORMATS` -> their kind, and the ending that heatlens reads or "".
_OTHER_SIGNATURES = {
    b"\x76\x2f\x31\x01": ("OpenEXR", ".exr"),
    b"%!PS": ("PostScript", ""),
    b"%PDF": ("PDF", ""),
    b"GIF8": ("GIF", ""),
}
_DEMUXERS = {".mxf": "mxf", ".webm": "matroska", ".mkv": "matroska"}  # the others are read by mov
_DEMUXER_OPTIONS = {"protocol_whitelist": "file"}  # no reference in a movie opens anything else


def open_with_pillow(path: Path) -> "Image.Image | None":
    """Open a picture without decoding it; None for a kind that Pillow lacks, such as float TIFF.

    Raises InputError for a file whose content is of another kind than its ending tells, and
    whatever Pillow raises for a damaged one.
    """
    from PIL import Image, UnidentifiedImageError

    kind = format_of(path)
    try:
        return Image.open(path, formats=() if kind is None else kind.of_pillow)
    except UnidentifiedImageError:
        check_content(path)
        return None


def open_embedded_picture(
    data: bytes, formats: tuple[str, ...] = EMBEDDED_FORMATS
) -> "Image.Image":
    """Open a picture that lies inside another file; raises what Pillow does."""
    from PIL import Image

    return Image.open(BytesIO(data), formats=formats)


def marks_by_pillow(path: Path) -> dict[str, str]:
    """Return the marks of heatlens in a picture; raises ValueError or what Pillow does."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Pillow warns of files that were cut off
        image = open_with_pillow(path)
        if image is None:
            raise ValueError(f"{path} is not a picture of an export")
        with image:
            info = {str(name): value for name, value in image.info.items()}
            return picture_marks(info, image.getexif())


def suffix_of_content(head: bytes) -> str:
    """Return the ending for a file that begins with these bytes; "" if heatlens cannot read it."""
    return _identify_content(head)[1]


def check_content(path: Path) -> None:
    """Raise InputError for a file that begins as one of another kind than its ending tells."""
    with open_regular_file(path) as file:
        kind, ending = _identify_content(file.read(16))
    expected_format = format_of(path)
    if kind and (expected_format is None or expected_format is not format_of(f"a{ending}")):
        advice = f"rename it to {path.with_suffix(ending).name}" if ending else "convert it"
        raise InputError(f"{path} is {kind}, although its name ends in {path.suffix}: {advice}.")


def _identify_content(head: bytes) -> tuple[str, str]:
    """Return the kind of file that begins with these bytes, and its ending; "" if unknown."""
    matching_formats = (
        picture_format for picture_format in FORMATS if head.startswith(picture_format.begins)
    )
    other_matches = (
        kind_and_suffix
        for signature, kind_and_suffix in _OTHER_SIGNATURES.items()
        if head.startswith(signature)
    )
    names = ((match.word, match.suffixes[0]) for match in matching_formats)
    return next(names, next(other_matches, ("", "")))


def open_by_openimageio(library: ModuleType, path: Path) -> "ImageInput | None":
    """Return an open picture of OpenImageIO by the ending; None if it cannot be opened."""
    library.attribute("try_all_readers", 0)
    picture: ImageInput | None = library.ImageInput.open(str(path))
    return picture


# The demuxer is named, and files are the only protocol, so that FFmpeg follows no references. A
# playlist in place of a movie made it open the files that it names, and wait for a pipe.
def open_movie(library: ModuleType, path: Path) -> "InputContainer":
    """Open a movie with PyAV, by the demuxer of its ending; raises FFmpegError."""
    demuxer = _DEMUXERS.get(path.suffix.lower(), "mov")
    container: InputContainer = library.open(
        f"file:{path}", format=demuxer, options=_DEMUXER_OPTIONS
    )
    return container
