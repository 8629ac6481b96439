"""Formats for the fuzzers: pictures with a wrong ending, PFM maps, and Cryptomatte manifests."""

from collections.abc import Iterable
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.media.files.picture_formats import suffixes_read
from heatlens.media.plate.mattes.mattes import read_matte
from heatlens.media.plate.picture.picture_open import open_picture, picture_info
from heatlens.media.plate.read import read_plate
from support.mattes import MANIFEST, matte_plate

_COLORS = np.linspace(0, 255, 6 * 9 * 3).reshape(6, 9, 3).astype(np.uint8)
_OTHERS = {
    "eps": b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n%%EndComments\nshowpage\n",
    "playlist": b"ffconcat version 1.0\nfile seg.ts\n",
    "pdf": b"%PDF-1.4\n1 0 obj <<>> endobj\ntrailer <<>>\n",
    "json": b'{"K": [1, 2, 3]}',
}


def _contents() -> dict[str, bytes]:
    contents = dict(_OTHERS)
    for kind in ("PNG", "JPEG", "TIFF", "WEBP", "BMP", "TGA", "GIF", "PPM"):
        file = BytesIO()
        Image.fromarray(_COLORS).save(file, kind)
        contents[kind.lower()] = file.getvalue()
    return contents


def under_other_endings(folder: Path) -> list[Path]:
    """Write each kind of content with every picture file ending, also the right one."""
    paths = []
    for kind, content in _contents().items():
        for suffix in suffixes_read()[1:]:
            path = folder / f"{kind}{suffix}"
            path.write_bytes(content)
            paths.append(path)
    return paths


def values(path: Path) -> Iterable[np.ndarray]:
    """Read the facts of a picture, then its pixels.

    Undamaged pictures with a wrong ending are refused, so an `InputError` is accepted here.
    """
    with suppress(InputError):
        picture_info(path)
        return [open_picture(path).values.astype(np.float64)]
    return []


def pfm(folder: Path) -> list[Path]:
    """Write grey and coloured maps in both orders of bytes."""
    paths = []
    for name, values_, order in (("Pf", _COLORS[..., 0], "<"), ("PF", _COLORS, ">")):
        head = f"{name}\n9 6\n{-1.0 if order == '<' else 1.0}\n".encode()
        path = folder / f"{name}{len(paths)}.pfm"
        path.write_bytes(head + (values_[::-1] / 255).astype(f"{order}f4").tobytes())
        paths.append(path)
    return paths


def finite_values(path: Path) -> Iterable[np.ndarray]:
    """Read a map and return only its shape, as a PFM may hold any numbers."""
    return [np.array(open_picture(path).values.shape, float)]


def manifests(folder: Path) -> list[Path]:
    """Write the manifest of a Cryptomatte beside its plate."""
    matte_plate(folder / "p.exr", 3.0, manifest="", manif_file="m.json")
    (folder / "m.json").write_text(MANIFEST)
    return [folder / "m.json"]


def matte_by_manifest(path: Path) -> Iterable[np.ndarray]:
    """Read the matte of a thing that the manifest names."""
    return [read_matte(read_plate(path.with_name("p.exr")), "cryptomatte:hero")]
