"""Guess which convention a depth channel follows from its name and values.

If the values fit several conventions equally well, no guess is made and an error asks the user: a
wrong guess would blur the wrong things and look almost right. If one convention is more likely, it
is used, and a question is shown to the user.
"""

from dataclasses import dataclass

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.depth_shape import FlatVotes, count_flat_votes
from heatlens.media.plate.depth.raw_depth import RawDepth
from heatlens.media.plate.header.entries import PictureFacts

# Filtering takes a normalized depth a little past its ends.
NORMALIZED_UP_TO = 1.5

# A greater 1/z would be nearer than 5 cm, if the unit is meters; in smaller units 1/z is smaller.
INVERSE_MOST = 20.0
# If the least 1/z of a picture were greater, everything in it would be nearer than one unit.
INVERSE_LOW_MOST = 1.0
# The distances of a whole picture seldom are all below _NEAR_TOP, reach below _NEAR_LOW, and have a
# median below _DENSE_PART of the greatest.
_NEAR_TOP, _NEAR_LOW, _DENSE_PART = 4.0, 0.5, 0.25


@dataclass(frozen=True)
class Guess:
    """A convention with the reason for it, and what to show to the user.

    why       one sentence
    certain   False if a note has to tell the user about the guess
    question  asks the user to choose, and names the options, where another convention fits nearly
              as well; else ""
    advice    what to say if the guess is wrong, in sentences; "" for --depth-convention alone
    """

    convention: DepthConvention  # never AUTO
    why: str
    certain: bool = True
    question: str = ""
    advice: str = ""


def guess_convention(raw: RawDepth, options: PlateOptions) -> Guess:
    """Guess the convention of `raw`, with the reason.

    Raises InputError if its values fit several conventions, naming the options that decide, and if
    only one of --near and --far is given with distances.
    """
    guess = _guess_from_evidence(raw, options)
    ends = {"--near": options.near_m, "--far": options.far_m}
    given_ends = [name for name, value in ends.items() if value is not None]
    if guess.convention is DepthConvention.DISTANCE and len(given_ends) == 1:
        raise InputError(
            f"{raw.label} is read as distances, but {given_ends[0]} is for a normalized depth: "
            f"leave {given_ends[0]} out, or give --depth-convention."
        )
    return guess


def _guess_from_evidence(raw: RawDepth, options: PlateOptions) -> Guess:
    """Guess the convention from the options, the kind of file, the channel's name or the values."""
    if options.depth_convention is not DepthConvention.AUTO:
        return Guess(options.depth_convention, "Given with --depth-convention.")
    if raw.origin.facts is not None:
        return guess_picture_convention(raw, raw.origin.facts, options)
    name_guess = _guess_by_name(raw.channel)
    if name_guess:
        return name_guess
    if raw.infinite_count == raw.values.size:
        return Guess(
            DepthConvention.DISTANCE,
            "Every pixel holds a value that means infinity, as only distances do.",
        )
    has_ends = options.near_m is not None and options.far_m is not None
    if has_ends and raw.greatest_magnitude <= NORMALIZED_UP_TO:
        return _guess_normalized_direction(raw)
    if raw.greatest_magnitude > 1:
        return _guess_beyond_one(raw, has_ends)
    return _guess_within_one(raw)


# The strongest evidence is tested first: a mark of infinity, which occurs only among distances,
# then the flat surfaces, then the program that wrote the file, and last the range. A 1/z above 20
# would be nearer than 5 cm in meters, but networks write disparity in a scale of their own. So
# above 20 the flat surfaces can still lead to a question.
def _guess_beyond_one(raw: RawDepth, has_ends: bool) -> Guess:
    """Guess distances, unless the surfaces or the program say that these values are 1/z."""
    beyond = "above 1" if raw.high > 1 else "below -1"
    why = f"Its values run from {raw.low:.3g} to {raw.high:.3g}, {beyond}, so they are distances."
    if has_ends:
        return Guess(
            DepthConvention.DISTANCE, why, certain=False, advice="--near and --far are not used."
        )
    if raw.infinite_count:
        return Guess(DepthConvention.DISTANCE, why)
    votes = count_flat_votes(raw.values, raw.infinite)
    if raw.greatest_magnitude > INVERSE_MOST:
        return (
            _guess_distance_but_ask(raw, why)
            if votes.says_inverse
            else Guess(DepthConvention.DISTANCE, why)
        )
    if votes.says_distance:
        return Guess(DepthConvention.DISTANCE, f"{why} Its flat surfaces vary as distances do.")
    if votes.says_inverse and raw.least_magnitude <= INVERSE_LOW_MOST:
        return _guess_inverse_by_surfaces(raw, votes)
    if votes.says_inverse:
        return _guess_distance_but_ask(raw, why)
    if _is_nuke_depth(raw):
        return _guess_and_ask(
            raw,
            DepthConvention.INVERSE,
            f"Nuke wrote the file, and its {raw.channel} is 1/z; no flat surface confirms it.",
        )
    if _is_dense_near_zero(raw):
        return _guess_and_ask(
            raw, DepthConvention.DISTANCE, f"{why} But most of them are near zero, as those of 1/z."
        )
    return Guess(DepthConvention.DISTANCE, why)


