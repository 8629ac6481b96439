"""A source that has been opened, with its first picture and the shot to start with."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Protocol

from heatlens.errors import InputError
from heatlens.frame_cache.cache import FrameCache
from heatlens.frame_cache.reader import settled_options
from heatlens.model.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.model.framing import SceneTiming
from heatlens.model.lens import Lens
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import LensParameter, Shot
from heatlens.plate.plate import Plate
from heatlens.plate.start_lens import StartLens, start_lens
from heatlens.scene.first_shot import FirstShot, first_shot, lens_with
from heatlens.scene.placing import Placing
from heatlens.scene.scene import Scene
from heatlens.sequence.sequence import MissingPolicy, Stamp
from heatlens.source.kind import SourceKind
from heatlens.source.origin import stamped
from heatlens.source.plate_source import PlateSource
from heatlens.source.scene_source import SceneSource
from heatlens.source.source import Source
from heatlens.source.stream_source import StreamSource


class Opened(Protocol):
    """An opened source whose first picture has been read.

    source   the source itself
    options  the options with which its plates were requested
    frame    the frame to show first
    """

    @property
    def kind(self) -> SourceKind:
        """The kind of the source, which decides which panels the window shows."""

    @property
    def source(self) -> Source: ...
    @property
    def options(self) -> PlateOptions: ...
    @property
    def frame(self) -> int: ...

    @property
    def text(self) -> str:
        """The name by which a shot file refers to the source."""

    @property
    def settled(self) -> PlateOptions:
        """The options with which every plate is read, settled by the first plate."""

    @property
    def frames(self) -> FrameRange | None:
        """The current range of frames; None for a still and a stream."""

    @property
    def timing(self) -> SceneTiming | None:
        """How the seconds of a scene became frames; None in the usual way, and for all else."""

    @property
    def news(self) -> int:
        """A counter that increases whenever the state of a frame changes."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences to show to the user: repairs, guesses, warnings."""

    @property
    def attributes(self) -> Mapping[str, Any]:
        """The header entries of the first plate, which describe its colour space."""

    @property
    def cache(self) -> FrameCache | None:
        """The cache of plates; None if no plates are read from files."""

    @property
    def scene(self) -> Scene | None:
        """The 3D scene; None for plates and streams."""

    @property
    def stamps(self) -> tuple[Stamp | None, ...]:
        """The stamps, from before reading, of the files that all frames are made of."""

    def files_at(self, frame: int, missing: MissingPolicy) -> tuple[Path, ...]:
        """Return the files that only `frame` is made of; none for a black or a missing frame."""

    def lens(self, given: Mapping[str, Any]) -> StartLens:
        """Return the lens to start with; `given` holds fields of Lens. Raises LensError."""

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return the shot to start with."""

    def close(self) -> None:
        """Stop reading."""


class News:
    """Counts the state changes of a frame cache, and wakes the loop for each."""

    def __init__(self, wake: Any) -> None:
        self.count = 0
        self._wake = wake

    def tell(self) -> None:
        """Count a change and wake the loop; called on the threads of the cache."""
        self.count += 1
        self._wake()


@dataclass(frozen=True, eq=False)
class OpenedPlates:
    """A sequence, or a single file, of which one frame has been read. See `Opened`."""

    source: PlateSource
    cache: FrameCache
    frame: int
    plate: Plate
    counter: News

    kind: ClassVar = SourceKind.PLATES
    scene: ClassVar = None
    timing: ClassVar = None
    stamps: ClassVar = ()

    @property
    def text(self) -> str:
        """See `Opened`."""
        return self.source.text

    @property
    def options(self) -> PlateOptions:
        """See `Opened`."""
        return self.source.options

    @cached_property
    def settled(self) -> PlateOptions:
        """See `Opened`."""
        return settled_options(self.options, self.plate)

    @property
    def frames(self) -> FrameRange | None:
        """See `Opened`; a sequence grows while a renderer writes it."""
        sequence = self.cache.sequence
        return None if sequence.is_single else FrameRange(sequence.first, sequence.last)

    @property
    def news(self) -> int:
        """See `Opened`."""
        return self.counter.count

    @property
    def notes(self) -> tuple[str, ...]:
        """See `Opened`."""
        return self.plate.notes

    @property
    def attributes(self) -> Mapping[str, Any]:
        """See `Opened`."""
        return self.plate.attributes

    def files_at(self, frame: int, missing: MissingPolicy) -> tuple[Path, ...]:
        """See `Opened`."""
        try:
            path = self.cache.sequence.resolve(frame, missing)
        except InputError:
            return ()
        return () if path is None else self.source.files_of(path)

    def lens(self, given: Mapping[str, Any]) -> StartLens:
        """See `Opened`; other values come from the header."""
        return start_lens(self.plate, given)

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """See `Opened`; the frame rate comes from the header."""
        return Shot(
            lens,
            defocus,
            self.text,
            self.options,
            frames=self.frames,
            frames_per_second=_frame_rate(self.plate),
        )

    def close(self) -> None:
        """See `Opened`."""
        self.cache.close()


@dataclass(frozen=True, eq=False)
class OpenedScene:
    """A 3D scene with its first shot. See `Opened`."""

    source: SceneSource
    options: PlateOptions
    first: FirstShot
    stamps: tuple[Stamp | None, ...]

    kind: ClassVar = SourceKind.SCENE
    cache: ClassVar = None
    news: ClassVar = 0
    attributes: ClassVar[Mapping[str, Any]] = {}

    @property
    def text(self) -> str:
        """See `Opened`."""
        return self.source.text

    @property
    def settled(self) -> PlateOptions:
        """See `Opened`; a scene has no plates, so there is nothing to settle."""
        return self.options

    @property
    def scene(self) -> Scene:
        """See `Opened`."""
        return self.first.scene

    @property
    def frame(self) -> int:
        """See `Opened`."""
        return self.first.frame

    @property
    def frames(self) -> FrameRange | None:
        """See `Opened`."""
        return self.scene.frames

    @property
    def timing(self) -> SceneTiming | None:
        """See `Opened`."""
        return self.source.timing

    @property
    def notes(self) -> tuple[str, ...]:
        """See `Opened`."""
        return self.scene.notes

    def files_at(self, frame: int, missing: MissingPolicy) -> tuple[Path, ...]:
        """See `Opened`; all frames are made of the same files."""
        return ()

    def lens(self, given: Mapping[str, Any]) -> StartLens:
        """See `Opened`; other values come from the scene's camera, or are assumed."""
        return StartLens(lens_with(self.first, given), dict.fromkeys(given, "given"))

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """See `Opened`; a given value replaces the keys of the scene's camera."""
        shot = replace(self.first.shot, lens=lens, defocus=defocus)
        for parameter in LensParameter:
            if getattr(lens, parameter) != getattr(self.first.shot.lens, parameter):
                curve = shot.curves.of(parameter)
                shot = shot.with_curve(parameter, replace(curve, keys=()))
        return shot

    def close(self) -> None:
        """See `Opened`; there is nothing to stop."""


