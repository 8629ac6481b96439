"""The options of `heatlens export`, and the export job for them."""

import argparse
import os
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import check_within
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import Guides
from heatlens.deliver.export.burn_in import checked_template
from heatlens.deliver.export.job import DisplayLook, ExportJob, blur_of_export
from heatlens.deliver.export.options import (
    EXR,
    FRAMES,
    LOOK,
    USUAL_COMPRESSION,
    ExportOptions,
    of_group,
)
from heatlens.deliver.export.output import Output, parse_output
from heatlens.deliver.export.plan import frames_of
from heatlens.fronts.commands.options.display_options import (
    add_display_options,
    display_look,
    shot_header,
)
from heatlens.fronts.commands.options.farm_options import add_farm_options
from heatlens.fronts.commands.options.field_options import (
    add_blur_options,
    add_fields,
    settings_of,
    typed_fields,
)
from heatlens.fronts.commands.options.given_options import given, refuse_given, refuse_unused
from heatlens.fronts.commands.options.lens_options import add_lens_options, add_plate_options
from heatlens.fronts.commands.options.one_of_many import frame_among, say_one_is_meant
from heatlens.fronts.commands.options.pinhole_output import (
    add_pinhole_options,
    check_pinhole_options,
    kept_names,
    pinhole_options,
)
from heatlens.fronts.commands.options.scene_options import (
    add_framing_options,
    with_framing,
)
from heatlens.fronts.commands.shots.following import measured_now
from heatlens.fronts.commands.sources.source_commands import commands_for
from heatlens.media.documents.frame_line_file import read_canvases
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.sequence.names import frames_text, parse_frames
from heatlens.render.source.named import source_of


def add_export_options(parser: argparse.ArgumentParser) -> None:
    """Add every option but the shot and the output."""
    _add_frame_options(parser)
    _add_exr_options(parser)
    _add_display_options(parser)
    add_blur_options(parser)
    add_lens_options(parser)
    add_plate_options(parser)
    _add_scene_options(parser)
    add_farm_options(parser)


def _add_frame_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("frames")
    add_fields(group, ExportOptions, of_group(FRAMES))
    group.add_argument(
        "--plate", metavar="FILES", help="plate to use instead of the one in the shot"
    )
    group.add_argument(
        "--progress",
        choices=("terminal", "json", "openjd"),
        default="terminal",
        help="terminal: a progress line on stderr if it is a terminal (default); json: one line "
        "on stdout for each frame, then a last one with the event end, or failed with a "
        "message. An export that is stopped or crashes writes no last line and exits with "
        "130 (Ctrl-C), 143 (SIGTERM) or 70; openjd: for a render farm",
    )


def _add_scene_options(parser: argparse.ArgumentParser) -> None:
    add_framing_options(parser, has_rate=True)
    add_pinhole_options(parser)


def _add_exr_options(parser: argparse.ArgumentParser) -> None:
    add_fields(parser.add_argument_group("EXR"), ExportOptions, of_group(EXR))


