"""Plates that have been opened: a sequence, or a single file, of which one frame has been read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.faults import report_faults
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.frame_cache.cache import Damaged, FrameCache
from heatlens.media.frame_cache.sequence_reader import fix_conventions
from heatlens.media.plate.header.header_lens import StartLens, start_lens
from heatlens.media.plate.header.timecode import rate_at
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.sequence import MissingPolicy, Sequence
from heatlens.render.source.opened import Opened, Opening
from heatlens.render.source.plate_source import PlateSource, sequence_of_one_size

_BUDGET_BYTES = 2 << 30  # plates kept in memory: some eighty frames of 1080p


class ChangeCounter:
    """Counts the state changes of a frame cache, and wakes the loop for each."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self.count = 0
        self._wake = wake

    def count_change(self) -> None:
        """Count a change and wake the loop; called on the threads of the cache."""
        self.count += 1
        self._wake()


@dataclass(frozen=True, eq=False)
class OpenedPlates(Opened):
    """A sequence, or a single file, of which one frame has been read."""

    text: str
    frame: int
    notes: tuple[str, ...]
    attributes: Mapping[str, object] = field()
    render_source: PlateSource = field()
    cache: FrameCache = field()
    plate: Plate
    counter: ChangeCounter

    @property
    def options(self) -> PlateOptions:
        """The options with which the plates were requested."""
        return self.render_source.options

    @cached_property
    def settled_options(self) -> PlateOptions:
        """The options, with what the first plate has settled for all of them."""
        return fix_conventions(self.options, self.plate)

    @property
    def frames(self) -> FrameRange | None:
        """The current range, None for one file; a sequence grows while a renderer writes it."""
        sequence = self.cache.sequence
        return None if sequence.is_single else FrameRange(sequence.first, sequence.last)

    @property
    def change_count(self) -> int:
        """A counter of the state changes of all frames."""
        return self.counter.count

    def files_at(self, frame: int, missing: MissingPolicy) -> tuple[Path, ...]:
        """Return the files of the plate of a frame, its own first; none if there is no plate."""
        try:
            path = self.cache.sequence.resolve(frame, missing)
        except InputError:
            return ()
        return () if path is None else self.render_source.files_of(path)

    def read(self, path: Path) -> Plate:
        """Read a plate with the hidden surfaces and border that neighboring frames show."""
        return self.render_source.read(path)

    def lens(self, lens_fields: Mapping[str, object]) -> StartLens:
        """Return the given lens, completed from the header."""
        return start_lens(self.plate, lens_fields)

    def shot(self, lens: Lens, defocus: DefocusSettings) -> Shot:
        """Return a shot of all frames, with the frame rate of the header."""
        return Shot(
            lens,
            defocus,
            source=self.text,
            plate_options=self.options,
            frames=self.frames,
            frames_per_second=rate_at(self.attributes) or FRAMES_PER_SECOND,
        )

    def close(self) -> None:
        """Stop reading ahead."""
        self.cache.close()


def open_plates(opening: Opening) -> OpenedPlates:
    """Read the first plate, and keep a cache that reads the others.

    Raises InputError if there are no plates, or the first one cannot be read.
    """
    text, options = opening.text, opening.options
    source = PlateSource(text, sequence_of_one_size(text), options)
    first_frame = _first_frame(source.sequence, text, opening.frame)
    changes = ChangeCounter(opening.wake)
    # A fault of the program in one frame makes that frame damaged; the others are still shown. The
    # cache reads frames alone; `PlateFeed` adds what neighboring frames show at rest.
    read = report_faults("A frame could not be read")(source.read.read_alone)
    cache = FrameCache(
        source.sequence,
        read,
        _BUDGET_BYTES,
        on_ready=changes.count_change,
        files_of=source.own_files,
    )
    try:
        plate = cache.read_and_wait(first_frame, window=0)
        if isinstance(plate, Damaged):
            raise plate.error
        if plate is None:
            raise InputError(f"{source.sequence.path_at(first_frame)} is not there.")
    except Exception:
        cache.close()
        raise
    return OpenedPlates(
        text=text,
        frame=first_frame,
        notes=plate.notes,
        attributes=plate.attributes,
        render_source=source,
        cache=cache,
        plate=plate,
        counter=changes,
    )


def _first_frame(sequence: Sequence, text: str, requested: int | None) -> int:
    """Return the requested frame if it exists, else that of the named file, else the first."""
    if requested is not None and sequence.has_file(requested):
        return requested
    named_frame = sequence.frame_at(Path(text))
    return (
        named_frame
        if named_frame is not None and sequence.has_file(named_frame)
        else sequence.present[0]
    )
