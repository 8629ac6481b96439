"""The properties that sources and their frames share."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Unpack

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.fronts.api.keywords import FrameOptions
from heatlens.fronts.api.notes import errors_with_python_names
from heatlens.media.plate.header.header_lens import NEEDED
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.names import frames_text
from heatlens.render.gpu.textures import FloatArray

DepthRange = tuple[float, float]


@dataclass(frozen=True)
class FrameFacts:
    """The values of the properties in `FrameProperties`, for one frame."""

    size: tuple[int, int]
    lens: Mapping[str, object]
    depth_range_m: DepthRange | None
    behind: tuple[str, ...] = ()


class FrameProperties(ABC):
    """The properties of a frame; a source has those of its first frame.

    They read files, and draw a scene to find its depths. They raise HeatlensError if that fails.
    """

    @abstractmethod
    def _facts(self) -> FrameFacts:
        """Return the facts. Raises InputError if a file cannot be read."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the array that `render` returns, with any overscan, at proxy 1."""
        return self._facts_in_python_words().size

    @property
    def lens(self) -> Mapping[str, object]:
        """The lens values in the shot file, the header or the scene's camera.

        Fields of `Lens` with their values; those that are missing have to be given to `render`.
        """
        return self._facts_in_python_words().lens

    @property
    def depth_range_m(self) -> DepthRange | None:
        """The nearest and the farthest distance of a surface; None if there are no distances."""
        return self._facts_in_python_words().depth_range_m

    @property
    def behind(self) -> tuple[str, ...]:
        """The known surfaces behind the picture: a sentence for each place they come from."""
        return self._facts_in_python_words().behind

    def _facts_in_python_words(self) -> FrameFacts:
        """Return the facts; errors name arguments of Python instead of options."""
        with errors_with_python_names():
            return self._facts()


@dataclass(frozen=True)
class Frame(FrameProperties):
    """One frame of a source; `number` is its frame number."""

    number: int
    _facts_at: Callable[[int], FrameFacts]
    _render: Callable[..., FloatArray]

    def _facts(self) -> FrameFacts:
        return self._facts_at(self.number)

    def render(self, lens: Lens | None = None, **given: Unpack[FrameOptions]) -> FloatArray:
        """Return the picture with the lens; `given` as in `Source.render`, without `frame`."""
        return self._render(lens, frame=self.number, **given)


def facts_of(plate: Plate, lens: Mapping[str, object] | None = None) -> FrameFacts:
    """Return the values of a plate; `lens` holds those of its shot file, if it has one."""
    if lens is None:
        header = {name: getattr(plate.camera, name) for name in NEEDED}
        lens = {name: value for name, value in header.items() if value is not None}
    height, width = plate.color.shape[:2]
    depth_range_m = (plate.depth.near_m, plate.depth.far_m) if plate.has_distances else None
    return FrameFacts(
        (width, height), lens, depth_range_m, tuple(it.sentence for it in plate.behind)
    )


def check_frame(text: str, frame: int, frames: tuple[int, ...], sequence_name: str = "") -> None:
    """Raise InputError if a source has no such frame.

    `text` is the name of the source, `sequence_name` that of its sequence, if any.
    """
    if frame in frames:
        return
    if frames == (1,) or sequence_name:
        advice = f", or open {sequence_name} for its sequence" if sequence_name else ""
        raise InputError(f"{text} is a single picture: leave frame out{advice}.")
    raise InputError(f"{text} has no frame {frame}: there are {frames_text(frames) or 'none'}.")
