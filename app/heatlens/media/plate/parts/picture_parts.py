"""Present photos and other pictures as parts of a file, in the form in which EXR files are read.

Color becomes scene-linear and premultiplied. Facts about the camera and the primaries are put
into the header under their EXR names; facts about a depth, under `PICTURE_FACTS`.
"""

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageCms

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthSide
from heatlens.core.model.shot.plate_options import PictureCurve
from heatlens.media.files.marks import picture_marks
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.header.channels import Header, Part
from heatlens.media.plate.header.entries import FOR_THE_EYE, PICTURE_FACTS, PictureFacts
from heatlens.media.plate.header.primaries import P3_D65
from heatlens.media.plate.picture.display import decode_camera_log, decode_srgb
from heatlens.media.plate.picture.picture_open import RawPicture, open_picture, picture_info
from heatlens.media.plate.picture.portrait import read_inner_depth
from heatlens.media.plate.plate import FloatImage
from heatlens.media.plate.windows import make_header_window, resize_nearest

_FULL_FRAME_MM = (36.0, 24.0)
_EXIF_FOCAL_35MM = 0xA405
# Channels of a gray picture may differ by this part of the range: JPEG adds a little color.
_COLORED_SHARE = 0.02
_SOLID_PX = 5  # a codec colors thin lines and dots at edges; a square of this side is a color
_SEAM_PX = 16  # next to the other half, a codec mixes the colors of both in its blocks
_SIDES_OF_SECOND_HALF = (DepthSide.RIGHT, DepthSide.BOTTOM)  # the depth is the second half

Kind = Literal["color", "depth"]


def color_parts(path: Path, curve: PictureCurve, side: DepthSide = DepthSide.NONE) -> list[Part]:
    """Read R, G, B and A of a picture as linear light, and Z if the picture holds a depth.

    If `side` is given, that half of the picture is the depth. Raises InputError if the picture
    cannot be halved.
    """
    raw = open_picture(path)
    depth = None
    if side is not DepthSide.NONE:
        raw, depth = _split_halves(path, raw, side)
    straight, notes = _convert_to_linear(path, raw, curve)
    if straight.shape[2] in (2, 4):
        straight[:, :, :-1] *= straight[:, :, -1:]
    names = {1: "Y", 2: "YA", 3: "RGB", 4: "RGBA"}[straight.shape[2]]
    channels = {name: np.ascontiguousarray(straight[:, :, i]) for i, name in enumerate(names)}
    if depth is not None:
        channels["Z"] = depth
        return [_make_part(channels, raw, PictureFacts(notes, raw.full_scale), curve)]
    depth_map = read_inner_depth(path, raw.info)
    if depth_map is None:
        return [_make_part(channels, raw, PictureFacts(notes), curve)]
    upright = _rotate_upright(depth_map.values, straight, raw)
    channels["Z"] = resize_nearest(upright, straight.shape[:2])
    notes = (*notes, *depth_map.notes)
    facts = PictureFacts(notes, depth_map.full_scale, depth_map.convention, depth_map.why)
    return [_make_part(channels, raw, facts, curve)]


def depth_parts(path: Path) -> list[Part]:
    """Read a depth picture as Z, with the values that are stored in the file.

    Raises InputError for a colored picture, because the colors of a color map have no order.
    """
    raw = open_picture(path)
    return [_make_part({"Z": _read_grey(path, raw)}, raw, PictureFacts(full_scale=raw.full_scale))]


def _read_grey(
    path: Path, raw: RawPicture, checked_area: tuple[slice, slice] | None = None
) -> FloatImage:
    """Return the values (H, W) of a gray picture; raise InputError for a colored one.

    Only the rows and columns of `checked_area` must be gray; None checks the whole picture.
    """
    values = raw.values[:, :, : 3 if raw.values.shape[2] >= 3 else 1].astype(np.float32)
    spread = values.max(axis=2) - values.min(axis=2)
    largest_spread = _COLORED_SHARE * (raw.full_scale or max(float(np.ptp(values)), 1e-30))
    if _has_solid_square((spread > largest_spread)[checked_area or np.s_[:, :]]):
        raise InputError(
            f"{path} is coloured, so it is not a depth, or a depth shown with a colour map: export "
            "it in grey, best with 16 bits."
        )
    return np.ascontiguousarray(values[:, :, 0])


def _has_solid_square(mask: NDArray[np.bool_]) -> bool:
    """Return True if all pixels of some square of _SOLID_PX in the mask are set.

    In a smaller picture the square is as wide or as high as the picture.
    """
    for axis in (0, 1):
        side = min(_SOLID_PX, mask.shape[axis])
        count = mask.shape[axis] - side + 1
        shifted = (mask.take(range(offset, offset + count), axis) for offset in range(side))
        mask = np.logical_and.reduce(list(shifted))
    return bool(mask.any())


