"""The protocol of a source whose frames can be rendered again.

`Origin` records the files that a frame is made of, and their state when it was planned.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.sequence import MissingPolicy, StampedFile

if TYPE_CHECKING:  # plates are planned, listed and exported by others without these
    from heatlens.media.scene.scene import Scene
    from heatlens.render.source.pinhole import Pinhole


@dataclass(frozen=True)
class Origin:
    """The files that one frame of a shot is made of.

    frame     number of the plate that is read for it; for a scene, the frame itself
    is_black  True if only the size of that plate is used, and its pixels become black
    files     the file that is read, then the files that it names or that belong to it;
              empty for the built-in scene
    """

    frame: int
    is_black: bool = False
    files: tuple[StampedFile, ...] = ()


class Renderer(Protocol):
    """The part of the renderer that a source uses: it uploads pictures to the GPU."""

    def load(self, plate: Plate) -> None:
        """Upload a plate to the GPU."""

    def load_scene(self, scene: "Scene") -> None:
        """Upload a scene to the GPU."""

    def load_pinhole(
        self, shot: Shot, frame: int = 0, views: int | None = None, is_for_file: bool = False
    ) -> "Pinhole":
        """Draw the pinhole picture of `frame`; for plates, return the loaded one."""


class FrameLoader(Protocol):
    """Loads one frame after the other into the renderer."""

    def load(self, origin: Origin) -> None:
        """Load the pinhole picture of this frame to the GPU.

        Raises InputError if a file is damaged or has been deleted.
        """

    def close(self) -> None:
        """Stop reading ahead."""


class Source(Protocol):
    """Plates or a 3D scene: any frame can be rendered at any time."""

    @property
    def text(self) -> str:
        """The name by which a shot file refers to the source."""

    @property
    def files(self) -> Path | None:
        """The file or the pattern; None if the source does not come from files."""

    @property
    def frames(self) -> FrameRange | None:
        """The range from the first to the last frame; None for a still."""

    @property
    def first_file(self) -> Path | None:
        """The file of the first plate that exists; None if no plates are read from files."""

    @property
    def all_files(self) -> tuple[Path, ...]:
        """The files that decide how every frame is read, beside its own; they need not exist."""

    @property
    def has_many_views(self) -> bool:
        """True if it can be seen from many points of the lens, by accumulation or ray tracing."""

    def with_absolute_paths(self) -> "Source":
        """Return the source with absolute paths, unread, to be sent to other machines."""

    def require(self) -> None:
        """Raise InputError if its files are missing, without reading them."""

    def span(self, shot: Shot) -> FrameRange | None:
        """Return the range of frames that can be rendered; None if there is no limit."""

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """Return the frames between the in and out point, else all frames.

        Raises InputError if they are unknown.
        """

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """Raise InputError with the numbers of `frames` that are missing and not replaceable."""

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """Return the files of `frame`; only files that name other files are read for this.

        Raises InputError if such a file cannot be read.
        """

    def distances_m(
        self, shot: Shot, mark: Mark, report_progress: Callable[[str], None]
    ) -> Distances:
        """Return the distance of a mark at each frame; call `report_progress` in between.

        Raises InputError if it cannot be measured in such a source.
        """

    def loader(
        self, shot: Shot, origins: tuple[Origin, ...], renderer: Renderer, is_for_file: bool = False
    ) -> FrameLoader:
        """Return a loader for these frames, which must be loaded in this order.

        `is_for_file`: surfaces behind a picture are written, see `FrameRenderer.load_pinhole`.
        """
