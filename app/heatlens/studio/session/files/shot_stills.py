"""Small pictures of the shots of a reel, made on a thread and kept beside the rendered frames."""

import hashlib
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import faults_reported
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.plate import FloatImage
from heatlens.media.plate.read import read_light
from heatlens.media.sequence.sequence import find_sequence, stamp_of
from heatlens.render.rendered_frames.kept_pictures import DiskStore, KeptPicture, half_of

Still = NDArray[np.float16]  # (H, W, 4), scene-linear
FirstPicture = tuple[str, PlateOptions, int | None]  # source, its options, frame

_WIDTH_PX = 128
_KEPT_BYTES = 64 << 20  # some 900 stills
_FOLDER = "stills"


# A still is read when its row is first seen, on a thread, and kept beside the rendered frames under
# the content of its file. It keeps scene-linear light, see `ui/panels/reel_panel.py`.
class ShotStills:
    """Stills of shots by their number, each read when it is first asked for."""

    def __init__(self, wake: Callable[[], None], frames_folder: Path | None) -> None:
        """Keep them in `frames_folder`, or in memory only if None; `wake` is called for each."""
        self._wake = wake
        self._store = DiskStore(frames_folder / _FOLDER, _KEPT_BYTES) if frames_folder else None
        self._threads = Threads("stills")
        self._coming: dict[int, Future[Still | None]] = {}

    def clear(self) -> None:
        """Forget all of them, for another reel."""
        for coming in self._coming.values():
            coming.cancel()
        self._coming = {}

    def of(self, number: int, first: Callable[[], FirstPicture]) -> Still | None:
        """Return the still, the top row first; None if there is none yet, or never.

        `first` tells the first picture of the shot; it is called on the thread.
        """
        if number not in self._coming:
            coming = self._threads.submit(partial(_made, self._store, first))
            coming.add_done_callback(lambda _: self._wake())
            self._coming[number] = coming
        coming = self._coming[number]
        return coming.result() if coming.done() and not coming.cancelled() else None

    def close(self) -> None:
        """Read no more."""
        self._threads.close()


def _made(store: DiskStore | None, first: Callable[[], FirstPicture]) -> Still | None:
    """Return a still, from the store if it is there; None for a scene or a damaged plate."""
    try:
        with faults_reported("The first picture of a shot could not be read"):
            source, options, frame = first()
            return _kept(store, _path_at(source, frame), options).pixels
    except HeatlensError:  # told when the shot is opened
        return None


def _kept(store: DiskStore | None, path: Path, options: PlateOptions) -> KeptPicture:
    """Return the small picture of a file from the store, or read the file and store it."""
    key = hashlib.sha256(repr((path, stamp_of(path), options)).encode()).hexdigest()[:32]
    stored = store.load(key) if store else None
    if stored is None:
        stored = _small(read_light(options, path))
        if store:
            store.save(key, stored)
    return stored


def _path_at(source: str, frame: int | None) -> Path:
    sequence = find_sequence(source)
    there = frame is not None and sequence.has(frame)
    return sequence.path_at(frame if there and frame is not None else sequence.present[0])


def _small(light: FloatImage) -> KeptPicture:
    """Return the picture made smaller: each pixel is the mean of a square."""
    side = max(1, light.shape[1] // _WIDTH_PX)
    height, width = (max(1, length // side) for length in light.shape[:2])
    squares = light[: height * side, : width * side].reshape(height, side, width, side, 4)
    box = Box(0, 0, width, height)
    return KeptPicture(half_of(squares.mean((1, 3))), box, box)
