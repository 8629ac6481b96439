"""Make the first shot of a plate: its lens, files, frames, rate and timecode."""

import argparse
import os
from dataclasses import replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange, parse_frame_range
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode, parse_timecode
from heatlens.fronts.commands.options.lens_options import given_lens, lens_of, plate_options
from heatlens.fronts.commands.options.one_of_many import say_all_are_meant
from heatlens.fronts.commands.output.plate_words import say_reading
from heatlens.fronts.commands.output.say import say
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import at_timecode
from heatlens.media.files.picture_formats import in_movie, is_picture
from heatlens.media.plate.header.camera_header import camera_at_header, lens_model_of
from heatlens.media.plate.header.timecode import rate_at
from heatlens.media.plate.parts.header_read import first_timecode, headers_of, read_headers
from heatlens.media.plate.plate import CameraHeader
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence import Sequence, find_sequence


def plate_shot(args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
    """Return a shot with the files, lens, frames and frame rate of a plate."""
    lens, sequence = _lens_and_sequence(args)
    if not args.frames:
        say_all_are_meant(args.plate)
    return Shot(
        lens,
        source=_source_of(args.plate, sequence),
        frames=_frames_of(args, sequence, camera),
        frames_per_second=rate_of(args, camera, sequence),
    )


def on_frames_of_plate(
    args: argparse.Namespace, camera: CameraSamples | None
) -> CameraSamples | None:
    """Return the camera with the rows of a table on the frames that have their timecode."""
    if camera is None or camera.timecodes is None:
        return camera
    try:
        sequence = find_sequence(args.plate)
    except InputError:  # a scene, or a plate without files yet, which `plate_shot` reports
        sequence = None
    frames = _frames_of(args, sequence, None)
    return at_timecode(camera, _timecode_of_plate(args, sequence), rate_of(args, camera), frames)


def _timecode_of_plate(
    args: argparse.Namespace, sequence: Sequence | None
) -> tuple[int, Timecode] | None:
    """Return a frame and its timecode: of the option, else of the header of the first file."""
    frames = _frames_of(args, sequence, None)
    if args.start_timecode is not None:
        return None if frames is None else (frames.first, parse_timecode(args.start_timecode))
    return None if sequence is None else first_timecode(sequence)


def _lens_and_sequence(args: argparse.Namespace) -> tuple[Lens, Sequence | None]:
    """Return the lens and the plate's files, which may be missing if no header is needed.

    The header of the first file decides the lens model, unless an option does.
    """
    lens = _lens_of_options(args)
    try:
        sequence = find_sequence(args.plate)
    except InputError as error:
        if lens is None:
            raise InputError(
                f"{error} Without a header to read, the lens needs --focal-length, --f-stop and "
                "--focus-distance, or keys for them, and --sensor-width or --filmback."
            ) from None
        say(f"the plate has no files yet: {error}")
        return lens, None
    if lens is None:
        return _lens_of_header(args, sequence), sequence
    if args.lens_model is None:
        model, why = lens_model_of(_camera_header(sequence))
        lens = replace(lens, model=model)
        say(f"the lens makes the discs of a {model.facts.words} ({why}).")
    return lens, sequence


def _lens_of_options(args: argparse.Namespace) -> Lens | None:
    """Return the lens if the options define it completely, else None."""
    given = given_lens(args)
    needed = {"focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm"}
    return Lens(**given) if needed <= set(given) else None


def _lens_of_header(args: argparse.Namespace, sequence: Sequence) -> Lens:
    """Return the lens of the options, completed by the header of the first frame."""
    options = plate_options(args)
    plate = read_plate(sequence.path_at(sequence.present[0]), options)
    lens, said = lens_of(args, plate)
    say_reading(plate, f"{plate.path}: {said}")
    return lens


def _camera_header(sequence: Sequence) -> CameraHeader:
    """Return the lens in the header of the first frame."""
    path = sequence.path_at(sequence.present[0])
    return CameraHeader() if is_picture(path) else camera_at_header(read_headers(path))


def _source_of(plate: str, sequence: Sequence | None) -> str:
    """Return the pattern of the files, or the typed text if there are none or it names frames."""
    if sequence is None or sequence.frame_range is not None:
        return os.path.expanduser(plate)
    return sequence.pattern


def _frames_of(
    args: argparse.Namespace, sequence: Sequence | None, camera: CameraSamples | None
) -> FrameRange | None:
    """Return the given frames, else those of the plate or the camera; None for a still."""
    if args.frames:
        return parse_frame_range(args.frames)
    if sequence is None or sequence.is_single:
        return None if camera is None else camera.frame_range
    return FrameRange(sequence.first, sequence.last)


def rate_of(
    args: argparse.Namespace, camera: CameraSamples | None, sequence: Sequence | None = None
) -> float:
    """Return the given frame rate, else that of the camera or the movie, else the usual one."""
    if args.fps is not None:
        return float(args.fps)
    if camera is not None:
        return camera.frames_per_second
    first = None if sequence is None else sequence.path_at(sequence.present[0])
    is_movie = first is not None and in_movie(first) is not None
    rates = map(rate_at, headers_of(first)) if first is not None and is_movie else ()
    return next((rate for rate in rates if rate is not None), FRAMES_PER_SECOND)
