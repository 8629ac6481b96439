"""Plates on the command line."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.base.errors import InputError
from heatlens.camera.samples import CameraSamples
from heatlens.commands.options.kit_options import shot_with_kit
from heatlens.commands.options.lens_options import lens_of
from heatlens.commands.options.plate_options import plate_options
from heatlens.commands.output.pipes import file_of_input
from heatlens.commands.output.plate_words import say_plate
from heatlens.commands.output.say import say
from heatlens.commands.sources.info_plate import plate_lines
from heatlens.commands.sources.shot_plate import plate_shot
from heatlens.commands.sources.source_commands import Facts, Line, SourceCommands
from heatlens.defocus.quality import unused_behind_notes
from heatlens.frame_cache.reader import settled_options
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.plate.inspection import inspect
from heatlens.plate.read import read_plate
from heatlens.sequence.sequence import find_sequence

if TYPE_CHECKING:
    from heatlens.render import FrameRenderer  # `info` draws nothing


class PlateCommands(SourceCommands):
    """Reads plates, whose lens may stand in the header."""

    def load(
        self, args: argparse.Namespace, renderer: "FrameRenderer", settings: DefocusSettings
    ) -> tuple[Shot, int]:
        """Load one plate, and return its shot."""
        if settings.method.needs_scene:
            raise InputError(
                f"{args.plate} is a plate, seen from one point: --method {settings.method} looks "
                "at a 3D scene from many."
            )
        options = plate_options(args)
        plate = read_plate(args.plate, options)
        lens, said = lens_of(args, plate)
        say_plate(plate, lens, said, options)
        say(*unused_behind_notes(plate, settings))
        renderer.load(plate)
        return shot_with_kit(args, Shot(lens, settings)), 0

    def shot(self, args: argparse.Namespace) -> Shot:
        """Return a shot with a constant lens of the options and of the first plate's header.

        It does not depend on the requested frames, because a shot may be exported in parts.
        """
        sequence, options = find_sequence(args.shot), plate_options(args)
        plate = read_plate(sequence.path_at(sequence.present[0]), options)
        lens, said = lens_of(args, plate)
        say_plate(plate, lens, said, options)
        shot = Shot(lens, source=args.shot, plate_options=settled_options(options, plate))
        return shot_with_kit(args, shot)

    def new_shot(self, args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
        """Return a shot with the files, lens, frames and frame rate of the plates."""
        return plate_shot(args, camera)

    def info(self, args: argparse.Namespace, text: str) -> tuple[Facts, list[Line]]:
        """Return what is in the file and how it would be read."""
        with file_of_input(Path(text)) as path:
            facts = inspect(path, plate_options(args))
        return facts, plate_lines(facts)
