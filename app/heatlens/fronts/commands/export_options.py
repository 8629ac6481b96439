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
from heatlens.deliver.export.burn_in import check_template
from heatlens.deliver.export.job import DisplaySettings, ExportJob, blur_of_export
from heatlens.deliver.export.options import (
    EXR,
    FRAMES,
    LOOK,
    USUAL_COMPRESSION,
    ExportOptions,
    options_of_group,
)
from heatlens.deliver.export.output import Output, parse_output
from heatlens.deliver.export.plan import frames_of
from heatlens.fronts.commands.options.display_options import (
    add_display_options,
    display_settings,
    shot_header,
)
from heatlens.fronts.commands.options.farm_options import add_farm_options
from heatlens.fronts.commands.options.field_options import (
    add_blur_options,
    add_fields,
    given_fields,
    settings_of,
)
from heatlens.fronts.commands.options.given_options import (
    changed_options,
    refuse_options,
    refuse_unused_options,
)
from heatlens.fronts.commands.options.lens_options import add_lens_options, add_plate_options
from heatlens.fronts.commands.options.one_of_many import frame_in_sequence, print_one_frame_exported
from heatlens.fronts.commands.options.pinhole_output import (
    add_pinhole_options,
    check_pinhole_options,
    parse_kept_channels,
    pinhole_options,
)
from heatlens.fronts.commands.options.scene_options import add_framing_options, with_framing
from heatlens.fronts.commands.shots.following import measure_live_focus
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
    add_fields(group, ExportOptions, options_of_group(FRAMES))
    group.add_argument(
        "--plate", metavar="FILES", help="plate to use instead of the one in the shot"
    )
    group.add_argument(
        "--progress",
        choices=("terminal", "json", "openjd"),
        default="terminal",
        help="terminal: a progress line on stderr if it is a terminal (default); json: one line "
        "on stdout for each frame, then a last one with the event end, or failed with a message; "
        "openjd: for a render farm",
    )


def _add_scene_options(parser: argparse.ArgumentParser) -> None:
    add_framing_options(parser, has_rate=True)
    add_pinhole_options(parser)


def _add_exr_options(parser: argparse.ArgumentParser) -> None:
    add_fields(parser.add_argument_group("EXR"), ExportOptions, options_of_group(EXR))


