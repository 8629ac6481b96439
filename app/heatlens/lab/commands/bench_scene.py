"""`heatlens bench` of a scene: the errors of every method over its frames; `--drag`."""

import argparse
import json
from dataclasses import asdict, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import extra
from heatlens.core.model.curves.frames import check_within
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import PROXY_MIN, DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.plan import frames_of
from heatlens.fronts.commands.options.given_options import changed_options, refuse_options
from heatlens.fronts.commands.options.lens_options import (
    add_lens_options,
    add_plate_options,
    lens_of,
    plate_options,
)
from heatlens.fronts.commands.options.scene_options import lens_message, shot_of_scene, with_framing
from heatlens.fronts.commands.output.plate_words import print_plate_notes
from heatlens.fronts.commands.output.progress_line import paced_progress
from heatlens.fronts.commands.output.say import print_messages
from heatlens.lab.measure.bench.drag import level_message
from heatlens.lab.measure.bench.method_errors import check_errors
from heatlens.lab.measure.bench.pull_errors import measure_pull, pull_steps, pull_table
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.lab.measure.study.measured import Subject
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from heatlens.render.gpu.context import headless_context
from heatlens.render.preview.level_choice import cheaper_levels
from heatlens.render.source.kinds import kind_of
from heatlens.render.source.named import source_of

_SIZE = (320, 180)
_FRAMES = 8
Size = tuple[int, int]
DragSubject = tuple[Plate, Lens, DefocusSettings]


def add_scene_options(parser: argparse.ArgumentParser, group: "argparse._ArgumentGroup") -> None:
    """Add the scene to `parser`, and its frames to `group`."""
    parser.add_argument(
        "shown",
        nargs="?",
        metavar="SCENE",
        help="with --methods: measure the mean FLIP of every method over frames of this scene, or "
        "of the scene of a shot file, and of flat plates of it, as in the table of README; "
        "--truth-views "
        f"and --size (default {_SIZE[0]}x{_SIZE[1]}) then apply to its pictures",
    )
    group.add_argument(
        "--frames",
        metavar="RANGE",
        help=f"with SCENE: 1-48, 1-48x4, 1,9 (default: {_FRAMES} evenly from in to out)",
    )
    # All other options of the view come from a shot file.
    unused_options = ("scene_camera", "clip", "first_frame", "fps", "up_axis", "meters_per_unit")
    parser.set_defaults(**dict.fromkeys(unused_options))


def run_scene(args: argparse.Namespace, settings: DefocusSettings) -> int:
    """Measure the methods on the scene. Raises InputError for impossible requests."""
    _check(args)
    shot = replace(_shot(args), defocus=settings)
    framing = shot.framing or Framing()
    size = framing.width_px, framing.height_px
    check_errors(size, settings, args.truth_views)
    frames = _frames(args, shot)
    bench = BenchFrames(headless_context(), args.solver)
    bench.check_fits(size, settings)
    source_of(shot).loader(shot, (), bench.renderer)
    subject = Subject(name=args.shown, renderer=bench.renderer, shot=shot, frame=frames[0])
    with paced_progress(pull_steps(subject, frames, args.truth_views)) as report_step:
        errors = measure_pull(subject, frames, args.truth_views, report_step)
    values = asdict(errors) | {"mean": errors.mean}
    print(json.dumps(values, indent=2, allow_nan=False) if args.json else pull_table(errors))
    return 0


def _check(args: argparse.Namespace) -> None:
    """Refuse options that have no meaning for a scene before measuring."""
    if not args.methods:
        raise InputError(f"{args.shown}: only --methods measures a scene: give it too.")
    options_for_plates = ("sweep_coc", "bare", "drag", "issues", "plate", "plot")
    refuse_options(
        args, options_for_plates, f"The methods are compared on {args.shown}, not on a plate"
    )


