"""Make the first shot of a plate: its lens, files, frames, rate and timecode."""

import argparse
import os
from dataclasses import replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange, parse_frame_range
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode, parse_timecode
from heatlens.fronts.commands.options.lens_options import given_lens_fields, lens_of, plate_options
from heatlens.fronts.commands.options.one_of_many import print_all_frames_taken
from heatlens.fronts.commands.output.plate_words import print_reading
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import match_by_timecode
from heatlens.media.files.picture_formats import is_picture, movie_of_frame
from heatlens.media.plate.header.camera_header import camera_at_header, lens_model_of
from heatlens.media.plate.header.timecode import rate_at
from heatlens.media.plate.parts.header_read import first_timecode, read_headers, read_timing_headers
from heatlens.media.plate.plate import CameraHeader
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence


def plate_shot(args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
    """Return a shot with the files, lens, frames and frame rate of a plate."""
    lens, sequence = _lens_and_sequence(args)
    if not args.frames:
        print_all_frames_taken(args.plate)
    return Shot(
        lens,
        source=_source_text(args.plate, sequence),
        frames=_shot_frames(args, sequence, camera),
        frames_per_second=shot_rate(args, camera, sequence),
    )


def align_camera_to_plate(
    args: argparse.Namespace, camera: CameraSamples | None
) -> CameraSamples | None:
    """Return the camera with each row of its table moved to the frame of the same timecode."""
    if camera is None or camera.timecodes is None:
        return camera
    try:
        sequence = find_sequence(args.plate)
    except InputError:  # a scene, or a plate without files yet, which `plate_shot` reports
        sequence = None
    frames = _shot_frames(args, sequence, camera=None)
    return match_by_timecode(
        camera, _timecode_of_plate(args, sequence), shot_rate(args, camera), frames
    )


def _timecode_of_plate(
    args: argparse.Namespace, sequence: Sequence | None
) -> tuple[int, Timecode] | None:
    """Return a frame and its timecode, from --start-timecode or else from the first file's header.

    Return None if neither gives one, also if the option is given but no frame is known.
    """
    frames = _shot_frames(args, sequence, camera=None)
    if args.start_timecode is not None:
        return None if frames is None else (frames.first, parse_timecode(args.start_timecode))
    return None if sequence is None else first_timecode(sequence)


def _lens_and_sequence(args: argparse.Namespace) -> tuple[Lens, Sequence | None]:
    """Return the lens and the plate's files, which may be missing if no header is needed.

    The header of the first file decides the lens model, unless an option does. Prints messages.
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
        print_messages(f"the plate has no files yet: {error}")
        return lens, None
    if lens is None:
        return _lens_of_header(args, sequence), sequence
    if args.lens_model is None:
        model, reason = lens_model_of(_camera_header(sequence))
        lens = replace(lens, model=model)
        print_messages(f"the lens makes the discs of a {model.facts.words} ({reason}).")
    return lens, sequence


def _lens_of_options(args: argparse.Namespace) -> Lens | None:
    """Return the lens if the options define it completely, else None."""
    lens_fields = given_lens_fields(args)
    needed = {"focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm"}
    return Lens(**lens_fields) if needed <= set(lens_fields) else None


def _lens_of_header(args: argparse.Namespace, sequence: Sequence) -> Lens:
    """Return the lens of the options, completed by the header of the first frame."""
    options = plate_options(args)
    plate = read_plate(sequence.path_at(sequence.present[0]), options)
    lens, lens_sentence = lens_of(args, plate)
    print_reading(plate, lens_sentence)
    return lens


def _camera_header(sequence: Sequence) -> CameraHeader:
    """Return the lens in the header of the first frame."""
    path = sequence.path_at(sequence.present[0])
    return CameraHeader() if is_picture(path) else camera_at_header(read_headers(path))


def _source_text(plate: str, sequence: Sequence | None) -> str:
    """Return the pattern of the files, or the typed text if there are none or it names frames."""
    if sequence is None or sequence.frame_range is not None:
        return os.path.expanduser(plate)
    return sequence.pattern


def _shot_frames(
    args: argparse.Namespace, sequence: Sequence | None, camera: CameraSamples | None
) -> FrameRange | None:
    """Return the given frames, else those of the plate or the camera; None for a still."""
    if args.frames:
        return parse_frame_range(args.frames)
    if sequence is None or sequence.is_single:
        return None if camera is None else camera.frame_range
    return FrameRange(sequence.first, sequence.last)


def shot_rate(
    args: argparse.Namespace, camera: CameraSamples | None, sequence: Sequence | None = None
) -> float:
    """Return the given frame rate, else that of the camera or the movie, else the default."""
    if args.fps is not None:
        return float(args.fps)
    if camera is not None:
        return camera.frames_per_second
    first_file = None if sequence is None else sequence.path_at(sequence.present[0])
    is_movie = first_file is not None and movie_of_frame(first_file) is not None
    rates = (
        map(rate_at, read_timing_headers(first_file)) if first_file is not None and is_movie else ()
    )
    return next((rate for rate in rates if rate is not None), FRAMES_PER_SECOND)
