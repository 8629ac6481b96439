"""`heatlens study`: show and measure every method on one frame, as one page."""

import argparse
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import extra
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import VIEWS_MAX, DefocusSettings, Method
from heatlens.core.model.units import format_distance
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.options.field_options import add_fields, settings_of
from heatlens.fronts.commands.options.frame_command import add_frame_options, choose_one_frame
from heatlens.fronts.commands.options.given_options import refuse_unused_options
from heatlens.fronts.commands.options.value_types import parse_positive, parse_whole_number
from heatlens.fronts.commands.output.picture_progress import view_progress
from heatlens.fronts.commands.output.pipes import stdin_as_file
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.fronts.commands.sources.source_commands import commands_for
from heatlens.lab.measure.compared_pictures import Picture, read_picture
from heatlens.lab.measure.metrics import flip_library
from heatlens.lab.measure.study import measured as references
from heatlens.lab.measure.study.folder import PAGE, check_target, report_folder, write_report
from heatlens.lab.measure.study.measured import Reference, Report, Subject, crop_color, measure_all
from heatlens.lab.measure.study.pictures import crop_boxes
from heatlens.render.frame_renderer import headless_renderer
from heatlens.render.source.named import has_camera

_TRUTH_VIEWS = 1024
_FINER = 4  # least views of the truth, as a multiple of the views of the methods

DESCRIPTION = f"""\
Blurs one frame with every method of heatlens and writes a folder with a page, index.html: each
method's picture, how far it is from the truth (PSNR, SSIM, FLIP) and where, its time on this
machine, and the places at which the methods differ most, side by side.

The truth is --truth, a finished picture of the same view. Without it, the truth of a
scene is the mean of --views views through the lens. The truth of a plate is unknown: its methods
are compared with diffusion at film quality, and the page says so. An earlier report is replaced.
Needs: {extra("study").install_command()}
"""
EPILOG = """\
examples:
  heatlens study plate.exr --truth lens.exr -o report --f-stop 2 --focus-distance 2.24 \\
      --focal-length 50 --sensor-width 36
  heatlens study plate.exr -o report --f-stop 1.4 --focus-at 960,540
  heatlens study plate.exr -o report --methods diffusion,gather,scatter --runs 1
  heatlens study scene.glb -o report --size 960x540 --f-stop 2 --focus-distance 3 --views 4096
  heatlens study demo -o report --frame 120
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    add_frame_options(parser, _add_study_options, _add_blur_options)


def _add_study_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FOLDER", help="folder of the report"
    )
    add_device_option(parser)
    group = parser.add_argument_group("what is compared")
    group.add_argument(
        "--truth", type=Path, metavar="TRUTH.exr", help="the picture that a perfect lens makes"
    )
    group.add_argument(
        "--views",
        dest="truth_views",
        type=parse_whole_number,
        metavar="N",
        help="for a scene without --truth: points of the lens for the truth "
        f"(default {_TRUTH_VIEWS}, {_FINER} times as many as the methods at least)",
    )
    group.add_argument(
        "--methods",
        type=_parse_methods,
        metavar="A,B",
        help="only these methods, of "
        + ", ".join(Method)
        + " (default: all that are possible for the source)",
    )
    group.add_argument(
        "--runs",
        type=_parse_count,
        default=3,
        metavar="N",
        help="frames for the median time, after a warm-up (default 3); fewer for slow methods",
    )
    group.add_argument(
        "--gain",
        type=parse_positive,
        default=4.0,
        metavar="G",
        help="factor by which differences are brightened (default 4)",
    )


def _add_blur_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of diffusion; the other methods have none."""
    group = parser.add_argument_group("blur of diffusion")
    add_fields(group, DefocusSettings, ["bokeh", "quality", "layers"])


def run(args: argparse.Namespace) -> int:
    """Check the request, then render, measure and write, and print messages."""
    with stdin_as_file(args.plate) as plate:
        args.plate = plate
        _study(args)
    print_result(str(args.output / PAGE))
    return 0


def _study(args: argparse.Namespace) -> None:
    """Render and measure every requested method, and write the report."""
    choose_one_frame(args)
    check_target(args.output)
    extra("study").check()
    flip_library()  # is imported now, so that a faulty one is reported before the renders
    truth = None if args.truth is None else read_picture(args.truth)
    subject = _subject(args)
    methods = _requested_methods(args, subject)
    reference = _reference(args, subject, truth)
    references.announce(reference, print_messages)
    report = _report(args, subject, methods, reference)
    with report_folder(args.output) as folder:
        write_report(folder, report, print_messages)


