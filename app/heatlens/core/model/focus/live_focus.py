"""A focus that follows marks through the frames: how it moves, and where the marks were measured.

The steps are those of an assistant's hand: it bridges what is hidden, ignores small moves, is late
or early, moves gently, and is no faster than the ring turns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from statistics import fmean

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import option_field, options_of

Distances = Mapping[int, float | None]  # metres by frame; None where the thing is hidden


@dataclass(frozen=True, slots=True)
class Follow:
    """How the focus follows an object. Raises InputError for a number outside its range."""

    ignored_part: float = option_field(
        0.125,
        "follow ignores",
        "ignore movements smaller than this share of the sharp range, 0 to 0.5 (default 0.125); "
        "reducing the curve to few keys may add as much error again",
        metavar="PART",
        least=0,
        most=0.5,
        tip="Movements smaller than this share of the sharp range are ignored.",
    )
    late_frames: int = option_field(
        0,
        "follow late",
        "frames by which the focus is late, like that of a person; negative: early (default 0)",
        metavar="FRAMES",
        least=-1000,
        most=1000,
        slider=(-24, 24),
        shown="%.0f frames",
        tip="Frames by which the focus is late, like that of a person; below 0: early.",
    )
    ease_frames: int = option_field(
        0,
        "follow ease",
        "frames averaged before and after each frame, so that the focus starts and stops gently "
        "(default 0)",
        metavar="FRAMES",
        least=0,
        most=1000,
        slider=(0, 24),
        shown="%.0f frames",
        tip="Frames averaged before and after, so that the focus starts and stops gently.",
    )
    most_dioptres_per_s: float = option_field(
        0.0,
        "follow speed",
        "highest speed of the focus, in dioptres per second (default: no limit)",
        metavar="DIOPTRES",
        least=0,
        most=1000,
        slider=(0, 4),
        shown="%.2f D/s",
        tip="Highest speed of the focus, in dioptres per second; 0 for no limit.",
    )

    def __post_init__(self) -> None:
        for name, option in options_of(Follow).items():
            if not option.allows(value := getattr(self, name)):
                span = f"{option.least:g} to {option.most:g}"
                raise InputError(f"--{option.flag} must be {span}, got {value:g}.")


@dataclass(frozen=True, slots=True)
class Pursuit:
    """A mark that is followed, from a frame on.

    mark         its name
    start_frame  where the focus leaves the mark before; None for the first one
    frames       how long it takes to arrive
    """

    mark: str
    start_frame: int | None = None
    frames: int = 0


@dataclass(frozen=True, slots=True)
class MeasuredMark:
    """The distances of a mark at all frames of a shot, in metres; None where it is hidden."""

    mark: str
    distances_m: tuple[float | None, ...]

    def __post_init__(self) -> None:
        for far_m in self.distances_m:
            if far_m is not None and not far_m > 0:
                raise InputError(f"Mark {self.mark}: a distance must be above 0 m, got {far_m:g}.")
        if not any(far_m is not None for far_m in self.distances_m):
            raise InputError(
                f"Mark {self.mark} is hidden, or out of the picture, at every frame: the focus "
                "cannot follow it."
            )


@dataclass(frozen=True, slots=True)
class LiveFocus:
    """A focus that follows marks, and is measured again when what they are on has changed.

    pursuits     the marks in the order in which they are followed
    follow       how
    first_frame  of the measurement
    measured     of each mark, over the same frames; () before it was measured
    measured_of  tells the state of the files that were measured
    """

    pursuits: tuple[Pursuit, ...]
    follow: Follow = Follow()
    first_frame: int = 0
    measured: tuple[MeasuredMark, ...] = ()
    measured_of: str = ""

    def __post_init__(self) -> None:
        self._check_pursuits()
        lengths = {len(it.distances_m) for it in self.measured}
        missing = set(self.marks) - {it.mark for it in self.measured}
        if self.measured and (missing or len(lengths) > 1):
            raise InputError("The marks that are followed must all be measured at the same frames.")

    def _check_pursuits(self) -> None:
        if not self.pursuits or self.pursuits[0].start_frame is not None:
            raise InputError("A focus that follows begins with a mark, without a start frame.")
        for before, after in pairwise(self.pursuits):
            if after.start_frame is None or after.frames < 1:
                raise InputError(f"The pull to mark {after.mark} needs a start frame, and frames.")
            arrived = -np.inf if before.start_frame is None else before.start_frame + before.frames
            if after.start_frame < arrived:
                raise InputError(
                    f"The pull to mark {after.mark} starts at frame {after.start_frame}, before "
                    f"that to mark {before.mark} has ended."
                )

    @property
    def marks(self) -> tuple[str, ...]:
        """The names of the marks that are followed."""
        return tuple(dict.fromkeys(it.mark for it in self.pursuits))

    @property
    def frames(self) -> range:
        """The frames that were measured; none before that."""
        count = len(self.measured[0].distances_m) if self.measured else 0
        return range(self.first_frame, self.first_frame + count)

    @property
    def words(self) -> str:
        """What is followed, such as "A, then B from 1020 on"."""
        later = (f", then {it.mark} from {it.start_frame} on" for it in self.pursuits[1:])
        return self.pursuits[0].mark + "".join(later)

    def renamed(self, before: str, after: str) -> "LiveFocus":
        """Return the same with another name for a mark."""
        return replace(
            self,
            pursuits=tuple(
                replace(it, mark=after) if it.mark == before else it for it in self.pursuits
            ),
            measured=tuple(
                replace(it, mark=after) if it.mark == before else it for it in self.measured
            ),
        )

    def pulled_to(self, mark: str, start_frame: int, frames: int) -> "LiveFocus":
        """Return the same with a pull to another mark; those that end later are left out."""
        earlier = [
            it
            for it in self.pursuits
            if it.start_frame is None or it.start_frame + it.frames <= start_frame
        ]
        known = any(it.mark == mark for it in self.measured)
        return replace(
            self,
            pursuits=(*earlier, Pursuit(mark, start_frame, frames)),
            measured=self.measured if known else (),
        )

    def dioptres(self, sharp: Sequence[float], frames_per_second: float) -> list[float]:
        """Return the focus at each measured frame, given the half of its sharp range."""
        step = self.follow.most_dioptres_per_s / frames_per_second
        tracks = {it.mark: self._smooth(it.distances_m, sharp) for it in self.measured}
        track = tracks[self.pursuits[0].mark]
        for pursuit in self.pursuits[1:]:
            assert pursuit.start_frame is not None
            times = (np.array(self.frames) - pursuit.start_frame) / pursuit.frames
            parts = np.clip(times, 0.0, 1.0)
            parts = parts * parts * (3.0 - 2.0 * parts)
            after = tracks[pursuit.mark]
            track = [
                float(a + part * (b - a)) for a, b, part in zip(track, after, parts, strict=True)
            ]
        return _limited(track, step)

    # In this order: small moves of the thing are ignored first, while they are still those of the
    # thing; only then is the focus late and eased, as the hand of a person is.
    def _smooth(self, distances_m: Sequence[float | None], sharp: Sequence[float]) -> list[float]:
        track = bridged(distances_m)
        track = _settled(track, [2.0 * self.follow.ignored_part * part for part in sharp])
        return _eased(_late(track, self.follow.late_frames), self.follow.ease_frames)


def bridged(distances_m: Sequence[float | None]) -> list[float]:
    """Return the dioptres of distances, at least one of which is known.

    Gaps are bridged by a straight line; before the first and after the last distance they are held.
    """
    known = [at for at, far_m in enumerate(distances_m) if far_m is not None]
    places = [1.0 / far_m for far_m in distances_m if far_m is not None]
    return [float(place) for place in np.interp(range(len(distances_m)), known, places)]


def _settled(track: list[float], slack: list[float]) -> list[float]:
    """Return the track with moves ignored that are smaller than the slack at each frame."""
    at, settled = track[0], []
    for place, reach in zip(track, slack, strict=True):
        at = min(max(at, place - reach), place + reach)
        settled.append(at)
    return settled


def _late(track: list[float], frames: int) -> list[float]:
    last = len(track) - 1
    return [track[min(max(at - frames, 0), last)] for at in range(len(track))]


def _eased(track: list[float], reach: int) -> list[float]:
    """Return the running mean over equally many frames before and after."""
    eased = []
    for at in range(len(track)):
        near = min(reach, at, len(track) - 1 - at)
        eased.append(fmean(track[at - near : at + near + 1]))
    return eased


def _limited(track: list[float], step_most: float) -> list[float]:
    """Return the track with no step larger than `step_most`; 0 for no limit."""
    at, limited = track[0], []
    for place in track if step_most else ():
        at += min(max(place - at, -step_most), step_most)
        limited.append(at)
    return limited or track
