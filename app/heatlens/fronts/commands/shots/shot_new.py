"""`heatlens shot new`: write a shot file from options, even before the first frame exists.

Focus marks are typed so: `A=6'3"`, `B@960,540`, `C=cryptomatte:hero`.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, parse_frame_range
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.lens.lens import Lens, from_pupil_m, parse_measured_m
from heatlens.core.model.marks import marks
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import TYPED_MARK, DistanceMark, parse_mark
from heatlens.core.model.shot.lens_parameter import FOCUS_SCALES, LensParameter
from heatlens.core.model.shot.pull import frames_too_close
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.fronts.commands.options.field_options import add_blur_options, settings_of
from heatlens.fronts.commands.options.given_options import refuse_unused_options
from heatlens.fronts.commands.options.kit_options import shot_with_kit
from heatlens.fronts.commands.options.lens_options import (
    FOLLOWED_ORIGIN,
    add_lens_options,
    add_plate_options,
    plate_options,
)
from heatlens.fronts.commands.options.scene_options import add_framing_options
from heatlens.fronts.commands.options.shot_camera import (
    add_camera_option,
    camera_message,
    fields_not_from_camera,
    fill_from_camera,
    read_given_camera,
)
from heatlens.fronts.commands.options.value_types import parse_number
from heatlens.fronts.commands.output.pipes import DASH, stdin_as_file
from heatlens.fronts.commands.output.plate_words import first_plate, print_shot_doubts
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.fronts.commands.shots.following import (
    add_follow_options,
    followed_mark_name,
    make_focus_follow,
    track_marks,
)
from heatlens.fronts.commands.shots.typed_keys import PARAMETER_BY_NAME, Keys, parse_keys
from heatlens.fronts.commands.sources.shot_plate import align_camera_to_plate
from heatlens.fronts.commands.sources.source_commands import commands_for
from heatlens.media.camera.into_shot import with_camera
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.documents.shot_file import SHOT_SUFFIX, write_shot
from heatlens.media.sequence.names import frames_text

HELP = "write a shot file"
DESCRIPTION = """\
Writes a shot file: the plate or 3D scene, the lens with its keys, focus marks, frames and blur. The
plate's frames may be rendered later, unless the lens is to be taken from their header.
"""
EPILOG = """\
examples:
  heatlens shot new 'plate.####.exr' -o s.heatlens.json --focal-length 50 --sensor-width 36 \\
      --f-stop 1.3 --key focus@1001=0.94 --key focus@1024=3.83
  heatlens shot new 'plate.####.exr' -o s.heatlens.json --key focus@1001=6ft3in \\
      --key focus@1024=inf:linear --key f-stop@1010=2.8 --mark A=6ft3in --mark B@960,540
  heatlens shot new 'plate.####.exr' -o s.heatlens.json --f-stop 1.4 --follow A=cryptomatte:hero
  heatlens shot new scene.glb -o s.heatlens.json --f-stop 2 --focus-distance 3 --size 1920x1080
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "plate",
        help="the plate: a pattern such as 'plate.####.exr' or one file; or a 3D scene; or - to "
        "take the lens from a plate on standard input",
    )
    parser.add_argument("-o", "--output", type=Path, required=True, help=f"*{SHOT_SUFFIX} to write")
    parser.add_argument("--overwrite", action="store_true", help="replace an existing shot file")
    add_shot_options(parser)
    parser.set_defaults(run=run)


def add_shot_options(parser: argparse.ArgumentParser) -> None:
    """Add every option but the plate and the output."""
    add_camera_option(parser)
    _add_time_options(parser)
    add_follow_options(parser)
    add_lens_options(parser)
    add_blur_options(parser)
    add_plate_options(parser)
    add_framing_options(parser, has_rate=True)


