"""Read the focus point, f-stop and depth map of a phone's portrait photo.

The metadata holds the point of focus, and the f-stop that the phone simulated for the portrait.
Sources: the regions of the Metadata Working Group (mwg-rs, in XMP); SubjectArea of EXIF 2.32; the
entry SimulatedAperture that Apple writes in the XMP of the depth. libheif does not pass on this
entry, so it is searched for in the bytes of the file.

The depth map inside is Google's in JPEG, Apple's in HEIC. Sources: "Depthmap Metadata" (GDepth, in
XMP), "Dynamic Depth" 1.0 (a map after the picture), and the depth representation of HEVC (ISO/IEC
23008-2, annex G) as libheif passes it on.
"""

import base64
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import read_file_bytes
from heatlens.core.model.depth_words import DepthConvention
from heatlens.media.files.opened_by_ending import open_embedded_picture
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.plate.header.entries import FOCUS_POINT
from heatlens.media.plate.plate import FloatImage, Plate

_XMP = b"http://ns.adobe.com/xap/1.0/\0"
_EXTENSION = b"http://ns.adobe.com/xmp/extension/\0"
_EXTENSION_HEAD = 32 + 4 + 4  # bytes: digest of the whole, its length, offset of this piece
# Entries of GDepth and of Dynamic Depth, as attributes or as elements.
_ENTRY = r'(?:GDepth|DepthMap):{name}(?:="([^"]*)"|>([^<]*)<)'
_ITEM_LENGTH = re.compile(r'Item:Length(?:="(\d{1,12})"|>(\d{1,12})<)')
_UNIFORM_INVERSE_Z, _UNIFORM_DISPARITY = 0, 1  # depth_representation_type
_EVEN_OVER_INVERSE_Z = (_UNIFORM_INVERSE_Z, _UNIFORM_DISPARITY)


@dataclass(frozen=True, eq=False)
class InnerDepth:
    """The depth map (H, W) of a photo, with the convention of its values.

    why         one sentence on how the convention is known
    full_scale  white of integer values, None for floating point
    notes       sentences for the user
    """

    values: FloatImage
    convention: DepthConvention
    why: str
    full_scale: float | None = None
    notes: tuple[str, ...] = ()


def read_inner_depth(path: Path, info: dict[str, Any]) -> InnerDepth | None:
    """Return the depth map inside the picture at `path`, or None if it has none.

    `info` is the metadata of the picture. Raises InputError if the map is damaged.
    """
    if info.get("depth_images"):
        return _convert_heic_depth(*info["depth_images"][0])
    xmp = _join_xmp(info.get("segments", ()))
    if not xmp or ("GDepth:" not in xmp and "DepthMap:" not in xmp):
        return None
    return _convert_google_depth(path, xmp)


def _convert_google_depth(path: Path, xmp: str) -> InnerDepth | None:
    """Return the map converted to distances in meters, between the ends given in the XMP.

    Returns None if the picture holds no map. Raises InputError for impossible ends.
    """
    near_m, far_m = _entry_number(xmp, "Near"), _entry_number(xmp, "Far")
    encoded = _find_google_map(path, xmp)
    if encoded is None:
        return None
    if near_m is None or far_m is None or not 0 < near_m < far_m:
        raise InputError(
            f"{path}: its depth map runs from {near_m} to {far_m} m, which cannot be. Give another "
            "depth with --depth."
        )
    fraction = _decode_grey(path, encoded)
    format_name = _entry_text(xmp, "Format") or "RangeInverse"
    if format_name == "RangeLinear":
        depth = near_m + fraction * (far_m - near_m)
    else:
        depth = near_m * far_m / (far_m - fraction * (far_m - near_m))
    why = f"The photo holds it, as {format_name} from {near_m:g} to {far_m:g} m."
    return InnerDepth(values=depth.astype(np.float32), convention=DepthConvention.DISTANCE, why=why)


def _find_google_map(path: Path, xmp: str) -> bytes | None:
    """Return the encoded map from the XMP or appended to the picture; None if there is none."""
    data = _entry_text(xmp, "Data")
    if data:
        with _convert_map_errors(path):
            return base64.b64decode("".join(data.split()) + "==")
    lengths = [int(a or b) for a, b in _ITEM_LENGTH.findall(xmp)]
    appended = _appended_files(path, [length for length in lengths if length])
    return next((item for item in appended if _is_grey_picture(item)), None)


