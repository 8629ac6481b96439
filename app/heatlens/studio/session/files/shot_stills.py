"""Small pictures of the shots of a reel, made on a thread and kept beside the rendered frames."""

import hashlib
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.plate import FloatImage
from heatlens.media.plate.read import read_light
from heatlens.media.sequence.sequence import stamp_of
from heatlens.media.sequence.sequence_search import find_sequence
from heatlens.render.rendered_frames.cached_pictures import CachedPicture, DiskStore, to_half

Still = NDArray[np.float16]  # (H, W, 4), scene-linear
FirstPicture = tuple[str, PlateOptions, int | None]  # source, its options, frame

_WIDTH_PX = 128
_KEPT_BYTES = 64 << 20  # some 900 stills
_FOLDER = "stills"


# A still is read when its row is first seen, on a thread, and kept beside the rendered frames under
# the content of its file. It keeps scene-linear light, see `ui/panels/reel_stills.py`.
class ShotStills:
    """Stills of shots by a key, such as the shot, each read when it is first asked for."""

    def __init__(self, wake: Callable[[], None], frames_folder: Path | None) -> None:
        """Keep stills in `frames_folder`, or only in memory if None; `wake` is called for each."""
        self._wake = wake
        self._store = DiskStore(frames_folder / _FOLDER, _KEPT_BYTES) if frames_folder else None
        self._threads = Threads("stills")
        self._futures: dict[Hashable, Future[Still | None]] = {}

    def clear(self) -> None:
        """Forget all stills, because another reel is open."""
        for future in self._futures.values():
            future.cancel()
        self._futures = {}

    def still(self, key: Hashable, find_first: Callable[[], FirstPicture]) -> Still | None:
        """Return the still of a shot, top row first; None until it is read or if there is none.

        `find_first` returns the first picture of the shot; it is called on the thread.
        """
        if key not in self._futures:
            future = self._threads.submit(partial(_make_still, self._store, find_first))
            future.add_done_callback(lambda _: self._wake())
            self._futures[key] = future
        future = self._futures[key]
        return future.result() if future.done() and not future.cancelled() else None

    def close(self) -> None:
        """Read no more."""
        self._threads.close()


def _make_still(store: DiskStore | None, find_first: Callable[[], FirstPicture]) -> Still | None:
    """Return a still, from the store if it is there; None for a scene or a damaged plate."""
    try:
        with report_faults("The first picture of a shot could not be read"):
            source, options, frame = find_first()
            return _load_or_read(store, _path_at(source, frame), options).pixels
    except HeatlensError:  # reported when the shot is opened
        return None


def _load_or_read(store: DiskStore | None, path: Path, options: PlateOptions) -> CachedPicture:
    """Return the small picture of a file from the store, or read the file and store it."""
    key = hashlib.sha256(repr((path, stamp_of(path), options)).encode()).hexdigest()[:32]
    picture = store.load(key) if store else None
    if picture is None:
        picture = _shrink(read_light(options, path))
        if store:
            store.save(key, picture)
    return picture


def _path_at(source: str, frame: int | None) -> Path:
    """Return the file of a frame of a sequence, or its first file if the frame is missing."""
    sequence = find_sequence(source)
    has_frame = frame is not None and sequence.has_file(frame)
    return sequence.path_at(frame if has_frame and frame is not None else sequence.present[0])


def _shrink(light: FloatImage) -> CachedPicture:
    """Return the picture made smaller: each pixel is the mean of a square."""
    side = max(1, light.shape[1] // _WIDTH_PX)
    height, width = (max(1, length // side) for length in light.shape[:2])
    squares = light[: height * side, : width * side].reshape(height, side, width, side, 4)
    box = Box(0, 0, width, height)
    return CachedPicture(pixels=to_half(squares.mean((1, 3))), data_window=box, display_window=box)
