"""Save and copy the picture: it is read back when complete, and written on a thread."""

import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from heatlens.base.background import Background
from heatlens.base.errors import HeatlensError, InputError
from heatlens.gpu.textures import download
from heatlens.model.lens import Lens
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


@dataclass(frozen=True)
class _Request:
    """The requested picture and its destination: a file, or None for the clipboard."""

    source: str | None
    frame: int
    path: Path | None

    @property
    def words(self) -> str:
        return "copying it" if self.path is None else f"saving {self.path.name}"


class PictureSaver:
    """Saves or copies one picture at a time, and reports how it ended."""

    def __init__(self, say: Callable[[str], None], wake: Callable[[], None]) -> None:
        self._say = say
        self._request: _Request | None = None
        self._writer: Background[str] = Background(wake)

    @property
    def is_busy(self) -> bool:
        """Return True while a picture is awaited or written."""
        return self._request is not None or self._writer.is_busy

    def ask(self, source: str | None, frame: int, path: Path | None) -> None:
        """Save the picture of `frame` to `path`, or copy it, as soon as it is complete."""
        if self._writer.is_busy:
            self._say("The previous picture is still being written: try again in a moment.")
            return
        self._request = _Request(source, frame, path)
        self._say(f"Waiting for the whole picture before {self._request.words} ...")

    def poll(
        self, shown: Shown | None, source: str | None, frame: int, snap: Callable[[], Snapshot]
    ) -> None:
        """Begin to save once `shown` is the whole picture of the request; report the result.

        `source` and `frame` are the current ones; `shown` is None while the picture is not whole.
        """
        request = self._request
        if request is not None and (request.source, request.frame) != (source, frame):
            self._request = None
            self._say(f"The frame was left before its picture was complete: not {request.words}.")
        elif request is not None and shown is not None:
            self._request = None
            self._say(f"{request.words.capitalize()} ...")
            self._writer.start(partial(_done, snap(), request.path))
        try:
            said = self._writer.poll()
        except HeatlensError as error:
            said = str(error)
        if said is not None:
            self._say(said)

    def close(self) -> None:
        """Wait until a file that is being written is finished."""
        self._writer.wait()


def snapshot(shown: Shown, plate: Plate, encode: Encode) -> Snapshot:
    """Read the picture back; call this on the thread of the GL context."""
    shot = shown.shot
    pixels = download(shown.texture)
    return Snapshot(pixels, plate, shot.lens_at(shown.frame), shot.defocus.proxy, encode)


def _done(picture: Snapshot, path: Path | None) -> str:
    """Write or copy the picture; runs on a thread. Return the message that says so."""
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
