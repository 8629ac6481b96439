"""Pictures under the endings of others, PFM, and the manifest beside a plate, for the fuzzers."""

from collections.abc import Iterable
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.media.files.picture_formats import suffixes_read
from heatlens.media.plate.mattes.mattes import matte_of
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
    found = dict(_OTHERS)
    for kind in ("PNG", "JPEG", "TIFF", "WEBP", "BMP", "TGA", "GIF", "PPM"):
        file = BytesIO()
        Image.fromarray(_COLORS).save(file, kind)
        found[kind.lower()] = file.getvalue()
    return found


def under_other_endings(folder: Path) -> list[Path]:
    """Write each kind of content under the ending of every picture, its own among them."""
    made = []
    for kind, content in _contents().items():
        for suffix in suffixes_read()[1:]:
            path = folder / f"{kind}{suffix}"
            path.write_bytes(content)
            made.append(path)
    return made


def values(path: Path) -> Iterable[np.ndarray]:
    """Read a picture, and what is known of it before its pixels are decoded.

    Whole ones under another ending are refused, so that a sentence is as good as numbers here.
    """
    with suppress(InputError):
        picture_info(path)
        return [open_picture(path).values.astype(np.float64)]
    return []


def pfm(folder: Path) -> list[Path]:
    """Write grey and coloured maps in both orders of bytes."""
    made = []
    for name, values_, order in (("Pf", _COLORS[..., 0], "<"), ("PF", _COLORS, ">")):
        head = f"{name}\n9 6\n{-1.0 if order == '<' else 1.0}\n".encode()
        path = folder / f"{name}{len(made)}.pfm"
        path.write_bytes(head + (values_[::-1] / 255).astype(f"{order}f4").tobytes())
        made.append(path)
    return made


def finite_values(path: Path) -> Iterable[np.ndarray]:
    """Read a map; its numbers may be any, so that only its size is given."""
    return [np.array(open_picture(path).values.shape, float)]


def manifests(folder: Path) -> list[Path]:
    """Write the manifest of a Cryptomatte beside its plate."""
    matte_plate(folder / "p.exr", 3.0, manifest="", manif_file="m.json")
    (folder / "m.json").write_text(MANIFEST)
    return [folder / "m.json"]


def matte_by_manifest(path: Path) -> Iterable[np.ndarray]:
    """Read the matte of a thing that the manifest names."""
    return [matte_of(read_plate(path.with_name("p.exr")), "cryptomatte:hero")]
