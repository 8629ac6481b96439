"""`heatlens compare`: measure how far a result is from its truth, and check it against limits."""

import argparse
import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

from heatlens.core.base.extras import extra
from heatlens.fronts.commands.options.value_types import parse_finite, parse_positive
from heatlens.fronts.commands.output.pipes import stdin_as_file
from heatlens.fronts.commands.output.say import print_messages
from heatlens.lab.measure.compared_pictures import (
    Picture,
    absolute_difference,
    check_is_png,
    flip_map,
    read_picture,
    shared_region,
    write_difference,
)
from heatlens.lab.measure.metrics import PSNR_MOST_DB, Scores, nonfinite_count, score
from heatlens.media.plate.plate import FloatImage

EXIT_NEAR_ENOUGH = 0
EXIT_TOO_FAR = 1

DESCRIPTION = f"""\
Measures how far RESULT is from TRUTH, two pictures of one frame, and prints:

  PSNR       in dB, higher is closer: 30 good, 40 hard to see, 99 identical
  SSIM       similarity of structure, 1 is identical
  FLIP       the difference that is visible when flipping between the two, 0 identical to 1 worst
  HDR-FLIP   the same over all exposures
  relMSE     relative squared error of the light, 0 is identical
  nonfinite  pixels of the result that hold NaN or infinity, counted as black

PSNR, SSIM and FLIP compare the sRGB pictures at exposure 0, HDR-FLIP and relMSE the linear light.
EXR is linear light; PNG, JPEG and TIFF are taken as sRGB, or as light if they are floating point.
If the data windows differ, the part of the display window that both files hold is compared.

Exit code: 0 within all given limits, 1 if a limit is missed, 2 for errors that you can fix.
Needs: {extra("compare").install_command()}
"""


@dataclasses.dataclass(frozen=True)
class _ScoreFormat:
    """How a score is shown: its field, label and number format."""

    field: str
    label: str
    form: str


_SCORES = (
    _ScoreFormat(field="psnr_db", label="PSNR", form="{:.3f} dB"),
    _ScoreFormat(field="ssim", label="SSIM", form="{:.5f}"),
    _ScoreFormat(field="flip", label="FLIP", form="{:.5f}"),
    _ScoreFormat(field="flip_hdr", label="HDR-FLIP", form="{:.5f}"),
    _ScoreFormat(field="relmse", label="relMSE", form="{:.6f}"),
    _ScoreFormat(field="nonfinite", label="nonfinite", form="{:d}"),
)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("result", type=Path, metavar="RESULT", help="the picture to measure")
    parser.add_argument("truth", type=Path, metavar="TRUTH", help="the reference picture")
    parser.add_argument("--json", action="store_true", help="print the scores as one JSON object")
    _add_limits(parser)
    _add_difference(parser)


def run(args: argparse.Namespace) -> int:
    """Compare two files; the exit code says whether all limits are met."""
    if args.difference is not None:
        check_is_png(args.difference)
    with stdin_as_file(args.result) as path:
        result_picture = read_picture(path)
    result, truth = _shared_pixels(result_picture, read_picture(args.truth))
    scores = score(result, truth)
    print(json.dumps(dataclasses.asdict(scores)) if args.json else _as_lines(scores))
    if args.difference is not None:
        error = _error_panel(args, result, truth)
        write_difference(args.difference, result, truth, error)
    missed = _missed_limits(args, scores)
    print_messages(*missed)
    return EXIT_TOO_FAR if missed else EXIT_NEAR_ENOUGH


def _add_limits(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("limits", "The exit code is 1 if a limit is missed.")
    group.add_argument(
        "--min-psnr", type=_within(0, PSNR_MOST_DB), metavar="DB", help="lowest PSNR allowed, in dB"
    )
    group.add_argument(
        "--min-ssim", type=_within(-1, 1), metavar="S", help="lowest SSIM allowed, up to 1"
    )
    group.add_argument(
        "--max-flip", type=_within(0, 1), metavar="F", help="highest FLIP allowed, 0 to 1"
    )


def _add_difference(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("difference")
    group.add_argument(
        "--difference",
        type=Path,
        metavar="FILE.png",
        help="write the result, the truth and their difference side by side",
    )
    group.add_argument(
        "--show",
        choices=("absolute", "flip"),
        default="absolute",
        help="the difference as brightness, or as FLIP from black to yellow (default absolute)",
    )
    group.add_argument(
        "--gain",
        type=parse_positive,
        default=4.0,
        metavar="G",
        help="factor by which the absolute difference is brightened (default 4)",
    )


def _within(low: float, high: float) -> Callable[[str], float]:
    """Return an argument type for limits within the range of a score."""

    def limit(text: str) -> float:
        """Return the number. Raises ArgumentTypeError outside the range."""
        value = parse_finite(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is not between {low:g} and {high:g}")
        return value

    return limit


def _shared_pixels(result: Picture, truth: Picture) -> tuple[FloatImage, FloatImage]:
    """Return the pixels that both files hold, (H, W, 3) each; print what is left out."""
    region = shared_region(result, truth)
    if region != result.data_window or region != truth.data_window:
        print_messages(
            f"the data windows differ: only the {region.width} x {region.height} pixels at "
            f"({region.x0}, {region.y0}) common to both files are compared"
        )
    pixels = result.crop(region), truth.crop(region)
    nonfinite = nonfinite_count(pixels[1])
    if nonfinite:
        print_messages(
            f"{truth.path}: {nonfinite} pixels of the truth hold NaN or infinity, counted as black"
        )
    return pixels


def _error_panel(args: argparse.Namespace, result: FloatImage, truth: FloatImage) -> FloatImage:
    """Return the picture of the difference that --show selects, display values (H, W, 3)."""
    if args.show == "flip":
        return flip_map(result, truth)
    return absolute_difference(result, truth, args.gain)


def _as_lines(scores: Scores) -> str:
    """Format the scores, one on each line, with aligned names and numbers."""
    width = max(len(entry.label) for entry in _SCORES)
    return "\n".join(
        f"{entry.label:<{width}}  {entry.form.format(getattr(scores, entry.field))}"
        for entry in _SCORES
    )


def _missed_limits(args: argparse.Namespace, scores: Scores) -> list[str]:
    """Return a sentence for each missed limit; a score that is NaN misses every limit."""
    missed = []
    if args.min_psnr is not None and not scores.psnr_db >= args.min_psnr:
        missed.append(f"PSNR {scores.psnr_db:.3f} dB is below the limit of {args.min_psnr:g} dB")
    if args.min_ssim is not None and not scores.ssim >= args.min_ssim:
        missed.append(f"SSIM {scores.ssim:.5f} is below the limit of {args.min_ssim:g}")
    if args.max_flip is not None and not scores.flip <= args.max_flip:
        missed.append(f"FLIP {scores.flip:.5f} is above the limit of {args.max_flip:g}")
    return missed
