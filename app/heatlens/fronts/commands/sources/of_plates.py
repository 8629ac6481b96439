"""Plates on the command line."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.core.model.marks.marks import MatteMark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.options.kit_options import shot_with_kit
from heatlens.fronts.commands.options.lens_options import lens_of, plate_options
from heatlens.fronts.commands.output.pipes import stdin_as_file
from heatlens.fronts.commands.output.plate_words import print_plate_notes
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import print_messages
from heatlens.fronts.commands.sources.plate_lines import plate_lines
from heatlens.fronts.commands.sources.shot_plate import plate_shot
from heatlens.fronts.commands.sources.source_commands import Facts, Line, SourceCommands
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.frame_cache.sequence_reader import SequenceReader, fix_conventions
from heatlens.media.plate.header.timecode import rate_at
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.names import frames_text
from heatlens.media.sequence.sequence_search import find_sequence

if TYPE_CHECKING:
    from heatlens.render.frame_renderer import FrameRenderer  # `info` draws nothing


class PlateCommands(SourceCommands):
    """Reads plates, whose lens may be in the header."""

    def load(
        self, args: argparse.Namespace, renderer: "FrameRenderer", settings: DefocusSettings
    ) -> tuple[Shot, int]:
        """Load one plate, and return its shot. Raises InputError."""
        from heatlens.render.defocus.quality import unused_behind_notes

        if settings.method.needs_scene:
            raise InputError(
                f"{args.plate} is a plate, seen from one point: --method {settings.method} needs "
                "a 3D scene, seen from many."
            )
        options = plate_options(args)
        plate = _read_plate_with_neighbours(
            Path(args.plate), options, getattr(args, "behind_out", None)
        )
        lens, lens_sentence = lens_of(args, plate)
        print_plate_notes(plate, lens, lens_sentence, options)
        print_messages(*unused_behind_notes(plate, settings))
        renderer.load(plate)
        return shot_with_kit(args, Shot(lens, settings)), 0

    def shot(self, args: argparse.Namespace) -> Shot:
        """Return a shot with a constant lens of the options and of the first plate's header.

        It does not depend on the requested frames, because a shot may be exported in parts.
        """
        sequence, options = find_sequence(args.shot), plate_options(args)
        plate = read_plate(sequence.path_at(sequence.present[0]), options)
        lens, lens_sentence = lens_of(args, plate)
        print_plate_notes(plate, lens, lens_sentence, options)
        shot = Shot(
            lens,
            source=args.shot,
            plate_options=fix_conventions(options, plate),
            frames_per_second=rate_at(plate.attributes) or FRAMES_PER_SECOND,
        )
        return shot_with_kit(args, shot)

    def new_shot(self, args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
        """Return a shot with the files, lens, frames and frame rate of the plates."""
        from heatlens.media.plate.mattes.things import require_things

        shot = plate_shot(args, camera)
        for file in _first_files(args):
            require_things(file, plate_options(args))
        return shot

    def track_mark(self, args: argparse.Namespace, shot: Shot, mark: TrackMark) -> TrackMark:
        """Read the plates and follow the surface of the mark."""
        from heatlens.media.plate.tracking.tracked_mark import track_mark

        frames, plate_at = _plate_reader_of(args, shot)
        with progress_line() as show_progress:
            return track_mark(mark, frames, plate_at, show_progress)

    def check_thing(self, args: argparse.Namespace, mark: MatteMark) -> None:
        """Raise InputError where no plate has the thing of a mark."""
        from heatlens.media.plate.mattes.things import require_thing

        for file in _first_files(args):
            require_thing(file, mark.matte)

    def info(self, args: argparse.Namespace, text: str) -> tuple[Facts, list[Line]]:
        """Return the contents of the file, and how it would be read."""
        from heatlens.media.plate.inspection import inspect

        with stdin_as_file(Path(text)) as path:
            facts = inspect(path, plate_options(args))
        return facts, plate_lines(facts)


def _first_files(args: argparse.Namespace) -> tuple[Path, ...]:
    """Return a tuple with the first file, or an empty tuple if no plate is rendered yet."""
    try:
        sequence = find_sequence(args.plate)
    except InputError:  # reported already, when the shot was made
        return ()
    return (sequence.path_at(sequence.present[0]),)


def _plate_reader_of(
    args: argparse.Namespace, shot: Shot
) -> tuple[FrameRange, Callable[[int], Plate]]:
    """Return the frames of a shot, and a function that reads the plate of a frame.

    For a missing plate, the function reads the one before.
    """
    sequence = find_sequence(args.plate)
    reader = SequenceReader(shot.plate_options, sequence.path_at(sequence.present[0]))

    def plate_at(frame: int) -> Plate:
        shown_frame = sequence.shown_frame(frame, "hold")
        assert shown_frame is not None  # a sequence that was found has a file
        return reader(sequence.path_at(shown_frame))

    return shot.frames or FrameRange(sequence.first, sequence.last), plate_at


def _read_plate_with_neighbours(
    path: Path, options: PlateOptions, behind_out: Path | None
) -> Plate:
    """Read a plate; with --neighbours, add the hidden surfaces that neighboring frames show.

    The hidden surfaces are also written to `behind_out`, if it is given. Raises InputError if a
    file cannot be read or written.
    """
    if not options.neighbours:
        if behind_out is not None:
            raise InputError("--behind-out writes what neighbouring frames show: add --neighbours.")
        return read_plate(path, options)
    from heatlens.media.frame_cache.neighbour_reader import NeighbourReader
    from heatlens.media.plate.exr.exr_write import behind_path, write_behind

    target = None if behind_out is None else behind_path(behind_out, path)
    reader = NeighbourReader(options, find_sequence(path))
    found_surfaces = reader.add_hidden_surfaces(reader.read_alone(path))
    print_messages(reader.neighbourhood.words)
    if found_surfaces.frames:
        frame_list = frames_text(found_surfaces.frames)
        print_messages(
            f"frames {frame_list} show {found_surfaces.hidden_part:.0%} of what near silhouettes "
            "could hide."
        )
    if target is not None:
        write_behind(target, found_surfaces.layers)
        print_messages(f"{target} shows what lies behind {path}.")
    return found_surfaces.plate