def _shot(args: argparse.Namespace) -> Shot:
    """Return the shot to measure; print how a scene was read, and set its size in `args`."""
    args.size = args.size or (None if is_shot_file(args.shown) else _SIZE)
    if not is_shot_file(args.shown):
        _check_kind(args.shown)
        scene_shot = shot_of_scene(args, args.shown)
        print_messages(*scene_shot.scene.notes, lens_message(args, scene_shot, scene_shot.frame))
        return scene_shot.shot
    lens_options = changed_options(args, add_lens_options)
    if lens_options:
        raise InputError(
            f"{args.shown} defines the lens, so {', '.join(lens_options)} cannot be given."
        )
    shot = with_framing(args, read_shot(args.shown))
    _check_kind(shot.source or args.shown)
    return shot


def _check_kind(source: str) -> None:
    """Raise InputError for a source that is not a 3D scene."""
    if not kind_of(source).has_camera:
        raise InputError(
            f"{source} is {kind_of(source).article_word}, but the truth needs views from many "
            "points of the lens: give a 3D scene. `heatlens study --truth` takes a finished "
            "picture."
        )


def _frames(args: argparse.Namespace, shot: Shot) -> tuple[int, ...]:
    """Return the requested frames, or else some that are evenly spaced."""
    source = source_of(shot)
    if args.frames is not None:
        frames = frames_of(shot, args.frames)
        check_within(source.span(shot), source.text, frames)
        return frames
    all_frames = source.frames_of(shot)
    count = min(_FRAMES, len(all_frames))
    return tuple(
        all_frames[(2 * index + 1) * len(all_frames) // (2 * count)] for index in range(count)
    )


def add_drag_options(parser: argparse.ArgumentParser, group: "argparse._ArgumentGroup") -> None:
    """Add --drag and --plate to `group`, and the options of the plate and its lens to `parser`."""
    group.add_argument(
        "--drag",
        action="store_true",
        help="instead of passes, measure what you see while dragging a control: for each preview "
        "level of the window, pictures per second and FLIP to the picture at rest, at 1:1; FLIP "
        f"needs {extra('compare').install_command()}",
    )
    group.add_argument(
        "--plate",
        type=Path,
        metavar="FILE",
        help="with --drag: an EXR with colour and depth instead of the generated scene; "
        "--size then scales it down (default: its own size)",
    )
    add_lens_options(parser)
    add_plate_options(parser)


def check_drag(args: argparse.Namespace) -> None:
    """Raise InputError for options that would have no effect."""
    if args.plate is None:
        names = changed_options(args, add_lens_options, add_plate_options)
        if names:
            raise InputError(f"{', '.join(names)} needs --plate: give both.")
    elif not args.drag:
        raise InputError("--plate is used only by --drag: give both.")


def load_drag_subject(
    args: argparse.Namespace, settings: DefocusSettings, default: Size
) -> DragSubject | None:
    """Return the plate, the lens and the settings at the requested size for --drag, else None.

    Raises HeatlensError if the plate cannot be read or is too small.
    """
    if not args.drag:
        return None
    if args.plate is None:
        return scene_plate(args.size or default), LENS, settings
    options = plate_options(args)
    plate = read_plate(args.plate, options)
    lens, lens_notes = lens_of(args, plate)
    print_plate_notes(plate, lens, lens_notes, options)
    return plate, lens, _with_size(plate, settings, args.size)


def _with_size(plate: Plate, settings: DefocusSettings, size: Size | None) -> DefocusSettings:
    """Return the settings with the proxy scale that gives the width of `size`."""
    if size is None:
        return settings
    full = plate.data_window.width, plate.data_window.height
    if size[0] > full[0] or size[1] > full[1]:
        raise InputError(
            f"--size {size[0]}x{size[1]} is larger than {plate.path.name}, which has "
            f"{full[0]}x{full[1]} pixels: a plate can only be made smaller."
        )
    return replace(settings, proxy=max(PROXY_MIN, settings.proxy * size[0] / full[0]))


def level_messages(subject: DragSubject) -> tuple[str, ...]:
    """Return the progress messages at the beginning of each level."""
    plate, _, settings = subject
    size = plate.data_window.width, plate.data_window.height
    return tuple(level_message(level, size) for level in cheaper_levels(settings))
