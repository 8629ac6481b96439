"""The near and far end, in metres, of a depth that is only relative in its file."""

import math
from dataclasses import replace

from heatlens.base.errors import InputError
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.depth.depth_guess import Guess, RawDepth

# A portrait in a room, so that a photo can be looked at before anybody has measured anything.
_USUAL_NEAR_M, _USUAL_FAR_M = 1.0, 10.0


def checked_ends(raw: RawDepth, options: PlateOptions) -> tuple[float, float]:
    """Return near and far in metres. Raises InputError if they are missing or impossible.

    The far end of a disparity may be infinite; its near end cannot be 0.
    """
    near, far = options.near_m, options.far_m
    if near is None or far is None:
        raise InputError(
            f"{raw.what} is read as normalised: give the distances of its two ends in metres with "
            "--near and --far."
        )
    is_disparity = options.depth_convention.facts.is_disparity
    is_far_good = far < math.inf or is_disparity
    if not (0 <= near < far and is_far_good) or (is_disparity and near == 0):
        raise InputError(
            f"--near {near:g} and --far {far:g} cannot be the ends of a depth: both are metres, "
            f"near {'more than' if is_disparity else 'at least'} 0 and less than far. Which end of "
            "the values is near is said with --depth-convention."
        )
    return near, far


def with_ends(raw: RawDepth, options: PlateOptions, guess: Guess) -> tuple[PlateOptions, Guess]:
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
    asked = (
        f"{raw.what} says what is nearer, but not in metres: how far away are its nearest and its "
        "farthest point? Give --near and --far."
    )
    if options.strict:
        raise InputError(asked)
    question = guess.question if "--near" in guess.question else f"{guess.question} {asked}".strip()
    why = f"{guess.why} Its ends are taken as {near:g} m and {far:g} m."
    return replace(options, near_m=near, far_m=far), replace(
        guess, question=question, why=why, certain=False
    )
