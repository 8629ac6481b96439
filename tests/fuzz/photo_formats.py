"""Photos and depth maps for the fuzzers: color, depth in its own file, and depth inside a photo."""

import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pillow_heif
from PIL import Image

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from support.picture_files import (
    colors,
    disparity,
    display_p3,
    heic_with_depth,
    jpeg_with_dynamic_depth,
    jpeg_with_gdepth,
    metres,
    save,
    save_16_bits_of_color,
    save_dpx,
)

_SIZE = (12, 18)  # rows and columns: small files are damaged where it counts
_ENDS = {"near_m": 1.0, "far_m": 10.0}
_DEPTHS = disparity(metres(*_SIZE), 1.0, 10.0)
_COLORS = colors(*_SIZE)


def _depth_map(kind: type[np.unsignedinteger]) -> np.ndarray:
    return np.round(_DEPTHS * np.iinfo(kind).max).astype(kind)


def png(folder: Path) -> list[Path]:
    """Write PNGs: color of 8 and 16 bits, alpha, palette, profile; depth of 8 and 16 bits."""
    alpha = np.dstack([_COLORS, _COLORS[..., :1]])
    palette = Image.fromarray(_COLORS).quantize(16)
    palette.save(folder / "palette.png")
    return [
        save(folder / "photo.png", _COLORS),
        save(folder / "alpha.png", alpha, icc_profile=display_p3()),
        save_16_bits_of_color(folder / "fine.png", _COLORS.astype(np.uint16) * 257),
        folder / "palette.png",
        save(folder / "map.png", _depth_map(np.uint16)),
        save(folder / "map-8.png", _depth_map(np.uint8)),
    ]


def with_checksums(data: bytes) -> bytes:
    """Correct the checksums of a damaged PNG, so that readers get past them."""
    sealed, start = bytearray(data), 8
    while start + 12 <= len(sealed):
        end = start + 8 + int.from_bytes(sealed[start : start + 4], "big")
        if end + 4 > len(sealed):
            break
        sealed[end : end + 4] = zlib.crc32(sealed[start + 4 : end]).to_bytes(4, "big")
        start = end + 4
    return bytes(sealed)


def jpeg(folder: Path) -> list[Path]:
    """Write JPEGs: baseline color, progressive color with a rotation, and gray depth."""
    exif = Image.Exif()
    exif[0x0112] = 6  # orientation
    return [
        save(folder / "photo.jpg", _COLORS),
        save(folder / "turned.jpg", _COLORS.swapaxes(0, 1).copy(), exif=exif, progressive=True),
        save(folder / "map.jpg", _depth_map(np.uint8)),
    ]


def tiff(folder: Path) -> list[Path]:
    """Write TIFFs: color of 8, 16 and 32 bits, compressed too; depth of 16 bits and in metres."""
    return [
        save(folder / "photo.tif", _COLORS),
        save(folder / "lzw.tif", _COLORS, compression="tiff_lzw"),
        save(folder / "zip.tif", _COLORS, compression="tiff_adobe_deflate"),
        save_16_bits_of_color(folder / "fine.tif", _COLORS.astype(np.uint16) * 257),
        save_16_bits_of_color(folder / "light.tif", (_COLORS / 255).astype(np.float32)),
        save(folder / "map.tif", _depth_map(np.uint16)),
        save(folder / "map-32.tif", metres(*_SIZE).astype(np.float32)),
    ]


def dpx(folder: Path) -> list[Path]:
    """Write DPX files: color of 8 to 32 bits, also with alpha; gray depth of 10 and 16 bits."""
    paths = []
    for bits in (8, 10, 12, 16):
        paths.append(save_dpx(folder / f"bits-{bits}.dpx", _COLORS / 255, bits))
    alpha = np.dstack([_COLORS, _COLORS[..., :1]]) / 255
    depths = _DEPTHS[..., None]
    return [
        save_dpx(folder / "photo.dpx", _COLORS / 255, 10),
        *paths,
        save_dpx(folder / "light.dpx", _COLORS / 255, 32),
        save_dpx(folder / "alpha.dpx", alpha, 10),
        save_dpx(folder / "map.dpx", depths, 16),
        save_dpx(folder / "map-10.dpx", depths, 10),
    ]


def webp(folder: Path) -> list[Path]:
    """Write WebPs: lossy and lossless color, color with alpha, and gray depth, stored as color."""
    alpha = np.dstack([_COLORS, _COLORS[..., :1]])
    return [
        save(folder / "photo.webp", _COLORS),
        save(folder / "exact.webp", _COLORS, lossless=True),
        save(folder / "alpha.webp", alpha),
        save(folder / "map.webp", _depth_map(np.uint8), lossless=True),
    ]


def with_depth_inside(folder: Path) -> list[Path]:
    """Write JPEGs that contain their depth, in XMP or after the picture."""
    near_m, far_m = _ENDS.values()
    return [
        jpeg_with_gdepth(folder / "gdepth.jpg", near_m, far_m, _DEPTHS),
        jpeg_with_dynamic_depth(folder / "dynamic.jpg", near_m, far_m, _DEPTHS),
    ]


def heic(folder: Path) -> list[Path]:
    """Write HEIC files: color with a depth map beside it, and color with a depth map inside."""
    pillow_heif.register_heif_opener()
    depths = disparity(metres(64, 64), 1, 10)
    save(folder / "map.png", np.round(depths * 65535).astype("u2"))
    inside = heic_with_depth(folder / "inside.heic", 1.0, 8.0, depths, quality=60)
    return [save(folder / "photo.heic", colors(64, 64), quality=60), inside]


def read_with_map(suffix: str) -> Callable[[Path], Plate]:
    """Return a reader of a damaged picture with an undamaged depth map, or the other way round.

    A picture that carries its depth inside is read alone.
    """

    def read(path: Path) -> Plate:
        if path.name.startswith("inside"):
            return read_plate(path)
        is_map = path.name.startswith("map")
        color = path.with_name(f"photo{suffix}") if is_map else path
        whole_map = "map.png" if suffix == ".heic" else f"map{suffix}"
        depth = path if is_map else path.with_name(whole_map)
        return read_plate(color, PlateOptions(depth_source=str(depth), **_ENDS))

    return read
