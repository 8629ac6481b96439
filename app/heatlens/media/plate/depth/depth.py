"""Convert a depth channel of any convention to meters, with one notation for infinity.

A depth that is only relative in its file needs the meters of its near and far end.
"""

import math
from dataclasses import dataclass, replace
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Explained
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.depth_guess import NORMALIZED_UP_TO, Guess, guess_convention
from heatlens.media.plate.depth.raw_depth import (
    DepthOrigin,
    RawDepth,
    measure_raw_depth,
    scale_white_to_one,
)
from heatlens.media.plate.depth.repair import DEPTH_LEAST_M, bound_coc, repair_depth
from heatlens.media.plate.plate import DepthReport, FloatImage

# A few values of the wrong sign come from filtering at edges; more mean it is not a depth channel.
MAX_WRONG_SIGN_FRACTION = 0.25
# NaN in a larger part of the frame marks a sky; in a smaller part they are scattered faults.
NAN_SKY_FRACTION = 0.05
# A distance of 1e10 or more, which means infinity, becomes a 1/z at or below this.
INVERSE_INFINITE_UP_TO = 1e-10

_Mask = NDArray[np.bool_]
_IF_INVERSE = "If it holds 1/z, say --depth-convention inverse."
# The usual ends of a portrait in a room, with which a photo can be viewed before it is measured.
_USUAL_NEAR_M, _USUAL_FAR_M = 1.0, 10.0


@dataclass(frozen=True, eq=False)
class DepthResult:
    """Depths (H, W) in meters, radial if the report says so, or CoC diameters in pixels."""

    values: FloatImage
    report: DepthReport
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _ConvertedDepth:
    """Values in meters or pixels, and masks of the pixels that are infinite or unusable."""

    values: FloatImage
    infinite: _Mask
    bad: _Mask
    notes: tuple[str, ...] = ()


def read_depth(
    values: FloatImage,
    label: str,
    channel: str,
    options: PlateOptions,
    origin: DepthOrigin | None = None,
) -> DepthResult:
    """Convert raw `values` (H, W) to depth in meters; `label` begins each sentence about them.

    `origin` holds what is known about the values besides the name of the channel. Raises InputError
    if the channel is empty, ambiguous or no depth at all; with `options.strict`, also if only the
    user can decide on its convention.
    """
    origin = origin or DepthOrigin()
    raw = measure_raw_depth(values, label, channel, origin)
    guess = guess_convention(raw, options)
    if guess.question and options.strict:
        raise InputError(guess.question)
    if guess.convention.facts.is_disparity:
        options, guess = settle_ends(raw, options, guess)
    convention = guess.convention
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        converted = _convert(raw, convention, options)
    depth = converted.values
    depth[converted.infinite] = np.inf
    is_coc = convention.facts.is_coc
    bad = converted.bad if is_coc else converted.bad | (depth < DEPTH_LEAST_M)
    repaired_count = repair_depth(depth, bad, label)
    clamp_notes = bound_coc(depth, label) if is_coc else ()
    kind = origin.kind if options.depth_kind is DepthKind.AUTO else options.depth_kind
    kind = DepthKind.PLANAR if is_coc else kind
    infinite_count = int(np.count_nonzero(np.isinf(depth)))  # the repair may have copied some
    near, far = (math.nan, math.nan) if is_coc else finite_range(depth, infinite_count)
    report = DepthReport(
        *(channel, convention, kind, guess.why, near, far),
        *(infinite_count, repaired_count, guess.question),
    )
    notes = converted.notes
    if guess.question:  # it offers the same option already
        notes = tuple(note.removesuffix(f" {_IF_INVERSE}") for note in notes)
    return DepthResult(depth, report, (*notes, *clamp_notes, *_depth_notes(raw, report, guess)))


