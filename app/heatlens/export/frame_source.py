"""What stands in front of the lens at each frame of an export, whether plates or a scene."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer
from heatlens.sequence.sequence import MissingPolicy, Stamp


@dataclass(frozen=True)
class Origin:
    """What one frame is made of.

    frame     number of the plate that is read for it; of a scene the frame itself
    is_black  nothing of that plate is seen but its size
    path      the file that is read, None where there is none
    stamp     of that file, None where there is none
    beside    stamps of the files that it names
    """

    frame: int
    is_black: bool
    path: Path | None
    stamp: Stamp | None
    beside: tuple[Stamp | None, ...] = ()


@dataclass(frozen=True)
class PlannedFrame:
    """A frame before it is rendered.

    fingerprint  of all that decides the pixels; it is kept in the file
    """

    frame: int
    origin: Origin
    lens: Lens
    path: Path
    fingerprint: str


class FrameLoader(Protocol):
    """Has a renderer look at one frame after the other."""

    def load(self, frame: PlannedFrame) -> None:
        """Have it ready; raises InputError where what it is made of is damaged or gone."""

    def close(self) -> None:
        """Stop whatever is read ahead."""


class FrameSource(Protocol):
    """Plates or a scene."""

    @property
    def files(self) -> Path | None:
        """The pattern or the file that finds it again; None for what comes with the program."""

    @property
    def beside(self) -> tuple[Path, ...]:
        """Files that `files` names and that are read with it, there or not."""

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """Those from in to out, else all there are; InputError where they cannot be told."""

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """InputError naming those of `frames` that nothing is there for, nor may stand in."""

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """What `frame` is made of; files are looked at, and none is read but for their names."""

    def loader(
        self, shot: Shot, frames: tuple[PlannedFrame, ...], renderer: FrameRenderer
    ) -> FrameLoader:
        """For these frames, in this order."""