def _add_time_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("over time")
    _add_keys_and_marks(group)
    group.add_argument(
        "--focus-interpolation",
        choices=FOCUS_SCALES,
        default="dioptres",
        help="interpolate focus between keys in dioptres, like a focus ring (default), or metres",
    )
    group.add_argument(
        "--frames", metavar="FIRST-LAST", help="default: those of the plate, else those of the keys"
    )
    group.add_argument("--in-out", metavar="FIRST-LAST", help="the part to play (default all)")
    group.add_argument(
        "--fps",
        type=parse_number,
        metavar="N",
        help=f"default: the camera's, else {FRAMES_PER_SECOND:g}",
    )
    group.add_argument(
        "--start-timecode",
        metavar="HH:MM:SS:FF",
        help="timecode of the first frame (default: from the plates' headers)",
    )
    group.add_argument(
        "--close-focus", metavar="DISTANCE", help="nearest focus of the lens, for warnings"
    )


def _add_keys_and_marks(group: "argparse._ArgumentGroup") -> None:
    group.add_argument(
        "--key",
        action="append",
        default=[],
        metavar="PARAMETER@FRAME=VALUE[:PATH]",
        help=f"{', '.join(PARAMETER_BY_NAME)} at a frame, and the path to the next key: "
        f"{', '.join(Interpolation)} (default smooth); may be repeated",
    )
    group.add_argument(
        "--mark",
        action="append",
        default=[],
        metavar="NAME=DISTANCE",
        help=f"focus mark: {', '.join(kind.help for kind in marks.KINDS)}; may be repeated",
    )


def run(args: argparse.Namespace) -> int:
    """Write the shot; print what was found, and frames nearer than the close focus."""
    _check_output(args.output, args.overwrite)
    shot = _piped_shot(args) if args.plate == DASH else make_shot(args)
    write_shot(args.output, shot)
    close_frames = frames_too_close(shot)
    if close_frames:
        limit = format_distance(shot.lens.close_focus_m or 0.0)
        print_messages(
            f"focus is nearer than the close focus of {limit} at frames "
            f"{frames_text(close_frames)}."
        )
    print_result(str(args.output))
    return 0


def _piped_shot(args: argparse.Namespace) -> Shot:
    """Return the shot of a plate on standard input, which has no name to find it again."""
    with stdin_as_file(Path(DASH)) as plate:
        shot = make_shot(argparse.Namespace(**{**vars(args), "plate": str(plate)}))
    print_messages(
        "standard input has no file name, so the shot has no plate: give one with `heatlens "
        "export --plate`."
    )
    return replace(shot, source=None)


def make_shot(args: argparse.Namespace) -> Shot:
    """Return the shot of the options and of `args.plate`; print its notes and doubts."""
    keys, followed_mark = parse_keys(args.key), followed_mark_name(args)
    camera = align_camera_to_plate(args, read_given_camera(args))
    fields_of_options = fields_not_from_camera(args, keys)
    filled_args = args if camera is None else fill_from_camera(args, camera, fields_of_options)
    filled_args = _fill_from_first_keys(filled_args, keys)
    if followed_mark is not None:
        filled_args = _fill_provisional_focus(filled_args)
    refuse_unused_options(args, args.plate, settings_of(args).method)
    shot = _with_option_values(args, commands_for(args.plate).new_shot(filled_args, camera))
    if camera is not None:
        shot = with_camera(shot, _camera_from_pupil(camera, shot.lens), fields_of_options)
        print_messages(*camera.notes, camera_message(camera, shot, args.camera, fields_of_options))
    shot = _with_keys(shot, keys)
    shot = track_marks(filled_args, shot)
    if followed_mark is not None:
        shot = make_focus_follow(filled_args, shot, followed_mark)
    _warn_of_outside_keys(shot)
    print_shot_doubts(shot, first_plate(shot), camera)
    return shot


def _warn_of_outside_keys(shot: Shot) -> None:
    """Warn of keys outside the shot, which are allowed but mostly typing mistakes."""
    span = shot.frames
    outside = [f"{frame:g}" for frame in shot.key_frames if span is not None and frame not in span]
    if outside:
        noun = "a key" if len(outside) == 1 else "keys"
        consequence = "it is kept and counts" if len(outside) == 1 else "they are kept and count"
        outside_text = f"{noun} outside at {', '.join(outside)}"
        print_messages(
            f"{shot.source} has frames {span}, with {outside_text}: {consequence} for the frames "
            "between keys."
        )