def finite_range(depth: FloatImage, infinite_count: int) -> tuple[float, float]:
    """Return the least and the greatest finite depth; infinity where there is none."""
    if infinite_count == depth.size:
        return math.inf, math.inf
    near = float(depth.min())
    far = float(depth.max())
    if math.isinf(far):
        far = float(np.max(depth, where=np.isfinite(depth), initial=near))
    return near, far


def _convert(raw: RawDepth, convention: DepthConvention, options: PlateOptions) -> _ConvertedDepth:
    """Return the values in meters or pixels; `convention` must not be AUTO."""
    match convention:
        case DepthConvention.COC:
            nothing_infinite = np.zeros(raw.values.shape, dtype=np.bool_)
            return _ConvertedDepth(raw.values.copy(), nothing_infinite, ~np.isfinite(raw.values))
        case DepthConvention.INVERSE:
            return _from_inverse(raw, options.scene_unit_m)
        case DepthConvention.DISTANCE:
            return _from_distance(raw, options.scene_unit_m)
        case DepthConvention.DISPARITY:
            return _from_disparity(scale_white_to_one(raw), is_inverted=False, options=options)
        case DepthConvention.DISPARITY_INVERTED:
            return _from_disparity(scale_white_to_one(raw), is_inverted=True, options=options)
        case DepthConvention.NORMALIZED:
            return _from_normalized(scale_white_to_one(raw), is_inverted=False, options=options)
        case DepthConvention.NORMALIZED_INVERTED:
            return _from_normalized(scale_white_to_one(raw), is_inverted=True, options=options)
        case DepthConvention.AUTO:
            raise ValueError("The convention must be known before depths are converted.")
        case _:
            assert_never(convention)


def _from_distance(raw: RawDepth, scene_unit_m: float) -> _ConvertedDepth:
    """Convert distances in scene units to meters."""
    sign, notes = _viewing_sign(raw)
    depth = raw.values * np.float32(sign * scene_unit_m)
    unmeasured, unmeasured_notes = _mask_unmeasured(raw)
    if unmeasured is not None:
        return _ConvertedDepth(
            depth, raw.infinite, ~(depth > 0) | unmeasured, notes + unmeasured_notes
        )
    infinite, infinite_notes = _mask_nothing_hit(raw)
    bad = ~(depth > 0) & ~infinite  # also true of NaN
    return _ConvertedDepth(values=depth, infinite=infinite, bad=bad, notes=notes + infinite_notes)


# Pixels without a measurement are filled from their neighbors and counted, as NaN is. Taken as a
# distance, 0 would lie on the lens, and the largest number behind everything else.
def _mask_unmeasured(raw: RawDepth) -> tuple[_Mask | None, tuple[str, ...]]:
    """Return a mask where a map of integers holds no measurement, and a note; None for other maps.

    Depth cameras write 0 or the largest number there. If more than half of the pixels hold these
    numbers, they are the sky of a rendered map, and the result is None.
    """
    white = None if raw.origin.facts is None else raw.origin.facts.full_scale
    if white is None:
        return None, ()
    is_zero, is_full = raw.values == 0, raw.values == white
    counts = int(np.count_nonzero(is_zero)), int(np.count_nonzero(is_full))
    if not 0 < sum(counts) <= raw.values.size / 2:
        return None, ()
    note = (
        f"{raw.label} is 0 in {counts[0]} and {white:g} in {counts[1]} of {raw.values.size} "
        "pixels, by which depth cameras mean not measured.",
    )
    return is_zero | is_full, note


def _mask_nothing_hit(raw: RawDepth) -> tuple[_Mask, tuple[str, ...]]:
    """Return a mask of the pixels at infinity, where nothing was hit, and notes about them.

    No surface is at distance 0, so 0 marks infinity if the file has no other mark of it; if it has,
    a 0 is a fault. If the file has neither, NaN over a large part of the frame marks infinity; a
    few NaN are faults.
    """
    if raw.infinite_count:
        return raw.infinite, ()
    if raw.zero_count:
        return raw.values == 0, (
            f"{raw.label} is 0 in {raw.zero_count} pixels: taken as infinitely far. {_IF_INVERSE}",
        )
    if raw.nan_count > NAN_SKY_FRACTION * raw.values.size:
        return np.isnan(raw.values), (
            f"{raw.label} is NaN in {raw.nan_count} of {raw.values.size} pixels: taken as "
            "infinitely far.",
        )
    return raw.infinite, ()