def _split_halves(path: Path, raw: RawPicture, side: DepthSide) -> tuple[RawPicture, FloatImage]:
    """Return the picture without the half at `side`, and the depth in that half."""
    height, width = raw.values.shape[:2]
    half = _half_size((width, height), side)
    if (2 * half[0], height) != (width, height) and (width, 2 * half[1]) != (width, height):
        size = f"{width} x {height} pixels"
        raise InputError(f"{path} is {size}, which cannot be halved: leave --depth-side out.")
    first = replace(raw, values=raw.values[: half[1], : half[0]])
    second = replace(raw, values=raw.values[-half[1] :, -half[0] :])
    color, depth = (first, second) if side in _SIDES_OF_SECOND_HALF else (second, first)
    return color, _read_grey(path, depth, _area_beyond_seam(half, side))


def _area_beyond_seam(size: tuple[int, int], side: DepthSide) -> tuple[slice, slice]:
    """Return the rows and columns of the half at `side` that are not next to the other half."""
    is_horizontal = side in (DepthSide.LEFT, DepthSide.RIGHT)
    length = size[0] if is_horizontal else size[1]
    seam_px = min(_SEAM_PX, length // 4)
    is_second = side in _SIDES_OF_SECOND_HALF
    kept_span = slice(seam_px, None) if is_second else slice(0, length - seam_px)
    return (slice(None), kept_span) if is_horizontal else (kept_span, slice(None))


def _half_size(size: tuple[int, int], side: DepthSide) -> tuple[int, int]:
    """Return (width, height) without the half at `side`."""
    horizontal_divisor = 2 if side in (DepthSide.LEFT, DepthSide.RIGHT) else 1
    vertical_divisor = 2 if side in (DepthSide.TOP, DepthSide.BOTTOM) else 1
    return size[0] // horizontal_divisor, size[1] // vertical_divisor


def picture_header(
    path: Path, curve: PictureCurve = PictureCurve.AUTO, side: DepthSide = DepthSide.NONE
) -> Header:
    """Read the header that `color_parts` would give, without the pixels."""
    size, info = picture_info(path)
    size = _half_size(size, side)
    is_for_eye = not info.get("is_light") and curve.color_space is None
    header = _make_header((), size, info, PictureFacts()) | _display_mark(is_for_eye)
    return _drop_chromaticities(header) if curve.color_space is not None else header


def _drop_chromaticities(header: Header) -> Header:
    """Return the header without primaries, for light that was converted to Rec.709."""
    return {name: value for name, value in header.items() if name != "chromaticities"}


def _display_mark(is_display_referred: bool) -> Header:
    """Return the header entry that marks a display-referred picture; {} for other pictures."""
    return {FOR_THE_EYE: 1} if is_display_referred else {}


def _make_part(
    channels: dict[str, FloatImage],
    raw: RawPicture,
    facts: PictureFacts,
    curve: PictureCurve = PictureCurve.AUTO,
) -> Part:
    """Return the channels with a header, as a part of an EXR file is read."""
    height, width = raw.values.shape[:2]
    header = _make_header(tuple(channels), (width, height), raw.info, facts)
    if curve.color_space is not None:
        return _drop_chromaticities(header), dict(channels)
    is_for_eye = raw.full_scale is not None and not raw.info.get("is_light")
    return header | _display_mark(is_for_eye), dict(channels)


def _make_header(
    channels: tuple[str, ...], size: tuple[int, int], info: dict[str, Any], facts: PictureFacts
) -> Header:
    """Return a header in the form of EXR for a picture of this size (width, height)."""
    window = make_header_window(Box(0, 0, *size))
    header: Header = {
        "channels": [SimpleNamespace(name=c, xSampling=1, ySampling=1) for c in channels],
        "compression": "NO_COMPRESSION",
        "dataWindow": window,
        "displayWindow": window,
        PICTURE_FACTS: facts,
    }
    if "display p3" in _profile_name(info).lower():
        header["chromaticities"] = P3_D65.chromaticities
    header |= _camera_entries(info)
    header |= picture_marks(info, info.get("exif_tags", {}))
    header |= info.get("header", {})
    return header


def _camera_entries(info: dict[str, Any]) -> dict[str, object]:
    """Return header entries with the 35 mm equivalent focal length from EXIF, on full frame.

    The f-stop is left out, because on a larger sensor the same f-stop gives more blur.
    """
    tags = info.get("exif_tags", {})
    try:
        focal_mm = float(tags.get(_EXIF_FOCAL_35MM, 0))
    except (TypeError, ValueError, ZeroDivisionError):
        return {}
    if not 1 <= focal_mm <= 2000:
        return {}
    lens = lens_attributes(focal_mm, 1.0, 1.0, *_FULL_FRAME_MM)
    return {name: lens[name] for name in ("pinholeFocalLength", "sensorOverallDimensions")}


def _convert_to_linear(
    path: Path, raw: RawPicture, curve: PictureCurve
) -> tuple[FloatImage, tuple[str, ...]]:
    """Return linear light (H, W, C) with unchanged alpha, and notes on how it was decided."""
    values, profile_notes = _convert_primaries(path, raw)
    if raw.full_scale is not None:
        values = values.astype(np.float32) / np.float32(raw.full_scale)
    values = values.astype(np.float32)
    if curve.color_space is not None:
        return decode_camera_log(path, values, curve.color_space), profile_notes
    is_srgb = _is_srgb(curve, raw)
    colors = values.shape[2] - (values.shape[2] in (2, 4))
    own_curve = raw.info.get("curve") if curve is PictureCurve.AUTO else None
    decode = own_curve or (decode_srgb if is_srgb else None)
    if decode is not None:
        values[:, :, :colors] = decode(values[:, :, :colors])
    if "note" in raw.info:
        profile_notes = (*profile_notes, raw.info["note"])
    if curve is not PictureCurve.AUTO:
        return values, profile_notes
    if own_curve is not None:
        return values, (f"{path}: {raw.info['curve_words']}.", *profile_notes)
    bits = raw.info.get("bits", raw.values.dtype.itemsize * 8)
    note = (
        f"{path}: {bits} bits, taken as sRGB and converted to linear light; "
        "--picture-curve linear takes them as light."
        if is_srgb
        else f"{path}: floating point, taken as scene-linear light; --picture-curve srgb converts "
        "it from sRGB."
    )
    return values, (note, *profile_notes)


def _is_srgb(curve: PictureCurve, raw: RawPicture) -> bool:
    """Return whether the values are sRGB; with AUTO, integers are and floats are not."""
    match curve:
        case PictureCurve.AUTO:
            return raw.full_scale is not None
        case PictureCurve.SRGB:
            return True
        case PictureCurve.LINEAR:
            return False
        case _:
            return False  # the log of a camera, which is decoded elsewhere


def _convert_primaries(path: Path, raw: RawPicture) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Return values in the primaries of sRGB or P3; other profiles are converted to sRGB."""
    name = _profile_name(raw.info)
    lower = name.lower()
    if not name or "srgb" in lower or raw.values.shape[2] < 3:
        return raw.values, ()
    if "display p3" in lower:
        return raw.values, (f"{path}: its profile is {name}, whose primaries are used.",)
    if raw.values.dtype != np.uint8:
        return raw.values, (f"{path}: its profile {name} is not used; taken as sRGB.",)
    colors = Image.fromarray(np.ascontiguousarray(raw.values[:, :, :3]))
    try:
        profile = ImageCms.ImageCmsProfile(BytesIO(raw.info["icc_profile"]))
        converted = ImageCms.profileToProfile(colors, profile, ImageCms.createProfile("sRGB"))
    except (ImageCms.PyCMSError, OSError):
        return raw.values, (f"{path}: its profile {name} cannot be used; taken as sRGB.",)
    values = raw.values.copy()
    values[:, :, :3] = np.asarray(converted)
    return values, (f"{path}: converted from its profile {name} to sRGB.",)


def _profile_name(info: dict[str, Any]) -> str:
    """Return the name of the color profile; "" if there is none or it cannot be read."""
    data = info.get("icc_profile")
    if not data:
        return ""
    try:
        return ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(BytesIO(data))).strip()
    except (ImageCms.PyCMSError, OSError):
        return ""


def _rotate_upright(depth: FloatImage, color: FloatImage, raw: RawPicture) -> FloatImage:
    """Rotate the depth by the orientation of the color in EXIF, unless it is upright already."""
    orientation = raw.info.get("exif_tags", {}).get(0x0112, 1)
    is_tall, color_is_tall = (shape[0] > shape[1] for shape in (depth.shape, color.shape))
    # The transpositions of Pillow by the orientations of EXIF.
    methods = {2: 0, 3: 3, 4: 1, 5: 5, 6: 4, 7: 6, 8: 2}
    if orientation not in methods or (orientation >= 5 and is_tall == color_is_tall):
        return depth  # it is stored upright already
    rotated = Image.fromarray(depth).transpose(Image.Transpose(methods[orientation]))
    return np.asarray(rotated, np.float32)
