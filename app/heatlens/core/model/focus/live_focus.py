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

Distances = Mapping[int, float | None]  # meters by frame; None where the thing is hidden


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
                range_text = f"{option.least:g} to {option.most:g}"
                raise InputError(f"--{option.flag} must be {range_text}, got {value:g}.")


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
    """The distances of a mark at all frames of a shot, in meters; None where it is hidden."""

    mark: str
    distances_m: tuple[float | None, ...]

    def __post_init__(self) -> None:
        for distance_m in self.distances_m:
            if distance_m is not None and not distance_m > 0:
                raise InputError(
                    f"Mark {self.mark}: a distance must be above 0 m, got {distance_m:g}."
                )
        if not any(distance_m is not None for distance_m in self.distances_m):
            raise InputError(
                f"Mark {self.mark} is hidden, or out of the picture, at every frame: the focus "
                "cannot follow it."
            )


@dataclass(frozen=True, slots=True)
class LiveFocus:
    """A focus that follows marks, and is measured again when what they are on has changed.

    pursuits     the marks in the order in which they are followed
    follow       how the focus follows them
    first_frame  first frame of the measurement
    measured     the distances of each mark, over the same frames; () before the measurement
    measured_of  a text that identifies the state of the files that were measured
    """

    pursuits: tuple[Pursuit, ...]
    follow: Follow = Follow()
    first_frame: int = 0
    measured: tuple[MeasuredMark, ...] = ()
    measured_of: str = ""

    def __post_init__(self) -> None:
        self._check_pursuits()
        lengths = {len(mark.distances_m) for mark in self.measured}
        missing = set(self.marks) - {measured.mark for measured in self.measured}
        if self.measured and (missing or len(lengths) > 1):
            raise InputError(
                "The marks that the focus follows have distances at different frames: follow them "
                "again, so that all are measured at the same frames."
            )

    def _check_pursuits(self) -> None:
        """Raise InputError unless each pull starts after the one before it has arrived."""
        if not self.pursuits or self.pursuits[0].start_frame is not None:
            raise InputError(
                "A focus that follows needs at least one mark: the first without a start frame, "
                "each later one with it."
            )
        for before, after in pairwise(self.pursuits):
            if after.start_frame is None or after.frames < 1:
                raise InputError(
                    f"The pull to mark {after.mark} needs its start frame, and a length of 1 frame "
                    f"or more, as in {after.mark}@1040+18."
                )
            arrival_frame = (
                -np.inf if before.start_frame is None else before.start_frame + before.frames
            )
            if after.start_frame < arrival_frame:
                raise InputError(
                    f"The pull to mark {after.mark} starts at frame {after.start_frame}, before "
                    f"the one to mark {before.mark} ends at frame {arrival_frame}: start it later."
                )

    @property
    def marks(self) -> tuple[str, ...]:
        """The names of the marks that are followed."""
        return tuple(dict.fromkeys(pursuit.mark for pursuit in self.pursuits))

    @property
    def frames(self) -> range:
        """The frames that were measured; none before that."""
        count = len(self.measured[0].distances_m) if self.measured else 0
        return range(self.first_frame, self.first_frame + count)

    @property
    def words(self) -> str:
        """What is followed, such as "A, then B from 1020 on"."""
        later_pursuits = (
            f", then {pursuit.mark} from {pursuit.start_frame} on" for pursuit in self.pursuits[1:]
        )
        return self.pursuits[0].mark + "".join(later_pursuits)

    def rename_mark(self, old_name: str, new_name: str) -> "LiveFocus":
        """Return the live focus with another name for a mark."""
        return replace(
            self,
            pursuits=tuple(
                replace(pursuit, mark=new_name) if pursuit.mark == old_name else pursuit
                for pursuit in self.pursuits
            ),
            measured=tuple(
                replace(measured, mark=new_name) if measured.mark == old_name else measured
                for measured in self.measured
            ),
        )

    def add_pull(self, mark: str, start_frame: int, frames: int) -> "LiveFocus":
        """Return the live focus with a pull to another mark in `frames` frames from `start_frame`.

        Pulls that end after `start_frame` are left out.
        """
        earlier_pursuits = [
            pursuit
            for pursuit in self.pursuits
            if pursuit.start_frame is None or pursuit.start_frame + pursuit.frames <= start_frame
        ]
        is_measured = any(measured.mark == mark for measured in self.measured)
        return replace(
            self,
            pursuits=(*earlier_pursuits, Pursuit(mark, start_frame, frames)),
            measured=self.measured if is_measured else (),
        )

    def dioptres(
        self, half_sharp_dioptres: Sequence[float], frames_per_second: float
    ) -> list[float]:
        """Return the focus in dioptres at each measured frame.

        `half_sharp_dioptres` is half the sharp range at each of these frames.
        """
        step_most = self.follow.most_dioptres_per_s / frames_per_second
        tracks = {
            measured.mark: self._smooth_track(measured.distances_m, half_sharp_dioptres)
            for measured in self.measured
        }
        track = tracks[self.pursuits[0].mark]
        for pursuit in self.pursuits[1:]:
            assert pursuit.start_frame is not None
            progress = (np.array(self.frames) - pursuit.start_frame) / pursuit.frames
            shares = np.clip(progress, 0.0, 1.0)
            shares = shares * shares * (3.0 - 2.0 * shares)  # starts and ends gently
            next_track = tracks[pursuit.mark]
            track = [
                float(a + share * (b - a))
                for a, b, share in zip(track, next_track, shares, strict=True)
            ]
        return _limit_speed(track, step_most)

    # Small moves are ignored first, while the track is still that of the object. The delay and the
    # average come after that, because they imitate the hand of a person.
    def _smooth_track(
        self, distances_m: Sequence[float | None], half_sharp_dioptres: Sequence[float]
    ) -> list[float]:
        """Return the dioptres of a mark as the focus follows it, before the speed limit."""
        track = bridge_gaps(distances_m)
        track = _ignore_small_moves(
            track,
            [
                2.0 * self.follow.ignored_part * half_dioptres
                for half_dioptres in half_sharp_dioptres
            ],
        )
        return _average_track(_delay_track(track, self.follow.late_frames), self.follow.ease_frames)


