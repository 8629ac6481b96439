"""`heatlens bench --methods SCENE`: the errors of every method over frames of a scene."""

import argparse
import json
from dataclasses import asdict, replace

from heatlens.base.errors import InputError
from heatlens.commands.options.given_options import given, refuse_given
from heatlens.commands.options.lens_options import add_lens_options
from heatlens.commands.options.scene_options import said_of_lens, shot_of_scene, with_framing
from heatlens.commands.output.paced_progress import paced_progress
from heatlens.commands.output.say import say
from heatlens.documents.shot_file import is_shot_file, read_shot
from heatlens.export.plan import frames_of
from heatlens.gpu.context import headless_context
from heatlens.measure.bench.frames import BenchFrames
from heatlens.measure.bench.method_errors import check_errors
from heatlens.measure.bench.pull_errors import measure_pull, pull_steps, pull_table
from heatlens.measure.study.subject import Subject
from heatlens.model.frames import check_within
from heatlens.model.framing import Framing
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.source.kinds import kind_of
from heatlens.source.named import source_of

_SIZE = (320, 180)
_FRAMES = 8


def add_scene_options(parser: argparse.ArgumentParser, group: "argparse._ArgumentGroup") -> None:
    """Add the scene to `parser`, and its frames to `group`."""
    parser.add_argument(
        "shown",
        nargs="?",
        metavar="SCENE",
        help="with --methods: measure the mean FLIP of every method over frames of this scene, or "
        "of the scene of a shot file, and print it as a row of the table in README; --truth-views "
        f"and --size (default {_SIZE[0]}x{_SIZE[1]}) are then those of its pictures",
    )
    group.add_argument(
        "--frames",
        metavar="RANGE",
        help=f"with SCENE: 1-48, 1-48x4, 1,9 (default: {_FRAMES} evenly from in to out)",
    )
    # What else tells how a scene is viewed comes with a shot file.
    others = ("scene_camera", "clip", "first_frame", "fps", "up_axis", "meters_per_unit")
    parser.set_defaults(**dict.fromkeys(others))


def run_scene(args: argparse.Namespace, settings: DefocusSettings) -> int:
    """Measure the methods on the scene. Raises InputError for what cannot end well."""
    _check(args)
    shot = replace(_shot(args), defocus=settings)
    framing = shot.framing or Framing()
    size = framing.width_px, framing.height_px
    check_errors(size, settings, args.truth_views)
    frames = _frames(args, shot)
    bench = BenchFrames(headless_context(), args.solver)
    bench.check_fits(size, settings)
    source_of(shot).loader(shot, (), bench.renderer)
    subject = Subject(args.shown, bench.renderer, shot, frames[0])
    with paced_progress(pull_steps(subject, frames, args.truth_views)) as tell_part:
        errors = measure_pull(subject, frames, args.truth_views, tell_part)
    whole = asdict(errors) | {"mean": errors.mean}
    print(json.dumps(whole, indent=2, allow_nan=False) if args.json else pull_table(errors))
    return 0


def _check(args: argparse.Namespace) -> None:
    """Refuse early what has no meaning for a scene."""
    if not args.methods:
        raise InputError(f"{args.shown}: only --methods measures a scene: give it too.")
    others = ("sweep_coc", "bare", "drag", "plate", "plot")
    refuse_given(args, others, f"The methods are compared on {args.shown}, not on a plate")


def _shot(args: argparse.Namespace) -> Shot:
    """Return the shot that is measured, in the size of the options."""
    args.size = args.size or (None if is_shot_file(args.shown) else _SIZE)
    if not is_shot_file(args.shown):
        _check_kind(args.shown)
        first = shot_of_scene(args, args.shown)
        say(*first.scene.notes, said_of_lens(args, first, first.frame))
        return first.shot
    own = given(args, add_lens_options)
    if own:
        raise InputError(f"{args.shown} defines the lens, so {', '.join(own)} cannot be given.")
    shot = with_framing(args, read_shot(args.shown))
    _check_kind(shot.source or args.shown)
    return shot


def _check_kind(source: str) -> None:
    if not kind_of(source).has_camera:
        raise InputError(
            f"{source} is {kind_of(source).article_word}, and the truth is seen from many points "
            "of the lens: give a 3D scene. `heatlens study --truth` takes a finished picture."
        )


def _frames(args: argparse.Namespace, shot: Shot) -> tuple[int, ...]:
    """Return the frames asked for, else some that are evenly spread."""
    source = source_of(shot)
    if args.frames is not None:
        frames = frames_of(shot, args.frames)
        check_within(source.span(shot), source.text, frames)
        return frames
    every = source.frames_of(shot)
    count = min(_FRAMES, len(every))
    return tuple(every[(2 * at + 1) * len(every) // (2 * count)] for at in range(count))