def _appended_files(path: Path, lengths: list[int]) -> Iterator[bytes]:
    """Yield the files that are appended to the picture, with the given lengths in order."""
    data = read_file_bytes(path)
    start = len(data) - sum(lengths)
    if start < 0:  # the first length is that of the picture itself
        start, lengths = len(data) - sum(lengths[1:]), lengths[1:]
    for length in lengths:
        yield data[max(start, 0) : start + length]
        start += length


def _is_grey_picture(data: bytes) -> bool:
    """Return True if the bytes are a picture with one channel."""
    try:
        return open_embedded_picture(data).mode in ("L", "I;16", "I", "F")
    except Exception:  # for damaged bytes, Pillow can raise anything
        return False


def _decode_grey(path: Path, data: bytes) -> FloatImage:
    """Decode a picture to values of 0 to 1."""
    with _convert_map_errors(path):
        image = open_embedded_picture(data)
        values = np.asarray(image if image.mode in ("L", "I;16") else image.convert("L"))
    fraction: FloatImage = values.astype(np.float32) / np.float32(np.iinfo(values.dtype).max)
    return fraction


@contextmanager
def _convert_map_errors(path: Path) -> Iterator[None]:
    """Turn every way in which decoding fails into an InputError."""
    try:
        yield
    except Exception as error:
        message = f"{path}: its depth map is damaged. Give another depth with --depth."
        raise InputError(message) from error


def _convert_heic_depth(
    stored_values: NDArray[np.generic], metadata: dict[str, object]
) -> InnerDepth:
    """Return the disparity that Apple writes, or dioptres if the file gives its ends."""
    values = stored_values.astype(np.float32)
    values = values[:, :, 0] if values.ndim == 3 else values
    full_scale = 255.0 if values.max(initial=0) <= 255 else 65535.0
    low, high = _ends_in_dioptres(metadata)
    if low is not None and high is not None and 0 <= low < high:
        dioptres = (low + values / full_scale * (high - low)).astype(np.float32)
        why = f"The photo holds it, as disparity from {low:g} to {high:g} dioptres."
        return InnerDepth(values=dioptres, convention=DepthConvention.INVERSE, why=why)
    why = "The photo holds it, as disparity, white near."
    return InnerDepth(values, DepthConvention.DISPARITY, why, full_scale)


def _ends_in_dioptres(metadata: dict[str, Any]) -> tuple[float | None, float | None]:
    """Return the dioptres (1/z) of black and of white; None for an end that the file lacks.

    Phones give disparity in 1/m.
    """
    if metadata.get("representation_type", _UNIFORM_INVERSE_Z) not in _EVEN_OVER_INVERSE_Z:
        return None, None
    near_m, far_m = metadata.get("z_near"), metadata.get("z_far")
    if near_m and far_m:
        return 1 / far_m, 1 / near_m
    return metadata.get("d_min"), metadata.get("d_max")


def _join_xmp(segments: Any) -> str:
    """Return the XMP of a JPEG, joined with the pieces of its extension."""
    main_xmp, pieces = b"", {}
    for name, data in segments:
        if name != "APP1":
            continue
        if data.startswith(_XMP):
            main_xmp += data[len(_XMP) :]
        elif data.startswith(_EXTENSION):
            header_end = len(_EXTENSION) + _EXTENSION_HEAD
            offset = int.from_bytes(data[header_end - 4 : header_end], "big")
            pieces[offset] = data[header_end:]
    joined_xmp = main_xmp + b"".join(pieces[offset] for offset in sorted(pieces))
    return joined_xmp.decode("utf-8", "replace")


def _entry_text(xmp: str, name: str) -> str | None:
    """Return the text of a depth entry in the XMP; None if there is none."""
    match = re.search(_ENTRY.format(name=name), xmp)
    return None if match is None else (match[1] or match[2])


def _entry_number(xmp: str, name: str) -> float | None:
    """Return the number in a depth entry of the XMP; None if there is none."""
    text = _entry_text(xmp, name)
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


_SUBJECT_AREA, _ORIENTATION = 0x9214, 0x0112
_REGION = re.compile(r"<rdf:li\b")
_IS_FOCUS = re.compile(r'mwg-rs:Type(?:="|>)Focus["<]')
_F_STOP = re.compile(rb'SimulatedAperture(?:="|>)\s*([\d.]{1,12})')
_F_STOP_RANGE = 0.5, 64.0
_SIDEWAYS_ORIENTATIONS = 5, 6, 7, 8
_F_STOP_SUFFIXES = (".heic", ".heif")