def _from_inverse(raw: RawDepth, scene_unit_m: float) -> _ConvertedDepth:
    """Convert 1/z, z in scene units, to meters; 0 is infinitely far."""
    sign, notes = _viewing_sign(raw)
    inverse = raw.values * np.float32(sign)
    infinite = np.abs(inverse) <= INVERSE_INFINITE_UP_TO
    depth: FloatImage = (np.float32(scene_unit_m) / inverse).astype(np.float32)
    bad = (~(depth > 0) | raw.infinite) & ~infinite
    return _ConvertedDepth(depth, infinite, bad, notes)


def _from_normalized(raw: RawDepth, is_inverted: bool, options: PlateOptions) -> _ConvertedDepth:
    """Convert values that run from 0 at near to 1 at far to meters; 1 and beyond are infinity.

    With `is_inverted`, 1 is near.
    """
    near, far = require_ends(raw, options)
    fraction = 1 - raw.values if is_inverted else raw.values
    infinite = (fraction >= 1) | raw.infinite
    below_count = int(np.count_nonzero(fraction < 0)) if (raw.low < 0 or raw.high > 1) else 0
    depth = np.float32(near) + np.maximum(fraction, 0) * np.float32(far - near)
    notes = (
        (f"{raw.label} is nearer than --near in {below_count} pixels: set to --near.",)
        if below_count
        else ()
    )
    return _ConvertedDepth(depth, infinite, ~(depth > 0) & ~infinite, notes)


def _from_disparity(raw: RawDepth, is_inverted: bool, options: PlateOptions) -> _ConvertedDepth:
    """Convert 0..1 that is linear in 1/z, with 0 for far and 1 for near, to meters.

    Phones and neural networks write such values; with `is_inverted`, 0 is near. Values outside 0..1
    have a scale of their own: the least and the greatest value are then the ends.
    """
    near, far = require_ends(raw, options)
    values = raw.values
    notes: tuple[str, ...] = ()
    if raw.low < 0 or raw.high > NORMALIZED_UP_TO:
        values = (values - np.float32(raw.low)) / np.float32(max(raw.high - raw.low, 1e-30))
        ends = "--near and --far" if is_inverted else "--far and --near"
        notes = (
            f"{raw.label} runs from {raw.low:g} to {raw.high:g}: these are read as {ends}, "
            "separately in every frame.",
        )
    values = 1 - values if is_inverted else values
    dioptres = 1 / far + np.clip(values, 0.0, 1.0) * (1 / near - 1 / far)
    infinite = dioptres <= INVERSE_INFINITE_UP_TO
    depth = (1.0 / dioptres).astype(np.float32)
    return _ConvertedDepth(depth, infinite, ~np.isfinite(raw.values) | raw.infinite, notes)


# Some programs write z of a camera that looks along -z. Filtering at edges leaves a few values of
# the other sign in any depth, so a small share of them is allowed. A channel with many values of
# both signs is something else, such as positions or circles of confusion.
def _viewing_sign(raw: RawDepth) -> tuple[float, tuple[str, ...]]:
    """Return the sign of visible distances: -1 with a note for a camera looking along -z, else 1.

    Raises InputError if both signs occur too often.
    """
    positive = raw.values.size - raw.infinite_count - raw.zero_count - raw.nan_count
    positive -= raw.negative_count
    wrong_count = min(positive, raw.negative_count)
    if wrong_count > MAX_WRONG_SIGN_FRACTION * (positive + raw.negative_count):
        raise InputError(
            f"{raw.label} has {raw.negative_count} negative and {positive} positive values, so it "
            "is not a depth. Name the depth with --depth-channel or, if these are diameters of "
            "the circle of confusion in pixels, say --depth-convention coc."
        )
    if raw.negative_count > positive:
        return -1.0, (
            f"{raw.label} is negative, like coordinates along -z: its sign was reversed.",
        )
    return 1.0, ()


