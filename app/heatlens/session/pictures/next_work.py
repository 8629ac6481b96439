"""Decide what to render next, as a pure function of the state.

The order is always the same: first the quick answer to a change; then the plate, until it is
good enough to be blurred (a scene must be drawn large and antialiased); then the pictures of the
comparison's sides, in turns; then, while there is nothing else to do, the frames that will be
played.
"""

from dataclasses import dataclass
from enum import Enum, auto


@dataclass(frozen=True)
class PlateState:
    """The state of the picture before the blur.

    is_there   there is a picture on the GPU
    is_good    it is good enough to be blurred
    is_whole   it has its final quality
    is_asked   the sides were requested to render from it
    wait_s     seconds until it can be improved; None if it cannot
    """

    is_there: bool
    is_good: bool
    is_whole: bool
    is_asked: bool
    wait_s: float | None


@dataclass(frozen=True)
class SideState:
    """The state of one side of the comparison.

    is_done       its whole picture is finished, or cannot be rendered
    has_work      there is a picture to continue, at the present quality of the plate
    wait_s        seconds until work may continue, because the input has to rest first
    is_answering  there is no picture of the latest change yet, not even a quick one
    """

    is_done: bool
    has_work: bool
    wait_s: float
    is_answering: bool = False


@dataclass(frozen=True)
class WorkState:
    """The state that decides what to render next.

    plays_rendered  frames rendered before are playing, so that nothing has to be rendered
    sides           A, and B while it is rendered
    turn            the index of the side whose turn it is
    frames_wait_s   seconds until a frame can be rendered ahead; None if there is none to render
    """

    plays_rendered: bool
    plate: PlateState
    sides: tuple[SideState, ...]
    turn: int
    frames_wait_s: float | None


class Work(Enum):
    """The kinds of work."""

    NOTHING = auto()
    PLATE = auto()
    SIDE = auto()
    FRAMES = auto()


@dataclass(frozen=True)
class NextWork:
    """The next piece of work.

    wait_s  seconds until it may begin, 0 for now; None: not before something changes
    side    the index of the side, for SIDE only
    """

    work: Work
    wait_s: float | None
    side: int = 0


def is_rendering(plate: PlateState, sides: tuple[SideState, ...]) -> bool:
    """Return True while a visible picture is not complete."""
    is_plate_done = plate.is_whole and plate.is_asked
    return not (is_plate_done and all(side.is_done for side in sides))


def next_work(state: WorkState) -> NextWork:
    """Return what to work on next, and when."""
    if state.plays_rendered:
        return NextWork(Work.NOTHING, None)
    if not is_rendering(state.plate, state.sides):
        wait_s = state.frames_wait_s
        return NextWork(Work.NOTHING if wait_s is None else Work.FRAMES, wait_s)
    side = _next_side(state) if state.plate.is_there else None
    if side is None:
        return NextWork(Work.PLATE, state.plate.wait_s)
    return NextWork(Work.SIDE, state.sides[side].wait_s, side)


def _next_side(state: WorkState) -> int | None:
    """Return the side to render, first the one whose turn it is; None if the plate is next.

    A side that answers a change comes first, whatever the plate, so as not to wait for a good one.
    """
    sides = tuple(enumerate(state.sides))
    ready = [index for index, side in sides if side.has_work and side.is_answering]
    if not ready and state.plate.is_good:
        ready = [index for index, side in sides if side.has_work]
    return state.turn if state.turn in ready else next(iter(ready), None)
