"""Load the source of a command for one frame, make its shot, and print how it was read."""

import argparse
from collections.abc import Callable

from heatlens.commands.kit_options import shot_with_kit
from heatlens.commands.lens_options import lens_of
from heatlens.commands.plate_options import plate_options
from heatlens.commands.plate_words import say_breathing, say_plate
from heatlens.commands.say import say
from heatlens.commands.scene_options import load_scene
from heatlens.defocus.quality import unused_behind_notes
from heatlens.errors import InputError
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.plate.read import read_plate
from heatlens.render import FrameRenderer
from heatlens.source.kind import NO_FILES, SourceKind, kind_of


def load_source(
    args: argparse.Namespace, renderer: FrameRenderer, settings: DefocusSettings
) -> tuple[Shot, int]:
    """Load the source that `args.plate` names to the GPU. Return the shot and the frame.

    Prints how the source was read, and the origin of each value of the lens. Raises InputError if
    the source cannot be read, or the lens is not complete.
    """
    return _LOADERS[kind_of(str(args.plate))](args, renderer, settings)


def _load_plate(
    args: argparse.Namespace, renderer: FrameRenderer, settings: DefocusSettings
) -> tuple[Shot, int]:
    if settings.method.needs_scene:
        raise InputError(
            f"{args.plate} is a plate, seen from one point: --method {settings.method} looks at a "
            "3D scene from many."
        )
    options = plate_options(args)
    plate = read_plate(args.plate, options)
    lens, said = lens_of(args, plate)
    say_plate(plate, lens, said, options)
    say(*unused_behind_notes(plate, settings))
    renderer.load(plate)
    return shot_with_kit(args, Shot(lens, settings)), 0


def _load_scene(
    args: argparse.Namespace, renderer: FrameRenderer, settings: DefocusSettings
) -> tuple[Shot, int]:
    shot, frame, notes = load_scene(args, renderer, settings)
    say(*notes)
    say_breathing(shot.lens, None)
    return shot, frame


def _refuse_stream(
    args: argparse.Namespace, renderer: FrameRenderer, settings: DefocusSettings
) -> tuple[Shot, int]:
    raise InputError(f"{args.plate}: {NO_FILES}")


_Load = Callable[[argparse.Namespace, FrameRenderer, DefocusSettings], tuple[Shot, int]]
_LOADERS: dict[SourceKind, _Load] = {
    SourceKind.PLATES: _load_plate,
    SourceKind.SCENE: _load_scene,
    SourceKind.STREAM: _refuse_stream,
}