def _depth_notes(raw: RawDepth, report: DepthReport, guess: Guess) -> tuple[str, ...]:
    """Return the notes for the user about this channel."""
    notes: list[str] = []
    if guess.question:
        notes.append(Explained(_guess_note(raw, guess), guess.question))
    elif not guess.certain:
        notes.append(_guess_note(raw, guess))
    if report.repaired_count:
        notes.append(
            f"{raw.label} holds no usable value in {report.repaired_count} of {raw.values.size} "
            "pixels (NaN, not measured, of the wrong sign or nearer than a micrometre): they were "
            "filled from the nearest neighbour."
        )
    if raw.low == raw.high and not 0 < report.infinite_count < raw.values.size:
        notes.append(
            f"{raw.label} is {raw.low:g} everywhere: the blur will be the same everywhere."
        )
    elif report.infinite_count == raw.values.size:
        notes.append(f"{raw.label} is infinite everywhere: nothing was hit in this frame.")
    return tuple(notes)


def _guess_note(raw: RawDepth, guess: Guess) -> str:
    words = f"{raw.label} is taken as {guess.convention.facts.label}"
    return f"{words}. {guess.advice or 'If that is wrong: --depth-convention.'}"


def require_ends(raw: RawDepth, options: PlateOptions) -> tuple[float, float]:
    """Return near and far in meters. Raises InputError if they are missing or impossible.

    The far end of a disparity may be infinite; its near end cannot be 0.
    """
    near, far = options.near_m, options.far_m
    if near is None or far is None:
        raise InputError(
            f"{raw.label} is read as normalised: give the distances of its two ends in metres with "
            "--near and --far."
        )
    is_disparity = options.depth_convention.facts.is_disparity
    is_far_good = far < math.inf or is_disparity
    if not (0 <= near < far and is_far_good) or (is_disparity and near == 0):
        raise InputError(
            f"--near {near:g} and --far {far:g} cannot be the ends of a depth: both are metres, "
            f"near {'more than' if is_disparity else 'at least'} 0 and less than far. Which end "
            "is near is set with --depth-convention."
        )
    return near, far


# A photo of a phone can be viewed before anybody has measured anything: the ends of a room are
# assumed, and the user is asked for the true ones. A strict run assumes nothing.
def settle_ends(raw: RawDepth, options: PlateOptions, guess: Guess) -> tuple[PlateOptions, Guess]:
    """Return options with both ends of a disparity, assuming the usual ones if none are given.

    The guess then asks the user for the assumed ends, unless it asks for them already. Raises
    InputError in that case if the options are strict, because nothing may be assumed then.
    """
    options = replace(options, depth_convention=guess.convention)
    if options.near_m is not None and options.far_m is not None:
        return options, guess
    near = _USUAL_NEAR_M if options.near_m is None else options.near_m
    far = max(_USUAL_FAR_M, 2 * near) if options.far_m is None else options.far_m
    if options.near_m is None and far <= near:
        near = far / 10
    ends_question = (
        f"{raw.label} is not in metres: how far away are its nearest and its farthest point? Give "
        "--near and --far."
    )
    if options.strict:
        raise InputError(ends_question)
    question = (
        guess.question
        if "--near" in guess.question
        else f"{guess.question} {ends_question}".strip()
    )
    why = f"{guess.why} Its ends are taken as {near:g} m and {far:g} m."
    advice = f"{guess.advice} If {near:g} to {far:g} m is wrong: --near and --far.".lstrip()
    return replace(options, near_m=near, far_m=far), replace(
        guess, question=question, why=why, certain=False, advice=advice
    )
