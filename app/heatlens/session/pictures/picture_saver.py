"""Write a picture that was read back to a file or to the clipboard."""

import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.gpu.textures import download
from heatlens.model.lens.lens import Lens
from heatlens.plate.picture.picture_write import Encode, check_output, write_picture
from heatlens.plate.plate import FloatImage, Plate
from heatlens.preview.shown import Shown
from heatlens.scene.scene_read import files_of_scene
from heatlens.session.pictures.clipboard import copy_png


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A complete picture, the same as from `heatlens render`, and the look of the view."""

    pixels: FloatImage
    plate: Plate
    lens: Lens
    proxy: float
    encode: Encode


def snapshot(shown: Shown, plate: Plate, encode: Encode) -> Snapshot:
    """Read the picture back; call this on the thread of the GL context."""
    shot = shown.shot
    pixels = download(shown.texture)
    return Snapshot(pixels, plate, shot.lens_at(shown.frame), shot.defocus.proxy, encode)


def saved(picture: Snapshot, path: Path | None) -> str:
    """Write the picture, or copy it for None; on a thread. Return the message that says so."""
    if path is None:
        _copy(picture)
        return "The picture is on the clipboard."
    check_output(path, *_sources(picture.plate.path))
    _write(picture, path)
    return f"Saved {path}."


def _sources(path: Path) -> tuple[Path, ...]:
    """Return the files of a plate or a scene, with the files that it refers to."""
    try:
        return files_of_scene(path)
    except InputError:  # deleted or rewritten since it was read: its other files are unknown now
        return (path,)


def _write(picture: Snapshot, path: Path) -> None:
    write_picture(
        path, picture.pixels, picture.plate, picture.lens, picture.proxy, encode=picture.encode
    )


def _copy(picture: Snapshot) -> None:
    with tempfile.TemporaryDirectory(prefix="heatlens-") as folder:
        path = Path(folder) / "picture.png"
        _write(picture, path)
        copy_png(path, sys.platform, os.environ, shutil.which)
