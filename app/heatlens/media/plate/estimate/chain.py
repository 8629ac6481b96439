"""Put the estimates of all frames of a sequence on the scale of its first frame.

Every frame is fitted to the first of its block, and this one to the first of the block before, so
that any frame can be read alone and is the same as in the whole sequence.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from threading import Lock

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import estimates_dir, file_bytes
from heatlens.core.model.depth_words import DepthModelOutput
from heatlens.media.files.atomic_file import FOR_THE_USER, replacing
from heatlens.media.plate.estimate.network import Network, as_display, resized
from heatlens.media.plate.estimate.scale import Estimated, Fit, fitted
from heatlens.media.plate.plate import FloatImage
from heatlens.media.sequence.sequence import Sequence, stamp_of

Look = Callable[[Path], FloatImage]  # returns the light (H, W, 3 or more) of the picture at a path

_BLOCK = 8  # frames that are fitted to the same one
_STARTS_MOST = 16  # first frames of blocks whose estimates stay in memory

_lock = Lock()  # several threads read plates
_fits: dict[object, Fit] = {}  # of the first frames of blocks
_starts: dict[object, Estimated] = {}  # the oldest first


def estimated(network: Network, color: FloatImage) -> Estimated:
    """Return the estimate of light (H, W, 3 or more). Raises InputError if the network fails."""
    seen = network.seen(color)
    shown = as_display(color)
    small = [resized(plane, seen.shape[3], seen.shape[2]) for plane in np.moveaxis(shown, 2, 0)]
    values = estimate_kept(network, seen)
    height, width = values.shape
    return Estimated(values, np.stack([resized(it, width, height) for it in small], axis=-1))


def forget() -> None:
    """Forget all fits and estimates in memory; those on disk stay."""
    _fits.clear()
    _starts.clear()


@dataclass(frozen=True)
class Chain:
    """The fits of a sequence to its first frame, by way of the first frame of each block."""

    network: Network
    sequence: Sequence
    look: Look

    def fit_of(self, path: Path, frame: Estimated) -> Fit:
        """Return the fit of the frame at `path`, whose estimate is given."""
        at = self.sequence.frame_at(path)
        if at is None or at not in self.sequence.present:
            return Fit()
        block, inside = divmod(self.sequence.present.index(at), _BLOCK)
        fit = self._fit_of_block(block)
        return self._fitted(frame, self.start(block), fit) if inside else fit

    def start(self, block: int) -> Estimated:
        """Return the estimate of the first frame of a block."""
        key = self._key(block)
        estimate = _starts.get(key)
        if estimate is None:
            estimate = estimated(self.network, self.look(self._path(block)))
            with _lock:
                _starts[key] = estimate
                for oldest in list(_starts)[:-_STARTS_MOST]:
                    del _starts[oldest]
        return estimate

    # If every frame were fitted to the one before it, reading frame 1000 alone would need 999
    # estimates, and errors would add up 999 times. Blocks of 8 make that 125 fits, each kept once
    # known. The first frames of all blocks used to be held, up to a gigabyte for a long movie.
    def _fit_of_block(self, block: int) -> Fit:
        """Return the fit of the first frame of a block, from the last one that is known onwards."""
        known = block
        while known > 0 and self._key(known) not in _fits:
            known -= 1
        fit = _fits.get(self._key(known), Fit())
        for number in range(known + 1, block + 1):
            fit = self._fitted(self.start(number), self.start(number - 1), fit)
            _fits[self._key(number)] = fit
        return fit

    def _path(self, block: int) -> Path:
        return self.sequence.path_at(self.sequence.present[block * _BLOCK])

    def _key(self, block: int) -> object:
        first, path = self._path(0), self._path(block)
        network = self.network.key, self.network.facts.output
        return *network, first, stamp_of(first), path, stamp_of(path)

    def _fitted(self, frame: Estimated, before: Estimated, fit: Fit) -> Fit:
        keeps_zero = self.network.facts.output is not DepthModelOutput.DISPARITY
        return fitted(frame, before, fit, keeps_zero)


_BYTES_MOST = 2 << 30
_SUFFIX = ".estimate.npy"


def estimate_kept(network: Network, seen: FloatImage) -> FloatImage:
    """Return the raw values of the network for what it sees, from a file if they were made before.

    Raises InputError if the network fails. If no file can be written, nothing is kept.
    """
    digest = hashlib.blake2b(seen.tobytes(), digest_size=16, key=network.key.encode())
    path = estimates_dir() / f"{digest.hexdigest()}{_SUFFIX}"
    with suppress(OSError, ValueError):  # it is missing or damaged
        stored: FloatImage = np.load(BytesIO(file_bytes(path)), allow_pickle=False)
        os.utime(path)
        return stored
    values = network.estimate(seen)
    with suppress(OSError, InputError):  # a full or read-only disk
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        _make_room(path.parent)
        encoded = BytesIO()
        np.save(encoded, values)
        with replacing(path, FOR_THE_USER) as beside:
            beside.write_bytes(encoded.getvalue())
    return values


def _make_room(folder: Path) -> None:
    """Delete the files that were not used for longest, beyond the limit."""
    files = sorted(
        (file.stat().st_mtime_ns, file.stat().st_size, file) for file in folder.glob(f"*{_SUFFIX}")
    )
    total = sum(size for _, size, _ in files)
    for _, size, file in files:
        if total <= _BYTES_MOST:
            return
        file.unlink(missing_ok=True)
        total -= size
