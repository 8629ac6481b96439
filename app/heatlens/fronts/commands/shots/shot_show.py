"""`heatlens shot show`: print a shot file, including the lens at every frame."""

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import Lens, as_measured_m, measured_text
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.pull import frames_too_close
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.fronts.commands.output.say import print_result
from heatlens.media.documents.shot_file import read_shot, shot_to_json
from heatlens.media.files.json_record import to_json
from heatlens.media.sequence.names import frames_text

HELP = "print a shot file"
DESCRIPTION = """\
Prints a shot file: the plate, keys, marks and the lens at every frame, with the nearest and the
farthest depth that look sharp. The plate itself need not exist.
"""
_LABEL_WIDTH = 16

Row = Sequence[str]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shot", type=Path, metavar="SHOT.heatlens.json", help="the shot file")
    parser.add_argument("--json", action="store_true", help="the same as JSON, for programs")
    parser.add_argument(
        "--unit",
        choices=("m", "ft"),
        default="m",
        help="unit of distances in the text, metres or feet (default m)",
    )


def run(args: argparse.Namespace) -> int:
    """Print the shot."""
    shot = read_shot(args.shot)
    if args.json:
        print(json.dumps(_shot_facts(args.shot, shot), indent=2, allow_nan=False))
        return 0
    print_result("\n\n".join(_sections(shot, args.unit)), keep="\n")
    return 0


def _shot_facts(path: Path, shot: Shot) -> dict[str, object]:
    """Return the entries of the file, and the computed lens at each frame."""
    return {
        "path": str(path),
        **shot_to_json(shot, path.parent),
        "frames_too_close": list(frames_too_close(shot)),
        "lens_at": [
            {"frame": frame, **{name: to_json(value) for name, value in _lens_values(lens).items()}}
            for frame, lens in _lens_by_frame(shot)
        ],
    }


def _lens_by_frame(shot: Shot) -> list[tuple[int | None, Lens]]:
    """Return frame and lens for each frame of the shot; without frames, one lens with None."""
    if shot.span is None:
        return [(None, shot.lens)]
    return [(frame, shot.lens_at(frame)) for frame in shot.span]


def _lens_values(lens: Lens) -> dict[str, float]:
    """Return the animated values, and values computed from them."""
    return {
        **{str(parameter): getattr(lens, parameter) for parameter in LensParameter},
        "near_limit_m": near_limit_m(lens),
        "far_limit_m": far_limit_m(lens),
    }


def _sections(shot: Shot, unit: str) -> list[str]:
    """Return the sections of the printed text, without empty ones."""
    sections = [_constant_values_text(shot, unit)]
    keys = _key_rows(shot, unit)
    if keys:
        sections.append(_table_text(("keys", "frame", "value", "path"), keys))
    if shot.marks:
        distance = partial(measured_text, shot.lens, unit=unit)
        rows = [(mark.name, mark.location_words(distance)) for mark in shot.marks]
        sections.append(_table_text(("marks", "where"), rows))
    sections.append(
        _table_text(_LENS_HEAD, [_lens_row(f, lens, unit) for f, lens in _lens_by_frame(shot)])
    )
    return sections


def _blur_text(blur: DefocusSettings) -> str:
    """Describe the settings that have an effect: only diffusion uses all of them."""
    if blur.method is Method.DIFFUSION:
        return f"{blur.bokeh}, {blur.effective_quality}"
    return f"method {blur.method}"


def _framing_text(framing: Framing) -> str:
    """Describe the camera and the size of the picture."""
    size = f"{framing.width_px}x{framing.height_px}"
    if framing.track is not None:
        return f"{size}, through a camera of the shot's own, {len(framing.track.keys)} keys"
    return size if framing.camera is None else f"{size}, through camera {printable(framing.camera)}"


def _constant_values_text(shot: Shot, unit: str) -> str:
    """Return aligned lines on all values that are not animated."""
    lens, blur = shot.lens, shot.defocus
    lines = [
        ("plate", printable(shot.source or "none")),
        ("frames", f"{shot.span or 'not known'}, {shot.frames_per_second:g} per second"),
        ("blur", f"{_blur_text(blur)}, proxy {blur.proxy:g}"),
        ("sensor width", f"{lens.sensor_width_mm:g} mm"),
        ("lens model", f"{lens.model}: {lens.model.facts.meaning}"),
    ]
    if shot.framing is not None:
        lines.append(("scene seen", _framing_text(shot.framing)))
    if shot.curves.live is not None:
        lines.append(("focus follows", f"{printable(shot.curves.live.words)}, live"))
    for field in ("never_blur", "only_blur"):
        if thing := getattr(shot.plate_options, field):
            lines.append((options_of(PlateOptions)[field].words, printable(thing)))
    if shot.in_out is not None:
        lines.insert(2, ("in to out", str(shot.in_out)))
    lines += _optional_rows(shot, unit)
    return "\n".join(f"{label:<{_LABEL_WIDTH}}{value}" for label, value in lines)


def _optional_rows(shot: Shot, unit: str) -> Iterator[tuple[str, str]]:
    """Yield label and text of the values that many shots do not have."""
    lens = shot.lens
    if shot.start_timecode is not None:
        yield "timecode", f"{shot.start_timecode} at the first frame"
    if shot.grade is not None:
        yield "grade", f"{shot.grade} (slope, offset, power, saturation)"
    if lens.measuring_offset_m:
        yield "distances", f"from the {lens.measured_from.words}"
    if lens.close_focus_m is not None:
        close_frames = frames_too_close(shot)
        close_text = f"; nearer at frames {frames_text(close_frames)}" if close_frames else ""
        yield "close focus", measured_text(lens, lens.close_focus_m, unit) + close_text


def _key_rows(shot: Shot, unit: str) -> list[Row]:
    """Return a row of the table for each key: parameter, frame, value, interpolation."""
    return [
        (
            parameter.words,
            f"{key.frame:g}",
            _key_value_text(shot.lens, parameter, key.value, unit),
            key.interpolation,
        )
        for parameter in LensParameter
        for key in shot.curves.of(parameter).keys
    ]


_LENS_HEAD = ("frame", "focus", "f-stop", "focal length", "squeeze", "sharp from", "to")


def _lens_row(frame: int | None, lens: Lens, unit: str) -> Row:
    """Return a row: frame, focus, f-stop, focal length, squeeze, and the sharp range."""
    return (
        "any" if frame is None else str(frame),
        _distance_text(as_measured_m(lens, lens.focus_distance_m), unit),
        f"f/{lens.f_stop:.4g}",
        f"{lens.focal_length_mm:.4g} mm",
        f"{lens.squeeze:.4g}",
        _distance_text(as_measured_m(lens, near_limit_m(lens)), unit),
        _distance_text(as_measured_m(lens, far_limit_m(lens)), unit),
    )


def _distance_text(distance_m: float, unit: str) -> str:
    """Format a distance for a column: to the millimeter, with aligned points."""
    if unit == "m" and math.isfinite(distance_m):
        return f"{distance_m:.3f} m"
    return format_distance(distance_m, unit)


def _key_value_text(lens: Lens, parameter: LensParameter, value: float, unit: str) -> str:
    """Format the value of a key with its unit."""
    if parameter is LensParameter.FOCUS_DISTANCE:
        return measured_text(lens, value, unit)
    return parameter.format_value(value, unit, ".4g")


def _table_text(head: Row, rows: Sequence[Row]) -> str:
    """Format columns as wide as their widest cell, aligned to the right."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    return "\n".join(
        "  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True))
        for row in (head, *rows)
    )
