"""What stands before the lens, as one protocol for renderer, export, commands and window."""

from pathlib import Path
from typing import Protocol

from heatlens.model.frames import FrameRange
from heatlens.model.shot import Shot
from heatlens.plate.plate import Plate
from heatlens.scene.scene import Scene
from heatlens.sequence.sequence import MissingPolicy
from heatlens.source.origin import Origin
from heatlens.source.pinhole import Pinhole


class Renderer(Protocol):
    """The renderer as a source sees it: it takes pictures to the GPU."""

    def load(self, plate: Plate) -> None:
        """Take a plate to the GPU."""

    def load_scene(self, scene: Scene) -> None:
        """Take a scene to the GPU."""

    def look(
        self, shot: Shot, frame: int = 0, views: int | None = None, is_for_file: bool = False
    ) -> Pinhole:
        """Draw the pinhole picture of `frame`; for a plate, return the one that is loaded."""


class FrameLoader(Protocol):
    """Prepares the renderer for one frame after the other."""

    def load(self, origin: Origin) -> None:
        """Have the pinhole picture of this frame on the GPU.

        Raises InputError where a file is damaged or has been deleted.
        """

    def close(self) -> None:
        """Stop reading ahead."""


class Source(Protocol):
    """Plates, a 3D scene, or the frames that a running renderer sends."""

    @property
    def text(self) -> str:
        """The name that finds it again, as a shot file keeps it."""

    @property
    def files(self) -> Path | None:
        """The file or the pattern; None for what does not come from files."""

    @property
    def frames(self) -> FrameRange | None:
        """The frames from the first to the last; None for a still."""

    @property
    def first_file(self) -> Path | None:
        """The file of the first plate that is there; None where no plate is read from a file."""

    @property
    def has_many_views(self) -> bool:
        """True where it can be seen from many points of the lens, by accumulation or rays."""

    @property
    def is_repeatable(self) -> bool:
        """True where the same frame can be rendered again later; False for a stream."""

    def require(self) -> None:
        """Raise InputError where its files are missing; nothing is read."""

    def span(self, shot: Shot) -> FrameRange | None:
        """Return the frames outside of which nothing can be asked for; None where anything can."""

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """Return the frames from in to out, else all that there are.

        Raises InputError where they cannot be told.
        """

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """Raise InputError naming those of `frames` that are missing and may not be replaced."""

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """Return what `frame` is made of. Only files that name other files are read.

        Raises InputError where that fails.
        """

    def loader(
        self,
        shot: Shot,
        origins: tuple[Origin, ...],
        renderer: Renderer,
        is_for_file: bool = False,
    ) -> FrameLoader:
        """Return a loader for these frames, to be asked for in this order.

        `is_for_file`: what is behind a pinhole picture is written, see `FrameRenderer.look`.
        """
