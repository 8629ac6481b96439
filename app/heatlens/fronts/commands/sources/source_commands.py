"""The interface by which the command line reads a source of any kind."""

import argparse
from typing import TYPE_CHECKING, Any, NoReturn

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.marks import MatteMark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.samples import CameraSamples
from heatlens.render.source.kinds import kind_of

if TYPE_CHECKING:
    from heatlens.render.frame_renderer import FrameRenderer  # `info` draws nothing

Line = tuple[str, str]  # label and value
Facts = dict[str, Any]  # the entries that `info` prints as JSON


class SourceCommands:
    """Reads one kind of source on the command line; this base class refuses every command.

    Each method prints how the source was read. Raises InputError if it cannot be read, or the lens
    is not complete. See `SourceKind.commands`.
    """

    def load(
        self, args: argparse.Namespace, renderer: "FrameRenderer", settings: DefocusSettings
    ) -> tuple[Shot, int]:
        """Load `args.plate` to the GPU, and return its shot and the frame (render, study)."""
        self._refuse(args.plate)

    def shot(self, args: argparse.Namespace) -> Shot:
        """Return a shot of `args.shot` with the lens of the options (export)."""
        self._refuse(args.shot)

    def new_shot(self, args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
        """Return a shot of `args.plate` with its lens, frames and frame rate (shot new)."""
        self._refuse(args.plate)

    def track_mark(self, args: argparse.Namespace, shot: Shot, mark: TrackMark) -> TrackMark:
        """Return a mark whose surface is followed over the frames of `args.plate` (shot new)."""
        self._refuse(args.plate)

    def check_thing(self, args: argparse.Namespace, mark: MatteMark) -> None:
        """Raise InputError where no frame of `args.plate` has the thing of a mark (shot new)."""
        self._refuse(args.plate)

    def info(self, args: argparse.Namespace, text: str) -> tuple[Facts, list[Line]]:
        """Return the facts of `text` for programs, and as lines for people (info)."""
        self._refuse(text)

    def _refuse(self, text: object) -> NoReturn:
        raise InputError(f"{text}: {kind_of(str(text)).refusal}")


def commands_for(text: object) -> SourceCommands:
    """Return the commands for the kind of the source `text`."""
    commands: SourceCommands = kind_of(str(text)).commands()
    return commands
