"""A source that has been opened, with its first picture and the shot to start with."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.files.apart import Stop
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.header.header_lens import StartLens
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.placing import Placing
from heatlens.media.scene.scene import Scene
from heatlens.media.sequence.sequence import MissingPolicy, Stamp
from heatlens.render.source.source import Source


def _ignore() -> None:
    """Do nothing."""


@dataclass(frozen=True)
class Opening:
    """The source to open, and how.

    frame    the frame to show first; None for the usual one
    timing   how the seconds of a scene become frames
    placing  unit and up axis of a scene whose file does not say them
    wake     called on a thread when the state of a frame changes
    stop     ends the process that reads a scene
    """

    text: str
    options: PlateOptions
    frame: int | None = None
    timing: SceneTiming | None = None
    placing: Placing = Placing()  # noqa: RUF009
    wake: Callable[[], None] = _ignore
    stop: Stop = field(default_factory=Stop)


class Opened(ABC):
    """An opened source whose first picture has been read; this base has neither files nor frames.

    text        the name by which a shot file refers to the source
    frame       the frame to show first
    notes       sentences to show to the user: repairs, guesses, warnings
    attributes  the header entries of the first plate, which describe its color space
    scene       the 3D scene; None if there is none
    timing      how the seconds of a scene became frames; None for the default and for other sources
    stamps      stamps, taken before reading, of the files that all frames are made of
    cache       the cache of plates; None if no plates are read from files
    render_source  the source that renders its frames later; None if they exist only once
    """

    text: str
    frame: int
    notes: tuple[str, ...]
    attributes: Mapping[str, object] = MappingProxyType({})
    scene: Scene | None = None
    timing: SceneTiming | None = None
    stamps: tuple[Stamp | None, ...] = ()
    cache: FrameCache | None = None
    render_source: Source | None = None

    @property
    @abstractmethod
    def options(self) -> PlateOptions:
        """The options with which its plates were requested."""

    @property
    def settled_options(self) -> PlateOptions:
        """The options with which every plate is read, settled by the first plate."""
        return self.options

    def read(self, path: Path) -> Plate:
        """Read one of its files for a picture at rest; a source without a cache has no files.

        Raises InputError if the file cannot be read.
        """
        raise InputError(f"{path} is none of the files of {self.text}.")

    @property
    def frames(self) -> FrameRange | None:
        """The current range of frames; None for a still and a stream."""
        return None

    @property
    def change_count(self) -> int:
        """A counter that increases whenever the state of a frame changes."""
        return 0

    def files_at(self, frame: int, missing: MissingPolicy) -> tuple[Path, ...]:
        """Return the files that only `frame` is made of; none for a black or a missing frame."""
        return ()

    @abstractmethod
    def lens(self, lens_fields: Mapping[str, object]) -> StartLens:
        """Return the lens to start with, with these fields of Lens. Raises LensError."""

    @abstractmethod
    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return the shot to start with."""

    def close(self) -> None:  # noqa: B027
        """Stop reading; the base reads nothing."""
