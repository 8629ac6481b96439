"""Estimate the depth of a picture that has none, calmly over the frames of a sequence.

Every frame is fitted to the first of its block, and this one to the first of the block before, so
that any frame can be read alone and is the same as in the whole sequence.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.plate_options import (
    DepthConvention,
    DepthKind,
    DepthModelOutput,
    PlateOptions,
)
from heatlens.plate.bounds import DEPTH_LEAST_M
from heatlens.plate.depth.depth import DepthResult, checked_ends, with_ends
from heatlens.plate.depth.depth_guess import DepthOrigin, Guess, looked_at
from heatlens.plate.estimate.calm import Estimated, Fit, fitted
from heatlens.plate.estimate.edges import with_sharp_edges
from heatlens.plate.estimate.kept_estimates import estimate_kept
from heatlens.plate.estimate.network import Network, as_display, network_at, resized
from heatlens.plate.estimate.scale import DIOPTRES_LEAST, scale_of
from heatlens.plate.plate import DepthReport, FloatImage
from heatlens.sequence.sequence import Sequence, find_sequence, stamp_of

Look = Callable[[Path], FloatImage]  # returns the light (H, W, 3 or more) of the picture at a path

CHANNEL = "estimate"
_BLOCK = 8  # frames that are fitted to the same one
_RAMP_PX = 3.0  # pixels of the network over which it blurs an edge, to either side
_REACH_MOST_PX = 24


def estimated_depth(
    path: Path, color: FloatImage, options: PlateOptions, look: Look
) -> DepthResult:
    """Return the estimated depth (H, W) in metres of light (H, W, 3 or more).

    `look` reads other frames of the sequence. Raises InputError if the network cannot be run, or if
    its values need distances that are missing and `options` are strict.
    """
    assert options.depth_model is not None
    network = network_at(options.depth_model, options.depth_model_output)
    chain = _Chain(network, _sequence_of(path), look)
    frame = _estimated(network, color)
    values, first = chain.fit_of(path, frame).of(frame.values), chain.first_of(path, frame)
    options, guess = _guess(path, network, options, first.values)
    scale = scale_of(first.values, network.facts.output, options, color.shape)
    height, width = color.shape[:2]
    dioptres = scale.dioptres(resized(values, width, height))
    depth = 1.0 / _sharp(dioptres, color, values.shape)
    depth = np.clip(depth, DEPTH_LEAST_M, 1.0 / DIOPTRES_LEAST).astype(np.float32)
    report = DepthReport(
        CHANNEL,
        guess.convention,
        DepthKind.PLANAR,
        guess.why,
        float(depth.min()),
        float(depth.max()),
        infinite_count=0,
        repaired_count=0,
        question=guess.question,
    )
    question = f"{guess.question} {guess.why}" if guess.question else ""
    return DepthResult(depth, report, tuple(filter(None, [network.note, question])))


def _guess(
    path: Path, network: Network, options: PlateOptions, first: FloatImage
) -> tuple[PlateOptions, Guess]:
    """Return the options with both ends of a disparity, and what the user is told of the depth."""
    by = f"Estimated by {network.path.name}."
    if network.facts.output is not DepthModelOutput.DISPARITY:
        return options, Guess(DepthConvention.DISTANCE, by)
    raw = looked_at(first, f"{path}: the estimate", CHANNEL, DepthOrigin())
    options, guess = with_ends(raw, options, Guess(DepthConvention.DISPARITY, by))
    checked_ends(raw, options)
    return options, guess


def _sequence_of(path: Path) -> Sequence | None:
    try:
        found = find_sequence(path)
    except InputError:  # standard input
        return None
    return None if found.is_single else found


def _estimated(network: Network, color: FloatImage) -> Estimated:
    seen = network.seen(color)
    shown = as_display(color)
    small = [resized(plane, seen.shape[3], seen.shape[2]) for plane in np.moveaxis(shown, 2, 0)]
    values = estimate_kept(network, seen)
    width, height = values.shape[1], values.shape[0]
    return Estimated(values, np.stack([resized(it, width, height) for it in small], axis=-1))


@dataclass(frozen=True)
class _Chain:
    """Fits frames to the first one of the sequence, by way of the first frame of each block."""

    network: Network
    sequence: Sequence | None
    look: Look

    def first_of(self, path: Path, frame: Estimated) -> Estimated:
        """Return the estimate of the first frame; `frame` is that at `path`."""
        return frame if self.sequence is None else self._block(path, frame, 0)[0]

    def fit_of(self, path: Path, frame: Estimated) -> Fit:
        """Return the fit of the frame at `path`."""
        if self.sequence is None:
            return Fit()
        at = self.sequence.frame_at(path)
        if at is None or at not in self.sequence.present:
            return Fit()
        number = self.sequence.present.index(at)
        block, inside = divmod(number, _BLOCK)
        start, fit = self._block(path, frame, block)
        return fit if not inside else self._fitted(frame, start, fit)

    def _block(self, path: Path, frame: Estimated, block: int) -> tuple[Estimated, Fit]:
        """Return the estimate and the fit of the first frame of a block."""
        assert self.sequence is not None
        chain: tuple[Estimated, Fit] | None = None
        for number in range(block + 1):
            at = self.sequence.path_at(self.sequence.present[number * _BLOCK])
            chain = self._next(at, frame if at == path else None, chain)
        assert chain is not None
        return chain

    def _next(
        self, path: Path, frame: Estimated | None, before: tuple[Estimated, Fit] | None
    ) -> tuple[Estimated, Fit]:
        """Return the estimate and the fit of a frame that is fitted to the one `before`."""
        key = (self.network.key, self.network.facts.output, path, stamp_of(path))
        found = _kept_links(key, before is None)
        if not found:
            made = frame or _estimated(self.network, self.look(path))
            fit = Fit() if before is None else self._fitted(made, *before)
            found.append((made, fit))
        return found[0]

    def _fitted(self, frame: Estimated, before: Estimated, fit: Fit) -> Fit:
        keeps_zero = self.network.facts.output is not DepthModelOutput.DISPARITY
        return fitted(frame, before, fit, keeps_zero)


@lru_cache(maxsize=256)
def _kept_links(_key: object, _is_first: bool) -> list[tuple[Estimated, Fit]]:
    """Return the same list for the same frame, which holds its estimate and fit once made."""
    return []


def _sharp(dioptres: FloatImage, color: FloatImage, own: tuple[int, ...]) -> FloatImage:
    """Return dioptres (H, W) with the edges of the picture; `own` is the size of the estimate."""
    low, high = (float(it) for it in np.quantile(dioptres[::4, ::4], (0.0, 1.0)))
    scale = max(dioptres.shape[0] / own[0], dioptres.shape[1] / own[1])
    reach = min(round(_RAMP_PX * max(scale, 1.0)), _REACH_MOST_PX)
    span = np.float32(max(high - low, 1e-9))
    shares = (dioptres - np.float32(low)) / span
    sharp = with_sharp_edges(shares, as_display(color), max(reach, 1))
    found: FloatImage = np.maximum(sharp * span + np.float32(low), np.float32(DIOPTRES_LEAST))
    return found