def _guess_distance_but_ask(raw: RawDepth, why: str) -> Guess:
    """Guess distances, and ask the user whether the values are disparity.

    Networks write disparity in a scale of their own.
    """
    question = (
        f"{raw.label} runs from {raw.low:g} to {raw.high:g}, and its flat surfaces vary as "
        "disparity does: are these distances? Give --depth-convention distance, or "
        "--depth-convention disparity with --near and --far."
    )
    advice = _if_wrong("disparity with --near and --far")
    return Guess(DepthConvention.DISTANCE, why, False, question, advice)


def _if_wrong(convention: str) -> str:
    """Return what to say if a picture shows that the guess is wrong."""
    return f"If the wrong things are sharp: --depth-convention {convention}."


def _guess_inverse_by_surfaces(raw: RawDepth, votes: FlatVotes) -> Guess:
    """Guess 1/z from the flat surfaces; ask the user unless the program writes 1/z as well."""
    why = (
        f"Its flat surfaces vary as 1/z does, in {votes.inverse} places against {votes.distance} "
        "that vary as distances do"
    )
    if _is_nuke_depth(raw):
        return Guess(DepthConvention.INVERSE, f"{why}, and Nuke wrote the file.", certain=False)
    return _guess_and_ask(raw, DepthConvention.INVERSE, f"{why}.")


def _is_nuke_depth(raw: RawDepth) -> bool:
    """Return True for the layer depth.Z of Nuke's own renderer, which holds 1/z."""
    return raw.origin.program == "Nuke" and raw.channel.lower() == "depth.z"


def _is_dense_near_zero(raw: RawDepth) -> bool:
    """Return True if most values are much smaller than the greatest, which is small itself.

    Such values are 1/z of a scene, or distances on a table.
    """
    if raw.greatest_magnitude > _NEAR_TOP or raw.least_magnitude > _NEAR_LOW:
        return False
    magnitude = np.abs(raw.values[~raw.infinite & np.isfinite(raw.values)])
    return bool(np.median(magnitude) < _DENSE_PART * raw.greatest_magnitude)


def _guess_and_ask(raw: RawDepth, likelier_convention: DepthConvention, why: str) -> Guess:
    """Guess the likelier of distance and 1/z, and ask the user which of the two is right."""
    question = (
        f"{raw.label} runs from {raw.low:g} to {raw.high:g}: are these distances, or 1/z? Give "
        "--depth-convention distance or --depth-convention inverse."
    )
    is_distance = likelier_convention is DepthConvention.DISTANCE
    advice = _if_wrong("inverse" if is_distance else "distance")
    return Guess(likelier_convention, why, False, question, advice)


def _guess_by_name(channel: str) -> Guess | None:
    """Guess from the channel's name; return None if it gives no hint."""
    name = channel.lower()
    if "coc" in name or "circleofconfusion" in name:
        return Guess(DepthConvention.COC, "Its name says circle of confusion.")
    if "dispar" in name or "inverse" in name or "invz" in name:
        return Guess(DepthConvention.INVERSE, "Its name says that it holds 1/z.")
    return None


