"""Put the estimates of all frames of a sequence on the scale of its first frame.

Every frame is fitted to the first frame of its block, and that to the first frame of the previous
block. A frame that is read alone is therefore the same as in the whole sequence.
"""

import hashlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from threading import Lock

import numpy as np

from heatlens.core.base.paths import estimates_dir
from heatlens.core.model.depth_words import DepthModelOutput
from heatlens.media.files.kept_files import keep_file, read_kept_file
from heatlens.media.plate.estimate.network import Network, convert_to_display, resize_plane
from heatlens.media.plate.estimate.scale import Fit, FrameEstimate, fit_to_frame
from heatlens.media.plate.plate import FloatImage
from heatlens.media.sequence.sequence import Sequence, stamp_of

ReadColor = Callable[
    [Path], FloatImage
]  # returns the light (H, W, 3 or more) of the picture at a path

_BLOCK = 8  # number of frames that are fitted to the first frame of their block
_STARTS_MOST = 16  # first frames of blocks whose estimates stay in memory

_lock = Lock()  # several threads read plates
_fits: dict[object, Fit] = {}  # of the first frames of blocks, by `Chain._key`
_start_estimates: dict[object, FrameEstimate] = {}  # of the same frames, the oldest first


def estimate_frame(network: Network, color: FloatImage) -> FrameEstimate:
    """Return the estimate of light (H, W, 3 or more). Raises InputError if the network fails."""
    network_input = network.prepare_input(color)
    display_color = convert_to_display(color)
    small_planes = [
        resize_plane(plane, network_input.shape[3], network_input.shape[2])
        for plane in np.moveaxis(display_color, 2, 0)
    ]
    values = estimate_or_load(network, network_input)
    height, width = values.shape
    return FrameEstimate(
        values, np.stack([resize_plane(plane, width, height) for plane in small_planes], axis=-1)
    )


def clear_memory() -> None:
    """Forget all fits and estimates in memory; those on disk stay."""
    _fits.clear()
    _start_estimates.clear()


@dataclass(frozen=True)
class Chain:
    """The fits of a sequence to its first frame, by way of the first frame of each block."""

    network: Network
    sequence: Sequence
    read_color: ReadColor

    def fit_of(self, path: Path, frame: FrameEstimate) -> Fit:
        """Return the fit of the frame at `path` to the first frame; `frame` is its estimate.

        A file that is not in the sequence gets a fit that changes nothing.
        """
        frame_number = self.sequence.frame_at(path)
        if frame_number is None or frame_number not in self.sequence.present:
            return Fit()
        block, number_in_block = divmod(self.sequence.present.index(frame_number), _BLOCK)
        fit = self._fit_of_block(block)
        # The first frame of a block has the fit of the block itself.
        return self._fit_to(frame, self.start_estimate(block), fit) if number_in_block else fit

    def start_estimate(self, block: int) -> FrameEstimate:
        """Return the estimate of the first frame of a block."""
        key = self._key(block)
        estimate = _start_estimates.get(key)
        if estimate is None:
            estimate = estimate_frame(self.network, self.read_color(self._start_path(block)))
            with _lock:
                _start_estimates[key] = estimate
                for oldest in list(_start_estimates)[:-_STARTS_MOST]:
                    del _start_estimates[oldest]
        return estimate

    # Frame 1000 read alone needs 125 fits of blocks of 8 frames, each stored once computed. If
    # every frame were fitted to the previous one, it would need 999 estimates, and errors would add
    # up 999 times. The estimates of the first frames of all blocks would take up to a gigabyte for
    # a long movie, so only the last _STARTS_MOST stay in memory.
    def _fit_of_block(self, block: int) -> Fit:
        """Return the fit of the first frame of a block, starting from the last block known."""
        known_block = block
        while known_block > 0 and self._key(known_block) not in _fits:
            known_block -= 1
        fit = _fits.get(self._key(known_block), Fit())
        for number in range(known_block + 1, block + 1):
            fit = self._fit_to(self.start_estimate(number), self.start_estimate(number - 1), fit)
            _fits[self._key(number)] = fit
        return fit

    def _start_path(self, block: int) -> Path:
        """Return the path of the first frame of a block."""
        return self.sequence.path_at(self.sequence.present[block * _BLOCK])

    def _key(self, block: int) -> object:
        """Return a key of a block that changes with the network and with two files.

        The files are the first frame of the sequence and that of the block.
        """
        first, path = self._start_path(0), self._start_path(block)
        network = self.network.key, self.network.facts.output
        return *network, first, stamp_of(first), path, stamp_of(path)

    def _fit_to(self, frame: FrameEstimate, earlier_frame: FrameEstimate, fit: Fit) -> Fit:
        """Return the fit of `frame` to the first frame, by way of an earlier one and its `fit`."""
        keeps_zero = self.network.facts.output is not DepthModelOutput.DISPARITY
        return fit_to_frame(frame, earlier_frame, fit, keeps_zero)


_BYTES_MOST = 2 << 30  # of all estimates on disk
_SUFFIX = ".estimate.npy"


def estimate_or_load(network: Network, network_input: FloatImage) -> FloatImage:
    """Return the raw values (h, w) of the network for an input, from a file if there is one.

    Otherwise the network is run, and its values are stored in a file if one can be written. Raises
    InputError if the network fails.
    """
    digest = hashlib.blake2b(network_input.tobytes(), digest_size=16, key=network.key.encode())
    path = estimates_dir() / f"{digest.hexdigest()}{_SUFFIX}"
    kept = read_kept_file(path)
    if kept is not None:
        with suppress(ValueError):  # it is damaged
            stored: FloatImage = np.load(BytesIO(kept), allow_pickle=False)
            return stored
    values = network.estimate(network_input)
    encoded = BytesIO()
    np.save(encoded, values)
    keep_file(path, encoded.getvalue(), _BYTES_MOST)
    return values
