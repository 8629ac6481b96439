"""Read pictures of more than 8 bits a channel, and of rare kinds, with OpenImageIO."""

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import extra, import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.media.files.opened_by_ending import check_content, open_by_openimageio
from heatlens.media.files.quiet import quiet_library
from heatlens.media.plate.exr.exr_scan import MAX_SIDE_PX

if TYPE_CHECKING:
    from OpenImageIO import ImageSpec


_LOG_TRANSFERS = ("Printing density", "Logarithmic")  # transfers in the header of a DPX


def read_by_openimageio(path: Path) -> tuple[NDArray[np.generic], dict[str, object]]:
    """Read values (H, W, C) in the type that the file has, and its metadata. Raises InputError."""
    if importlib.util.find_spec("OpenImageIO") is None:
        raise InputError(
            f"{path} has more than 8 bits a channel, or is of a kind that needs OpenImageIO: "
            f"{extra('pictures').install_command()}."
        )
    library = import_extra("OpenImageIO", str(path))
    with quiet_library():
        return _read_with_library(library, path)


def _read_with_library(
    library: ModuleType, path: Path
) -> tuple[NDArray[np.generic], dict[str, object]]:
    """Read values (H, W, C) and metadata with OpenImageIO, which is imported as `library`."""
    input_file = open_by_openimageio(library, path)
    if input_file is None:
        library.geterror()  # else the library prints it when the program ends
        check_content(path)
        raise InputError(
            f"{path} cannot be read as {path.suffix}: it is damaged, or of a rare kind. Convert it "
            "to a PNG or TIFF of 16 bits, or to EXR."
        )
    spec = input_file.spec()
    check_size(path, (spec.width, spec.height))
    values = input_file.read_image(library.UNKNOWN)
    input_file.close()
    if values is None:
        raise InputError(
            f"{path} is damaged or cut short ({one_line(input_file.geterror())}). Write it again."
        )
    upright = _rotate_upright(
        np.asarray(values)[:, :, :4], spec.get_int_attribute("Orientation", 1)
    )
    return upright, _read_metadata(path, spec, upright.dtype.itemsize * 8)


def _read_metadata(path: Path, spec: "ImageSpec", bits: int) -> dict[str, object]:
    """Return the metadata: comment, bits, and a note on a DPX that is marked as film log.

    The comment that heatlens writes is in the project of a DPX, which OpenImageIO calls
    DocumentName.
    """
    facts: dict[str, object] = {"comment": spec.get_string_attribute("DocumentName")}
    facts["bits"] = spec.get_int_attribute("oiio:BitsPerSample", bits)
    transfer = spec.get_string_attribute("dpx:Transfer")
    if transfer in _LOG_TRANSFERS:
        facts["note"] = (
            f"{path}: its header tells {transfer.lower()}, the log of film; its numbers are taken "
            "as display values."
        )
    return facts


def _rotate_upright(stored_values: NDArray[Any], orientation: int) -> NDArray[np.generic]:
    """Return stored values (H, W, C) turned upright. Source: EXIF 2.32, the tag Orientation."""
    upright = stored_values.swapaxes(0, 1) if orientation in (5, 6, 7, 8) else stored_values
    upright = upright[::-1] if orientation in (3, 4, 7, 8) else upright
    return np.ascontiguousarray(upright[:, ::-1] if orientation in (2, 3, 6, 7) else upright)


def check_size(path: Path, size: tuple[int, int]) -> None:
    """Raise InputError for an empty picture and for one that is too large for a GPU."""
    if not all(0 < side <= MAX_SIDE_PX for side in size):
        raise InputError(
            f"{path} has {size[0]} x {size[1]} pixels; heatlens takes 1 to {MAX_SIDE_PX} a side."
        )