def _guess_normalized_direction(raw: RawDepth) -> Guess:
    """Guess which end of a 0..1 depth is far: the one at which more pixels lie."""
    ones = int(np.count_nonzero((raw.values >= 1) & ~raw.infinite))
    zeros = int(np.count_nonzero((raw.values <= 0) & ~raw.infinite))
    inverted, upright = DepthConvention.NORMALIZED_INVERTED, DepthConvention.NORMALIZED
    convention = inverted if zeros > ones else upright
    far = "0, black" if zeros > ones else "1, white"
    return Guess(
        convention,
        f"--near and --far are given and its values lie in 0 to 1; {zeros} pixels are 0 and {ones} "
        f"are 1, so {far}, is taken as far.",
        certain=False,
        advice=_if_wrong(str(upright if zeros > ones else inverted)),
    )


def _guess_within_one(raw: RawDepth) -> Guess:
    """Guess the convention of values whose magnitude is at most 1, or raise InputError."""
    span = f"{raw.low:g} to {raw.high:g}"
    if raw.infinite_count:
        return Guess(
            DepthConvention.DISTANCE,
            f"It holds values that mean infinity besides {span}, as distances do.",
        )
    if raw.low == raw.high:
        return Guess(
            DepthConvention.DISTANCE, f"It is {raw.low:g} everywhere: taken as a distance."
        )
    votes = count_flat_votes(raw.values, raw.infinite)
    if votes.says_inverse and _is_nuke_depth(raw):
        return _guess_inverse_by_surfaces(raw, votes)
    if raw.zero_count and raw.greatest_magnitude < 1 and not votes.says_distance:
        return Guess(
            DepthConvention.INVERSE,
            f"It is 0 in {raw.zero_count} pixels and up to {raw.high:g} elsewhere, as 1/z with 0 "
            "at infinity.",
            certain=False,
        )
    raise InputError(
        f"{raw.label} holds only values from {span}, which may be a normalised depth, distances or "
        "1/z. Say which: --depth-convention normalized or normalized-inverted (1 near) with --near "
        "and --far in metres, or --depth-convention distance or inverse."
    )


def guess_picture_convention(raw: RawDepth, facts: PictureFacts, options: PlateOptions) -> Guess:
    """Guess the convention of a depth in a PNG, JPEG, TIFF, PFM or HEIC, which rarely states it."""
    if facts.convention is not None:
        return Guess(facts.convention, facts.why, certain=False)
    if options.scene_unit_m != 1.0:
        return Guess(
            DepthConvention.DISTANCE, "A unit is given with --scene-unit, as distances have."
        )
    votes = count_flat_votes(raw.values, raw.infinite, 1.0 if facts.full_scale else 0.0)
    span = f"{raw.low:g} to {raw.high:g}"
    if facts.full_scale is None and not votes.says_inverse:
        why = f"Floating point from {span}"
        question = _question_of_picture(raw, span)
        if votes.says_distance:
            return Guess(
                DepthConvention.DISTANCE,
                f"{why}, whose flat surfaces run as distances do.",
                certain=False,
            )
        return Guess(
            DepthConvention.DISTANCE,
            f"{why}, as programs write distances.",
            certain=False,
            question=question,
            advice=_if_wrong("disparity"),
        )
    if votes.says_inverse:
        why = (
            f"Its flat surfaces run evenly over 1/z in {votes.inverse} places, which does not tell "
            "whether white or black is near; phones and networks write white near."
        )
        advice = _if_wrong("disparity-inverted")
        return Guess(DepthConvention.DISPARITY, why, False, _question_of_direction(raw), advice)
    why = "Phones and networks that estimate depth write disparity, with white near."
    advice = _if_wrong("disparity-inverted, normalized or distance")
    return Guess(DepthConvention.DISPARITY, why, False, _question_of_picture(raw, span), advice)


def _question_of_direction(raw: RawDepth) -> str:
    """Return a question to the user: which end of a disparity is near?"""
    return (
        f"{raw.label} is disparity, but is white near in it, or black? Say --depth-convention "
        "disparity, or disparity-inverted where black is near."
    )


def _question_of_picture(raw: RawDepth, span: str) -> str:
    """Return a question to the user: what is the convention of the depth in a picture file?"""
    return (
        f"{raw.label} runs from {span}: is it disparity, a depth of 0 to 1, or distances? Say "
        "--depth-convention disparity or disparity-inverted (black near), normalized or "
        "normalized-inverted (white near), each with --near and --far, or distance with "
        "--scene-unit."
    )
