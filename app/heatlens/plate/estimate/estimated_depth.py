"""Estimate the depth of a picture that has none, with the edges of its colours."""

from pathlib import Path

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.depth_words import DepthConvention, DepthKind, DepthModelOutput
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.bounds import DEPTH_LEAST_M
from heatlens.plate.depth.depth import DepthResult, checked_ends, with_ends
from heatlens.plate.depth.depth_guess import DepthOrigin, Guess, looked_at
from heatlens.plate.estimate.calm import Fit
from heatlens.plate.estimate.chain import Chain, Look, estimated
from heatlens.plate.estimate.edges import with_sharp_edges
from heatlens.plate.estimate.network import Network, as_display, network_at, resized
from heatlens.plate.estimate.scale import DIOPTRES_LEAST, scale_of
from heatlens.plate.plate import DepthReport, FloatImage
from heatlens.sequence.sequence import Sequence, find_sequence

CHANNEL = "estimate"
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
    frame, sequence = estimated(network, color), _sequence_of(path)
    fit, first = Fit(), frame
    if sequence is not None:
        chain = Chain(network, sequence, look)
        fit, first = chain.fit_of(path, frame), chain.start(0)
    values = fit.of(frame.values)
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
