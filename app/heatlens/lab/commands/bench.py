"""`heatlens bench`: measure how long a frame takes on this machine, and which pass takes it."""

import argparse
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import extra
from heatlens.core.base.memory import peak_bytes
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.options.field_options import add_blur_options, settings_of
from heatlens.fronts.commands.options.given_options import refuse_options, refuse_unused_options
from heatlens.fronts.commands.options.scene_options import parse_size
from heatlens.fronts.commands.options.value_types import parse_whole_number
from heatlens.fronts.commands.output.progress_line import paced_progress
from heatlens.fronts.commands.output.say import print_messages
from heatlens.lab.commands.bench_scene import (
    DragSubject,
    add_drag_options,
    add_scene_options,
    check_drag,
    level_messages,
    load_drag_subject,
    run_scene,
)
from heatlens.lab.measure.bench.drag import measure_drag
from heatlens.lab.measure.bench.issues import issue_lines, measure_issues
from heatlens.lab.measure.bench.measure import (
    measure_bare,
    measure_coc_sweep,
    measure_frame,
    measure_size_sweep,
)
from heatlens.lab.measure.bench.method_errors import ErrorReport, check_errors, measure_errors
from heatlens.lab.measure.bench.methods import measure_methods
from heatlens.lab.measure.bench.plot_panels import check_plot, write_plot
from heatlens.lab.measure.bench.report import BenchReport, report_text
from heatlens.lab.measure.bench.schedule import RequestedBench, plan_steps, probe_seconds_per_px
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.render.defocus.line_solver import SOLVERS, SolverName
from heatlens.render.gpu.context import check_plate_fits, headless_context

_SIZE = (1920, 1080)
_TRUTH_VIEWS = 1024
_TRUTH_SIZE = (480, 270)