def _subject(args: argparse.Namespace) -> Subject:
    """Load plate or scene to the GPU, with the lens that the options describe."""
    settings = settings_of(args)
    refuse_unused_options(args, str(args.plate))
    _check_truth(args, settings.views)
    use_device(args)
    renderer = headless_renderer()
    shot, frame = commands_for(args.plate).load(args, renderer, settings)
    return Subject(args.plate.name, renderer, shot, frame)


def _check_truth(args: argparse.Namespace, method_views: int) -> None:
    """Refuse a truth of too few views, which would be as wrong as the methods are."""
    views, views_min = args.truth_views, _FINER * method_views
    if views is None:
        return
    if args.truth is not None or not has_camera(str(args.plate)):
        truth = "--truth is it" if args.truth is not None else f"{args.plate} is a plate"
        raise InputError(f"--views is for the truth of a 3D scene, and {truth}: leave it out.")
    if not views_min <= views <= VIEWS_MAX:
        raise InputError(
            f"--views must be {views_min} to {VIEWS_MAX}, got {views}: the methods use "
            f"{method_views} "
            f"points, and a truth needs {_FINER} times as many."
        )


def _requested_methods(args: argparse.Namespace, subject: Subject) -> tuple[Method, ...]:
    """Return the requested methods. Raises InputError for one that needs a scene."""
    if args.methods is None:
        return subject.methods
    missing = [method for method in args.methods if method not in subject.methods]
    if missing:
        raise InputError(
            f"{args.plate} is a plate: {missing[0]} needs a 3D scene. Leave it out of --methods."
        )
    return tuple(args.methods)


def _reference(args: argparse.Namespace, subject: Subject, truth: Picture | None) -> Reference:
    """Return the truth: the given picture or many views of the scene; else diffusion of a plate."""
    if truth is not None:
        return references.from_file(subject, truth)
    if not subject.renderer.has_many_views:
        return references.from_diffusion(subject)
    views = args.truth_views or _TRUTH_VIEWS
    print_messages(f"the truth, from {views} points of the lens")
    settings = references.truth_settings(subject, views)
    with view_progress(replace(subject.shot, defocus=settings)) as tell:
        return references.from_views(subject, views, tell)


def _report(
    args: argparse.Namespace, subject: Subject, methods: tuple[Method, ...], reference: Reference
) -> Report:
    """Render and measure all methods; return the results with all that the page shows."""
    results = measure_all(subject, methods, reference, args.runs, print_messages)
    pictures = [row.pixels for row in results.rows]
    return Report(
        title=subject.name,
        facts=_facts(subject, reference),
        reference=reference,
        sharp=crop_color(subject.plate.color, reference.region),
        rows=results.rows,
        left_out=results.left_out,
        crops=tuple(crop_boxes(pictures, reference.pixels)),
        gain=args.gain,
        machine=subject.machine,
    )


def _facts(subject: Subject, reference: Reference) -> tuple[tuple[str, str], ...]:
    """Return the facts that all pictures have in common, as (label, text)."""
    region = reference.region
    lens = "the plate brings its circle of confusion"
    if subject.plate.coc_px is None:
        lens = _lens_text(subject.shot.lens_at(subject.frame))
    frame = [("Frame", f"{subject.frame}")] if subject.renderer.has_many_views else []
    return (
        ("Lens", lens),
        ("Size", f"{region.width} × {region.height} pixels"),
        *frame,
        ("Truth" if reference.is_truth else "Held against", reference.name),
        ("Machine", subject.machine),
    )


def _lens_text(lens: Lens) -> str:
    squeeze = "" if lens.squeeze == 1 else f", squeeze {lens.squeeze:g}"
    return (
        f"{lens.focal_length_mm:g} mm, f/{lens.f_stop:g}, focus "
        f"{format_distance(lens.focus_distance_m)}, sensor {lens.sensor_width_mm:g} mm{squeeze}"
    )


def _parse_methods(text: str) -> list[Method]:
    """Parse names with commas between, each once.

    Argparse turns the error into its own sentence.
    """
    names = [name.strip() for name in text.split(",")]
    unknown = [name for name in names if name not in list(map(str, Method))]
    if unknown:
        raise argparse.ArgumentTypeError(
            f"{unknown[0]!r} is not a method. Methods: {', '.join(Method)}"
        )
    return [Method(name) for name in dict.fromkeys(names)]


def _parse_count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1")
    return int(text)