def bridge_gaps(distances_m: Sequence[float | None]) -> list[float]:
    """Return the dioptres of distances, at least one of which is known.

    Gaps are bridged by a straight line; before the first and after the last distance they are held.
    """
    known_indices = [at for at, distance_m in enumerate(distances_m) if distance_m is not None]
    dioptres = [1.0 / distance_m for distance_m in distances_m if distance_m is not None]
    return [float(value) for value in np.interp(range(len(distances_m)), known_indices, dioptres)]


def _ignore_small_moves(track: list[float], slack: list[float]) -> list[float]:
    """Return the track without moves that are smaller than `slack` at their frame.

    The value stays until the track is farther from it than the slack, and then moves just enough.
    """
    value, steady_track = track[0], []
    for target, limit in zip(track, slack, strict=True):
        value = min(max(value, target - limit), target + limit)
        steady_track.append(value)
    return steady_track


def _delay_track(track: list[float], frames: int) -> list[float]:
    """Return the track moved later by `frames`; its ends are extended."""
    last = len(track) - 1
    return [track[min(max(index - frames, 0), last)] for index in range(len(track))]


def _average_track(track: list[float], radius: int) -> list[float]:
    """Return the running mean over equally many frames before and after."""
    averages = []
    for index in range(len(track)):
        window = min(radius, index, len(track) - 1 - index)
        averages.append(fmean(track[index - window : index + window + 1]))
    return averages


def _limit_speed(track: list[float], step_most: float) -> list[float]:
    """Return the track with no step larger than `step_most`; 0 for no limit."""
    value, limited_track = track[0], []
    for target in track if step_most else ():
        value += min(max(target - value, -step_most), step_most)
        limited_track.append(value)
    return limited_track or track