def _with_option_values(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with the values that come only from options."""
    if args.close_focus is not None:
        shot = replace(
            shot,
            lens=replace(shot.lens, close_focus_m=parse_measured_m(shot.lens, args.close_focus)),
        )
    is_new = args.follow is not None and TYPED_MARK.fullmatch(args.follow)
    mark_texts = [*args.mark, *([args.follow] if is_new else [])]
    shot_with_options = replace(
        shot_with_kit(args, shot),
        defocus=settings_of(args),
        plate_options=plate_options(args),
        marks=(
            *shot.marks,
            *(_mark_from_pupil(parse_mark(text), shot.lens) for text in mark_texts),
        ),
        in_out=parse_frame_range(args.in_out) if args.in_out else None,
    ).with_focus_scale(FOCUS_SCALES[args.focus_interpolation])
    return (
        shot_with_options
        if args.start_timecode is None
        else shot_with_options.with_start_timecode(args.start_timecode)
    )


def _with_keys(shot: Shot, keys: Keys) -> Shot:
    """Return the shot with its keys; each must make a possible lens."""
    for parameter, parameter_keys in keys.items():
        if parameter is LensParameter.FOCUS_DISTANCE:
            parameter_keys = [
                replace(key, value=from_pupil_m(shot.lens, key.value)) for key in parameter_keys
            ]
        shot = shot.with_curve(
            parameter, replace(shot.curves.of(parameter), keys=tuple(parameter_keys))
        )
    for frame in shot.key_frames:
        shot.lens_at(frame)
    return shot


def _camera_from_pupil(camera: CameraSamples, lens: Lens) -> CameraSamples:
    """Return the camera with its focus distances converted to distances from the entrance pupil."""
    if camera.focus_distance_m is None or not lens.measuring_offset_m:
        return camera
    focus_m = tuple(from_pupil_m(lens, distance_m) for distance_m in camera.focus_distance_m)
    return replace(camera, focus_distance_m=focus_m)


def _mark_from_pupil(mark: Mark, lens: Lens) -> Mark:
    """Return the mark with its distance converted to a distance from the entrance pupil."""
    if not isinstance(mark, DistanceMark) or not lens.measuring_offset_m:
        return mark
    return replace(mark, distance_m=from_pupil_m(lens, mark.distance_m))


def _fill_from_first_keys(args: argparse.Namespace, keys: Keys) -> argparse.Namespace:
    """Return the options with the first key of each parameter; print options it replaces."""
    filled_args = argparse.Namespace(**vars(args))
    filled_args.origins = {**getattr(args, "origins", {}), **dict.fromkeys(map(str, keys), "--key")}
    for parameter in LensParameter:
        if parameter in keys:
            _print_unused(args, parameter.attribute)
            setattr(filled_args, parameter.attribute, keys[parameter][0].value)
    if LensParameter.FOCUS_DISTANCE in keys:
        _print_unused(args, "focus_at")
        filled_args.focus_distance, filled_args.focus_at = repr(filled_args.focus_distance), None
    return filled_args


def _fill_provisional_focus(args: argparse.Namespace) -> argparse.Namespace:
    """Return the options with a provisional focus, until the followed mark is measured."""
    filled_args = argparse.Namespace(**vars(args))
    filled_args.origins = {**getattr(args, "origins", {}), "focus_distance_m": FOLLOWED_ORIGIN}
    filled_args.focus_distance, filled_args.focus_at = "1", None
    return filled_args


def _print_unused(args: argparse.Namespace, option: str) -> None:
    """Print that an option has no effect, because keys replace it, if it was given."""
    if getattr(args, option) is not None:
        print_messages(
            f"--{option.replace('_', '-')} is not used, because keys set it at every frame."
        )


def _check_output(path: Path, overwrite: bool) -> None:
    """Raise InputError for a wrong suffix, and for an existing file without --overwrite."""
    if not path.name.endswith(SHOT_SUFFIX) or path.name == SHOT_SUFFIX:
        raise InputError(f"{path}: the name of a shot file must end in {SHOT_SUFFIX}.")
    if path.is_file() and not overwrite:
        raise InputError(f"{path} already exists. Replace it with --overwrite.")