def _add_display_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of display pictures, and those of the guides drawn over them."""
    group = add_display_options(parser)
    add_fields(group, ExportOptions, options_of_group(LOOK))
    add_fields(group, Guides)
    group.add_argument(
        "--framing",
        type=Path,
        metavar="FILE.fdl",
        help="draw the frames of a framing decision list (ASC FDL), and corners around what they "
        "protect",
    )


def make_export_job(args: argparse.Namespace) -> ExportJob:
    """Return the export job of the options.

    Raises InputError if they contradict the shot or each other.
    """
    output = parse_output(args.output)
    _check_output_kind(args, output)
    file_shot = _read_shot_file(args) if is_shot_file(args.shot) else None
    check_pinhole_options(
        args, output.is_exr, file_shot is not None, default_compression=USUAL_COMPRESSION
    )
    _refuse_useless_options(args, file_shot)
    shot = _with_overrides(args, file_shot or _shot_of_options(args))
    frames = _requested_frames(args, shot)
    shot = measure_live_focus(_with_start_timecode(args, shot))
    options = ExportOptions(**given_fields(args, ExportOptions))
    if args.pinhole:
        options = replace(options, with_depth=True)
    check_template(options.burn_in_text)
    if (
        options.burn_in
        and not options.shot_name
        and _is_from_command_line(args)
        and file_shot is not None
    ):
        options = replace(options, shot_name=Path(args.shot).name.split(".")[0])
    display, kept_channels = _picture_display(args, shot), _channels_to_keep(args, shot)
    pinhole = pinhole_options(args)
    return ExportJob(
        shot=shot,
        frames=frames,
        output=output,
        options=options,
        display_settings=display,
        keep=kept_channels,
        pinhole=args.pinhole,
        pinhole_options=pinhole,
    )


def frames_of_part(args: argparse.Namespace, job: ExportJob) -> tuple[int, ...] | None:
    """Return the frames of --part; None for all. Raises InputError for frames not in the job."""
    if args.part is None:
        return None
    part = parse_frames(args.part)
    unknown_frames = set(part).difference(job.frames)
    if unknown_frames:
        raise InputError(
            f"--part: frames {frames_text(sorted(unknown_frames))} are not in this export."
        )
    return part


def _is_from_command_line(args: argparse.Namespace) -> bool:
    """Return False if the options come from the window."""
    return getattr(args, "job", None) is None


def _channels_to_keep(args: argparse.Namespace, shot: Shot) -> tuple[str, ...]:
    """Return the channels to keep, checked in the first plate; the others are assumed equal."""
    if not args.keep_channels:
        return ()
    return parse_kept_channels(args, source_of(shot), shot.plate_options, shot.defocus.proxy)


def _check_output_kind(args: argparse.Namespace, output: Output) -> None:
    """Refuse options that the kind of output file does not support, instead of ignoring them."""
    given_names = changed_options(args, _add_display_options if output.is_exr else _add_exr_options)
    if given_names and output.is_exr:
        raise InputError(
            f"{', '.join(given_names)}: EXR frames stay scene-linear and clean for further work. "
            "Export PNG, JPEG or a movie in addition."
        )
    if given_names:
        raise InputError(
            f"{', '.join(given_names)}: only EXR frames hold this, and {args.output} is none."
        )
    _check_combinations(args, output)


def _check_combinations(args: argparse.Namespace, output: Output) -> None:
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
    if (args.burn_in_text or args.shot_name) and _is_from_command_line(args):
        raise InputError("--burn-in-text and --shot-name are for --burn-in: give both.")
    if args.unit is not None:
        raise InputError("--unit is the unit of the distance that --burn-in writes: give both.")


def _shot_of_options(args: argparse.Namespace) -> Shot:
    """Return the shot of a plate or scene; refuse options that are for shot files."""
    if args.moved:
        raise InputError(
            "--moved changes where the files of a shot file lie, and no shot file is given: leave "
            "it out."
        )
    if args.plate is not None:
        raise InputError(
            "--plate replaces the plate of a shot file, but a plate is already given here."
        )
    return commands_for(args.shot).shot(args)


def _read_shot_file(args: argparse.Namespace) -> Shot:
    """Return the shot of the shot file; refuse options for values that the file defines."""
    lens_and_plate_options = changed_options(args, add_lens_options, add_plate_options)
    is_strict = lens_and_plate_options.pop("--strict", False) is True
    if lens_and_plate_options:
        raise InputError(
            f"{args.shot} defines the lens and the plate, so {', '.join(lens_and_plate_options)} "
            "cannot be given."
        )
    refuse_options(args, ("clip", "first_frame"), f"{args.shot} sets the timing of its scene")
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


def _refuse_useless_options(args: argparse.Namespace, file_shot: Shot | None) -> None:
    """Raise InputError for options without effect, before anything is printed.

    `file_shot` is the shot of a shot file; None without one.
    """
    source = args.plate or (args.shot if file_shot is None else file_shot.source)
    method = settings_of(args, file_shot.defocus if file_shot else DefocusSettings()).method
    refuse_unused_options(args, source or "", method)


def _with_start_timecode(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with the given timecode for its first frame.

    Plates without a shot file begin with their first file, whichever frames are exported. The
    timecode therefore continues across the parts of an export.
    """
    if args.start_timecode is None:
        return shot
    if shot.span is None:
        shot = replace(shot, frames=source_of(shot).frames)
    return shot.with_start_timecode(args.start_timecode)


def _requested_frames(args: argparse.Namespace, shot: Shot) -> tuple[int, ...]:
    """Return the requested frames, all of which must be within the range of the source.

    The name of one frame stands for its sequence, except where the output is one picture.
    """
    output, found = parse_output(args.output), frame_in_sequence(args.shot)
    is_one_file = not (output.is_movie or output.form.padding)
    if is_one_file and args.frames is None and found is not None:
        print_one_frame_exported(args.shot, found[1])
        return (found[0],)
    frames = frames_of(shot, args.frames)
    if args.frames is not None:
        source = source_of(shot)
        check_within(source.span(shot), source.text, frames)
    return frames


def _picture_display(args: argparse.Namespace, shot: Shot) -> DisplaySettings:
    """Return the display settings of pictures; EXR output needs none, and no config is loaded."""
    if parse_output(args.output).is_exr:
        return DisplaySettings()
    canvases = (
        getattr(args, "canvases", ()) if args.framing is None else read_canvases(args.framing)
    )
    guides = replace(Guides(**given_fields(args, Guides)), canvases=canvases)
    return replace(display_settings(args, shot_header(shot), shot.grade), guides=guides)