DESCRIPTION = """\
Renders a generated scene repeatedly and prints for each pass the milliseconds, the bytes that it
moves and the least that it could move, and how close it comes to the speed of a plain copy.
With --issues: how many requests OpenGL gets for a frame, which is what limits a fast GPU.
With --drag: how fast and how good the pictures are that the window shows while you drag a control.
The time left is estimated before and during the measurement.
"""
EPILOG = """\
examples:
  heatlens bench
  heatlens bench --bokeh heat --layers 1 --bare
  heatlens bench --quality draft --runs 3 --sweep-coc
  heatlens bench --size 960x540 --methods --plot methods.svg
  heatlens bench --size 960x540 --methods --truth-views 0    # only times
  heatlens bench --size 960x540 --methods --truth-size 960x540 --truth-views 4096 --json
  heatlens bench --methods demo --frames 60-88x9,150-184x11
  heatlens bench --solver partition --json > partition.json
  heatlens bench --issues --size 3840x2160    # needs no GPU
  heatlens bench --drag --size 1280x720
  heatlens bench --drag --plate plate.exr --focus-distance 1.2 --f-stop 1.4 --json
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--size",
        type=parse_size,
        metavar="WxH",
        help=f"pixels across and down (default {_SIZE[0]}x{_SIZE[1]})",
    )
    add_device_option(parser)
    add_blur_options(parser)
    _add_measure_options(parser)


def _add_measure_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is measured")
    group.add_argument(
        "--solver",
        choices=("auto", *map(str, SOLVERS)),
        default="auto",
        help="how the lines are solved: sweep suits CPUs, partition suits GPUs; auto "
        "(default) is what `render` uses on this machine",
    )
    group.add_argument(
        "--runs",
        type=parse_whole_number,
        default=5,
        metavar="N",
        help="number of frames for each median, after a warm-up (default 5)",
    )
    group.add_argument(
        "--sweep-coc",
        action="store_true",
        help="also measure the time of a frame against its circle of confusion, 2 to 200 px, and "
        "against its size, 960x540 to 3840x2160; takes minutes on a software rasteriser",
    )
    group.add_argument(
        "--bare",
        action="store_true",
        help="also measure one layer of heat, and the two bare line sweeps that it needs at least",
    )
    group.add_argument(
        "--issues",
        action="store_true",
        help="only count the dispatches, draws, barriers and uniforms of a frame as a GPU gets "
        "them, time Python, and predict the frame on two GPUs; nothing is drawn",
    )
    add_drag_options(parser, group)
    add_scene_options(parser, group)
    _add_method_options(group)
    group.add_argument(
        "--json", action="store_true", help="print one JSON object instead of tables"
    )


def _add_method_options(group: "argparse._ArgumentGroup") -> None:
    """Add the options that compare every method: its cost and its error."""
    group.add_argument(
        "--methods",
        action="store_true",
        help="also measure every method of --method for circles of confusion of 2 to 200 px: the "
        "time of a frame of a plate at --size, then its error to the truth. A method is skipped "
        "once it takes too long",
    )
    group.add_argument(
        "--truth-views",
        type=parse_whole_number,
        default=_TRUTH_VIEWS,
        metavar="N",
        help="with --methods: FLIP, PSNR and SSIM of each method against the mean of this many "
        f"views of a scene with lamps (default {_TRUTH_VIEWS}; 0: only times); needs "
        f"{extra('compare').install_command()}",
    )
    group.add_argument(
        "--truth-size",
        type=parse_size,
        default=_TRUTH_SIZE,
        metavar="WxH",
        help=f"pixels of that scene (default {_TRUTH_SIZE[0]}x{_TRUTH_SIZE[1]})",
    )
    group.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="with --methods: draw time and error against the blur, and error against time, to a "
        ".png or .svg; the dotted line grows with the area of the disc; needs "
        f"{extra('plot').install_command()}",
    )


def run(args: argparse.Namespace) -> int:
    """Run the requested measurements; progress goes to stderr, results to stdout."""
    use_device(args)
    settings = settings_of(args)
    if not args.methods:  # else every method is measured with its own options
        refuse_unused_options(args, method=settings.method)
    if args.runs < 1:
        raise InputError(f"--runs must be at least 1, got {args.runs}.")
    if args.shown is not None:
        return run_scene(args, settings)
    if args.frames is not None:
        raise InputError("--frames needs a scene, as in bench --methods demo.")
    if args.issues:
        return _count_issues(args, settings)
    _check_methods(args, settings)
    check_drag(args)
    frames = BenchFrames(headless_context(), args.solver)
    report = _run_measurements(args, frames, settings)
    if args.plot is not None and report.methods is not None:
        renderer = frames.ctx.name
        write_plot(args.plot, report.methods, report.method_errors, renderer)
        print_messages(f"drawn to {args.plot}")
    if args.json:
        print(json.dumps(asdict(report), indent=2, allow_nan=False))
    else:
        print(report_text(report))
    return 0


def _count_issues(args: argparse.Namespace, settings: DefocusSettings) -> int:
    """Print the calls of a frame on a GPU. Raises InputError for options of other measurements."""
    excluded_options = ["sweep_coc", "bare", "drag", "methods", "plate", "plot"]
    excluded_options += [] if args.solver in ("auto", SolverName.PARTITION) else ["solver"]
    refuse_options(args, excluded_options, "--issues only counts a frame of a GPU")
    ctx, size = headless_context(), args.size or _SIZE
    check_plate_fits(ctx, *size)
    report = measure_issues(ctx, size, settings, args.runs, print_messages)
    if args.json:
        print(json.dumps(asdict(report), indent=2, allow_nan=False))
    else:
        print(issue_lines(report))
    return 0


def _check_methods(args: argparse.Namespace, settings: DefocusSettings) -> None:
    """Check the requirements of --methods before measuring for minutes."""
    if args.plot is not None:
        if not args.methods:
            raise InputError("--plot draws the results of --methods: give both.")
        check_plot(args.plot)
    if args.methods and args.truth_views != 0:
        check_errors(args.truth_size, settings, args.truth_views)


def _run_measurements(
    args: argparse.Namespace, frames: BenchFrames, settings: DefocusSettings
) -> BenchReport:
    """Run the requested measurements, and show the estimated time before and meanwhile."""
    frames.check_fits(args.size or _SIZE, settings)
    print_messages("finding out how long this takes")
    drag = load_drag_subject(args, settings, _SIZE)
    requested = _requested_bench(args, settings if drag is None else drag[2], drag)
    with paced_progress(
        plan_steps(requested, probe_seconds_per_px(frames, settings))
    ) as report_progress:
        return _report(args, frames, requested, drag, report_progress)


def _requested_bench(
    args: argparse.Namespace, settings: DefocusSettings, drag: DragSubject | None
) -> RequestedBench:
    """Return the measurements that the options request."""
    size = args.size or _SIZE
    if drag is not None:
        size = drag[0].data_window.width, drag[0].data_window.height
    return RequestedBench(
        size,
        settings,
        args.runs,
        frame=drag is None,
        bare=args.bare,
        sweeps=args.sweep_coc,
        methods=args.methods,
        truth_size=args.truth_size,
        truth_views=args.truth_views,
        levels=() if drag is None else level_messages(drag),
    )


def _report(
    args: argparse.Namespace,
    frames: BenchFrames,
    requested: RequestedBench,
    drag: DragSubject | None,
    report_progress: Callable[[str], None],
) -> BenchReport:
    """Run the measurements in the order of the plan."""
    size, settings, runs = requested.size, requested.settings, requested.runs
    coc_sweep = size_sweep = None
    # The bare sweeps come first, because they fail at once if the picture is too large for them.
    bare = measure_bare(frames, size, runs, report_progress) if requested.bare else None
    frame = (
        measure_frame(frames, size, settings, runs, report_progress) if requested.frame else None
    )
    if requested.sweeps:
        coc_sweep = measure_coc_sweep(frames, size, settings, runs, report_progress)
        size_sweep = measure_size_sweep(frames, settings, runs, report_progress)
    methods = (
        measure_methods(frames, size, settings, runs, report_progress)
        if requested.methods
        else None
    )
    errors = _errors(args, frames, settings, report_progress)
    levels = None if drag is None else measure_drag(frames, *drag, runs, report_progress)
    memory = peak_bytes() / 1e6
    return BenchReport(frame, coc_sweep, size_sweep, bare, memory, methods, errors, levels)


def _errors(
    args: argparse.Namespace,
    frames: BenchFrames,
    settings: DefocusSettings,
    report_progress: Callable[[str], None],
) -> ErrorReport | None:
    """Measure the errors, or return None if they were not requested."""
    if not args.methods or args.truth_views == 0:
        return None
    return measure_errors(
        frames, args.truth_size, settings, args.truth_views, args.runs, report_progress
    )