def _add_display_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of display pictures, and those of the guides drawn over them."""
    group = add_display_options(parser)
    add_fields(group, ExportOptions, of_group(LOOK))
    add_fields(group, Guides)
    group.add_argument(
        "--framing",
        type=Path,
        metavar="FILE.fdl",
        help="draw the frames of a framing decision list (ASC FDL), and corners around what they "
        "protect",
    )


def job_of(args: argparse.Namespace) -> ExportJob:
    """Return the export job of the options.

    Raises InputError if they contradict the shot or each other.
    """
    output = parse_output(args.output)
    _check_kind(args, output)
    read = _shot_in_file(args) if is_shot_file(args.shot) else None
    check_pinhole_options(args, output.is_exr, read is not None, usual=USUAL_COMPRESSION)
    _refuse_unused(args, read)
    shot = _with_overrides(args, read or _shot_of_options(args))
    frames = _frames(args, shot)
    shot = measured_now(_started(args, shot))
    options = ExportOptions(**typed_fields(args, ExportOptions))
    if args.pinhole:
        options = replace(options, with_depth=True)
    checked_template(options.burn_in_text)
    if options.burn_in and not options.shot_name and _is_typed(args) and read is not None:
        options = replace(options, shot_name=Path(args.shot).name.split(".")[0])
    look, keep = _look(args, shot), _kept_names(args, shot)
    beside = pinhole_options(args)
    return ExportJob(shot, frames, output, options, look, keep, args.pinhole, beside)


def part_of(args: argparse.Namespace, job: ExportJob) -> tuple[int, ...] | None:
    """Return the frames of --part; None for all. Raises InputError for frames not in the job."""
    if args.part is None:
        return None
    part = parse_frames(args.part)
    others = set(part).difference(job.frames)
    if others:
        raise InputError(f"--part: frames {frames_text(sorted(others))} are not in this export.")
    return part


def _is_typed(args: argparse.Namespace) -> bool:
    """Return False if the options come from the window."""
    return getattr(args, "job", None) is None


def _kept_names(args: argparse.Namespace, shot: Shot) -> tuple[str, ...]:
    """Return the channels to keep, checked in the first plate; the others are assumed equal."""
    if not args.keep_channels:
        return ()
    return kept_names(args, source_of(shot), shot.plate_options, shot.defocus.proxy)


def _check_kind(args: argparse.Namespace, output: Output) -> None:
    """Refuse options that the kind of output file does not support, instead of ignoring them."""
    wrong = given(args, _add_display_options if output.is_exr else _add_exr_options)
    if wrong and output.is_exr:
        raise InputError(
            f"{', '.join(wrong)}: EXR frames stay scene-linear and clean for further work. Export "
            "PNG, JPEG or a movie in addition."
        )
    if wrong:
        raise InputError(f"{', '.join(wrong)}: these options are only for EXR.")
    _check_together(args, output)


def _check_together(args: argparse.Namespace, output: Output) -> None:
    """Refuse options that do nothing without another one."""
    if args.matte_opacity is not None and args.matte is None:
        raise InputError("--matte-opacity needs --matte: give both.")
    has_place = output.is_exr or output.is_movie or args.burn_in
    if args.start_timecode is not None and not has_place:
        raise InputError(
            f"--start-timecode: {output.suffix} cannot hold a timecode except in the picture. "
            "Give --burn-in too."
        )
    if args.burn_in:
        return
    if (args.burn_in_text or args.shot_name) and _is_typed(args):
        raise InputError("--burn-in-text and --shot-name are for --burn-in: give both.")
    if args.unit is not None:
        raise InputError("--unit is the unit of the distance that --burn-in writes: give both.")


def _shot_of_options(args: argparse.Namespace) -> Shot:
    if args.moved:
        raise InputError("--moved is for the files that a shot file names.")
    if args.plate is not None:
        raise InputError(
            "--plate replaces the plate of a shot file, but a plate is already given here."
        )
    return commands_for(args.shot).shot(args)


def _shot_in_file(args: argparse.Namespace) -> Shot:
    own = given(args, add_lens_options, add_plate_options)
    is_strict = own.pop("--strict", False) is True
    if own:
        raise InputError(
            f"{args.shot} defines the lens and the plate, so {', '.join(own)} cannot be given."
        )
    refuse_given(args, ("clip", "first_frame"), f"{args.shot} sets the timing of its scene")
    shot = read_shot(args.shot, args.moved)
    options = shot.plate_options
    return replace(shot, plate_options=replace(options, strict=is_strict or options.strict))


def _with_overrides(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with the given blur settings, plate and frame rate."""
    defocus = settings_of(args, shot.defocus)
    if args.pinhole and args.proxy is None:
        defocus = replace(defocus, proxy=1.0)
    shot = replace(shot, defocus=defocus)
    if args.plate is not None:
        shot = replace(shot, source=os.path.expanduser(args.plate))
    if args.parts is None:
        shot = replace(shot, defocus=blur_of_export(shot))
    if args.size is not None or args.scene_camera is not None:
        shot = with_framing(args, shot)
    return shot if args.fps is None else replace(shot, frames_per_second=args.fps)


def _refuse_unused(args: argparse.Namespace, read: Shot | None) -> None:
    """Refuse options without effect before printing anything; `read` is the shot of a shot file."""
    source = args.plate or (args.shot if read is None else read.source)
    method = settings_of(args, read.defocus if read else DefocusSettings()).method
    refuse_unused(args, source or "", method)


def _started(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with the given timecode for its first frame.

    Plates without a shot file begin with their first file, whichever frames are exported, so that
    the timecode continues across the parts of an export.
    """
    if args.start_timecode is None:
        return shot
    if shot.span is None:
        shot = replace(shot, frames=source_of(shot).frames)
    return shot.started_at(args.start_timecode)


def _frames(args: argparse.Namespace, shot: Shot) -> tuple[int, ...]:
    """Return the requested frames, all of which must be within the range of the source.

    The name of one frame stands for its sequence, except where the output is one picture.
    """
    output, named = parse_output(args.output), frame_among(args.shot)
    is_one_file = not (output.is_movie or output.form.padding)
    if is_one_file and args.frames is None and named is not None:
        say_one_is_meant(args.shot, named[1])
        return (named[0],)
    frames = frames_of(shot, args.frames)
    if args.frames is not None:
        source = source_of(shot)
        check_within(source.span(shot), source.text, frames)
    return frames


def _look(args: argparse.Namespace, shot: Shot) -> DisplayLook:
    """Return the look of pictures; EXR output needs none, and no config is loaded."""
    if parse_output(args.output).is_exr:
        return DisplayLook()
    canvases = (
        getattr(args, "canvases", ()) if args.framing is None else read_canvases(args.framing)
    )
    guides = replace(Guides(**typed_fields(args, Guides)), canvases=canvases)
    return replace(display_look(args, shot_header(shot), shot.grade), guides=guides)