@dataclass(frozen=True, eq=False)
class OpenedStream:
    """A running renderer whose first frame has arrived. See `Opened`."""

    source: StreamSource
    plate: Plate

    kind: ClassVar = SourceKind.STREAM
    frame: ClassVar = 1
    frames: ClassVar = None
    timing: ClassVar = None
    cache: ClassVar = None
    scene: ClassVar = None
    news: ClassVar = 0
    stamps: ClassVar = ()
    attributes: ClassVar[Mapping[str, Any]] = {}

    @property
    def text(self) -> str:
        """See `Opened`."""
        return self.source.text

    @property
    def options(self) -> PlateOptions:
        """See `Opened`; they may change while frames arrive."""
        return self.source.options

    @property
    def settled(self) -> PlateOptions:
        """See `Opened`."""
        return self.source.options

    @property
    def notes(self) -> tuple[str, ...]:
        """See `Opened`."""
        return self.plate.notes

    def files_at(self, frame: int, missing: MissingPolicy) -> tuple[Path, ...]:
        """See `Opened`; a stream has no files."""
        return ()

    def lens(self, given: Mapping[str, Any]) -> StartLens:
        """See `Opened`."""
        return start_lens(self.plate, given)

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """See `Opened`."""
        return Shot(lens, defocus, self.text, self.options)

    def close(self) -> None:
        """See `Opened`; the source keeps listening, because it may be shown again."""


def opened_scene(
    text: str,
    options: PlateOptions,
    timing: SceneTiming | None = None,
    placing: Placing = Placing(),  # noqa: B008
) -> OpenedScene:
    """Read a scene; `placing` gives the unit and the up axis if its file does not.

    Raises InputError that names the file if that fails.
    """
    source = SceneSource(text, timing)
    stamps = tuple(file.stamp for file in stamped(source.all_files))  # before it is read
    first = first_shot(text, timing=timing, placing=placing)
    return OpenedScene(source, options, first, stamps)


def _frame_rate(plate: Plate) -> float:
    """Return the frame rate in the header, or the default of OpenEXR if it is not plausible."""
    rate = float(plate.attributes.get("framesPerSecond", FRAMES_PER_SECOND))
    return rate if 1.0 <= rate <= 1000.0 else FRAMES_PER_SECOND