def portrait_header(
    path: Path, size: tuple[int, int], info: Mapping[str, Any]
) -> dict[str, object]:
    """Return header entries with the focus point and the f-stop that a photo's metadata has.

    `size` and `info` are those of the picture as Pillow opens it: HEIC is upright already, JPEG is
    not. `info` is that of `RawPicture`.
    """
    entries: dict[str, object] = {}
    tags, xmp = info["exif_tags"], info.get("xmp", b"")
    text = xmp.decode("utf-8", "replace") if isinstance(xmp, bytes) else ""
    original_orientation = info.get("original_orientation")
    stored_size = size[::-1] if original_orientation in _SIDEWAYS_ORIENTATIONS else size
    point = _focus_region_center(text) or _subject_center(tags, stored_size)
    if point is not None:
        orientation = original_orientation or tags.get(_ORIENTATION, 1)
        entries[FOCUS_POINT] = _rotate_point(point, orientation)
    has_f_stop = path.suffix.lower() in _F_STOP_SUFFIXES
    match = _F_STOP.search(read_file_bytes(path)) if has_f_stop else None
    f_stop = _parse_float(match[1]) if match else None
    if f_stop is not None and _F_STOP_RANGE[0] <= f_stop <= _F_STOP_RANGE[1]:
        entries["aperture"] = f_stop
    return entries


def apply_photo_focus(plate: Plate, header: Mapping[str, Any]) -> Plate:
    """Return the plate with its focus on the surface at the photo's focus point, if it has one."""
    point, window = header.get(FOCUS_POINT), plate.display_window
    if point is None or not plate.has_distances or plate.camera.focus_distance_m is not None:
        return plate
    x, y = (
        min(int(p * n), n - 1) for p, n in zip(point, (window.width, window.height), strict=True)
    )
    focus_m = depth_at_m(plate, x, y)
    if not np.isfinite(focus_m):
        return plate
    sources = {**plate.camera.sources, "focus_distance_m": f"focus of the photo, pixel {x},{y}"}
    camera = replace(plate.camera, focus_distance_m=focus_m, sources=sources)
    return replace(plate, camera=camera)


def _focus_region_center(xmp: str) -> tuple[float, float] | None:
    """Return the middle (x, y) of the first region of focus, 0 to 1; None if there is none."""
    regions = (region for region in _REGION.split(xmp) if _IS_FOCUS.search(region))
    region = next(regions, "")
    matches = (re.search(rf'stArea:{axis}(?:="|>)\s*([\d.]{{1,12}})', region) for axis in "xy")
    return _point_if_inside(
        *(None if match is None else _parse_float(match[1].encode()) for match in matches)
    )


def _subject_center(tags: Mapping[int, Any], size: tuple[int, int]) -> tuple[float, float] | None:
    """Return the middle (x, y) of the subject's area, 0 to 1; None if there is none.

    The area is a point, a circle or a rectangle.
    """
    area = tags.get(_SUBJECT_AREA)
    if not isinstance(area, tuple) or not 2 <= len(area) <= 4:
        return None
    if not all(isinstance(number, int) for number in area):
        return None
    return _point_if_inside(area[0] / size[0], area[1] / size[1])


def _point_if_inside(x: float | None, y: float | None) -> tuple[float, float] | None:
    """Return the point if both coordinates are known and in 0 to 1, else None."""
    if x is None or y is None or not (0 <= x <= 1 and 0 <= y <= 1):
        return None
    return x, y


def _rotate_point(point: tuple[float, float], orientation: object) -> tuple[float, float]:
    """Return a point (x, y), 0 to 1, of the stored picture as a point of the upright picture.

    `orientation` is the number in EXIF.
    """
    x, y = point
    rotated_points = {2: (1 - x, y), 3: (1 - x, 1 - y), 4: (x, 1 - y), 5: (y, x), 6: (1 - y, x)}
    rotated_points |= {7: (1 - y, 1 - x), 8: (y, 1 - x)}
    return rotated_points.get(orientation, point) if isinstance(orientation, int) else point


def _parse_float(text: bytes) -> float | None:
    """Return the number that a text holds; None if it holds none."""
    try:
        return float(text)
    except ValueError:
        return None
