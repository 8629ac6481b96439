"""Read what a phone's portrait photo holds besides its picture: the focus, f-stop and depth map.

A photo tells where it was focused, and the f-stop that a phone simulated for its portrait. Sources:
the regions of the Metadata Working Group (mwg-rs, in XMP); SubjectArea of EXIF 2.32; the entry
SimulatedAperture that Apple writes in the XMP of the depth. libheif does not pass that one on, so
it is looked for in the file.

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
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import file_bytes
from heatlens.core.model.depth_words import DepthConvention
from heatlens.media.files.opened_by_ending import picture_of
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


def inner_depth(path: Path, info: dict[str, Any]) -> InnerDepth | None:
    """Return the depth map inside the picture at `path`, or None if it has none.

    `info` is the metadata of the picture. Raises InputError if the map is damaged.
    """
    if info.get("depth_images"):
        return _of_heic(*info["depth_images"][0])
    xmp = _xmp_of(info.get("segments", ()))
    if not xmp or ("GDepth:" not in xmp and "DepthMap:" not in xmp):
        return None
    return _of_google(path, xmp)


def _of_google(path: Path, xmp: str) -> InnerDepth | None:
    """Convert a map of 0 to 1 to distances in metres, between the ends given in the XMP."""
    near_m, far_m = _number(xmp, "Near"), _number(xmp, "Far")
    encoded = _map_of_google(path, xmp)
    if encoded is None:
        return None
    if near_m is None or far_m is None or not 0 < near_m < far_m:
        raise InputError(f"{path}: its depth map has impossible ends ({near_m}, {far_m}).")
    fraction = _grey(path, encoded)
    form = _text(xmp, "Format") or "RangeInverse"
    if form == "RangeLinear":
        depth = near_m + fraction * (far_m - near_m)
    else:
        depth = near_m * far_m / (far_m - fraction * (far_m - near_m))
    why = f"The photo holds it, as {form} from {near_m:g} to {far_m:g} m."
    return InnerDepth(depth.astype(np.float32), DepthConvention.DISTANCE, why)


def _map_of_google(path: Path, xmp: str) -> bytes | None:
    """Return the encoded map from the XMP or from behind the picture; None if there is none."""
    data = _text(xmp, "Data")
    if data:
        try:
            return base64.b64decode("".join(data.split()) + "==")
        except ValueError as error:  # includes binascii.Error
            raise InputError(f"{path}: its depth map is damaged ({error}).") from error
    lengths = [int(a or b) for a, b in _ITEM_LENGTH.findall(xmp)]
    after = _items_after(path, [length for length in lengths if length])
    return next((item for item in after if _is_grey(item)), None)


def _items_after(path: Path, lengths: list[int]) -> Iterator[bytes]:
    """Yield the files that are appended to the picture, with the given lengths in order."""
    data = file_bytes(path)
    start = len(data) - sum(lengths)
    if start < 0:  # the first length is the picture's own
        start, lengths = len(data) - sum(lengths[1:]), lengths[1:]
    for length in lengths:
        yield data[max(start, 0) : start + length]
        start += length


def _is_grey(data: bytes) -> bool:
    """Return True if the bytes are a picture with one channel."""
    try:
        return picture_of(data).mode in ("L", "I;16", "I", "F")
    except Exception:  # for damaged bytes, Pillow can raise anything
        return False


def _grey(path: Path, data: bytes) -> FloatImage:
    """Decode a picture to values of 0 to 1."""
    with _refusing_damaged_map(path):
        image = picture_of(data)
        values = np.asarray(image if image.mode in ("L", "I;16") else image.convert("L"))
    fraction: FloatImage = values.astype(np.float32) / np.float32(np.iinfo(values.dtype).max)
    return fraction


@contextmanager
def _refusing_damaged_map(path: Path) -> Iterator[None]:
    """Turn every way in which Pillow fails into an InputError."""
    try:
        yield
    except Exception as error:
        raise InputError(f"{path}: its depth map is damaged ({one_line(error)}).") from error


def _of_heic(stored: NDArray[np.generic], metadata: dict[str, object]) -> InnerDepth:
    """Return disparity as Apple writes it, converted to dioptres if its ends are given."""
    values = stored.astype(np.float32)
    values = values[:, :, 0] if values.ndim == 3 else values
    full_scale = 255.0 if values.max(initial=0) <= 255 else 65535.0
    low, high = _ends_in_dioptres(metadata)
    if low is not None and high is not None and 0 <= low < high:
        dioptres = (low + values / full_scale * (high - low)).astype(np.float32)
        why = f"The photo holds it, as disparity from {low:g} to {high:g} dioptres."
        return InnerDepth(dioptres, DepthConvention.INVERSE, why)
    why = "The photo holds it, as disparity, white near."
    return InnerDepth(values, DepthConvention.DISPARITY, why, full_scale)


def _ends_in_dioptres(metadata: dict[str, Any]) -> tuple[float | None, float | None]:
    """Return 1/z of black and of white if the file gives them; phones give disparity in 1/m."""
    if metadata.get("representation_type", _UNIFORM_INVERSE_Z) not in _EVEN_OVER_INVERSE_Z:
        return None, None
    near_m, far_m = metadata.get("z_near"), metadata.get("z_far")
    if near_m and far_m:
        return 1 / far_m, 1 / near_m
    return metadata.get("d_min"), metadata.get("d_max")


def _xmp_of(segments: Any) -> str:
    """Return the XMP of a JPEG, joined with the pieces of its extension."""
    plain, pieces = b"", {}
    for name, data in segments:
        if name != "APP1":
            continue
        if data.startswith(_XMP):
            plain += data[len(_XMP) :]
        elif data.startswith(_EXTENSION):
            head = len(_EXTENSION) + _EXTENSION_HEAD
            offset = int.from_bytes(data[head - 4 : head], "big")
            pieces[offset] = data[head:]
    whole = plain + b"".join(pieces[offset] for offset in sorted(pieces))
    return whole.decode("utf-8", "replace")


def _text(xmp: str, name: str) -> str | None:
    match = re.search(_ENTRY.format(name=name), xmp)
    return None if match is None else (match[1] or match[2])


def _number(xmp: str, name: str) -> float | None:
    text = _text(xmp, name)
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


_SUBJECT_AREA, _ORIENTATION = 0x9214, 0x0112
_REGION = re.compile(r"<rdf:li\b")
_IS_FOCUS = re.compile(r'mwg-rs:Type(?:="|>)Focus["<]')
_F_STOP = re.compile(rb'SimulatedAperture(?:="|>)\s*([\d.]{1,12})')
_F_STOPS = 0.5, 64.0
_SIDEWAYS = 5, 6, 7, 8
_WITH_F_STOP = (".heic", ".heif")


def portrait_header(
    path: Path, size: tuple[int, int], info: Mapping[str, Any]
) -> dict[str, object]:
    """Return header entries of a photo as Pillow opens it; empty if it tells nothing of this.

    `info` is that of `RawPicture`. HEIC has been turned upright already, JPEG has not.
    """
    entries: dict[str, object] = {}
    tags, xmp = info["exif_tags"], info.get("xmp", b"")
    text = xmp.decode("utf-8", "replace") if isinstance(xmp, bytes) else ""
    turned = info.get("original_orientation")
    stored = size[::-1] if turned in _SIDEWAYS else size
    point = _region_of_focus(text) or _subject(tags, stored)
    if point is not None:
        entries[FOCUS_POINT] = _upright(point, turned or tags.get(_ORIENTATION, 1))
    match = _F_STOP.search(file_bytes(path)) if path.suffix.lower() in _WITH_F_STOP else None
    f_stop = _value(match[1]) if match else None
    if f_stop is not None and _F_STOPS[0] <= f_stop <= _F_STOPS[1]:
        entries["aperture"] = f_stop
    return entries


def focused_as_taken(plate: Plate, header: Mapping[str, Any]) -> Plate:
    """Return the plate with its focus at what the photo was focused on, if that is known."""
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


def _region_of_focus(xmp: str) -> tuple[float, float] | None:
    """Return the middle of the first region of focus."""
    regions = (region for region in _REGION.split(xmp) if _IS_FOCUS.search(region))
    region = next(regions, "")
    matches = (re.search(rf'stArea:{axis}(?:="|>)\s*([\d.]{{1,12}})', region) for axis in "xy")
    return _inside(*(None if one is None else _value(one[1].encode()) for one in matches))


def _subject(tags: Mapping[int, Any], size: tuple[int, int]) -> tuple[float, float] | None:
    """Return the middle of the subject's area: a point, a circle or a rectangle around it."""
    area = tags.get(_SUBJECT_AREA)
    if not isinstance(area, tuple) or not 2 <= len(area) <= 4:
        return None
    if not all(isinstance(one, int) for one in area):
        return None
    return _inside(area[0] / size[0], area[1] / size[1])


def _inside(x: float | None, y: float | None) -> tuple[float, float] | None:
    if x is None or y is None or not (0 <= x <= 1 and 0 <= y <= 1):
        return None
    return x, y


def _upright(point: tuple[float, float], turn: object) -> tuple[float, float]:
    """Return the place in the upright picture of a place in the stored one; `turn` as in EXIF."""
    x, y = point
    places = {2: (1 - x, y), 3: (1 - x, 1 - y), 4: (x, 1 - y), 5: (y, x), 6: (1 - y, x)}
    places |= {7: (1 - y, 1 - x), 8: (y, 1 - x)}
    return places.get(turn, point) if isinstance(turn, int) else point


def _value(text: bytes) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
