"""Decide what to render next, as a pure function of the state.

The order is always the same. First the plate, until it is good enough to be worth a blur: of a
scene that means large and antialiased. Then the pictures of the comparison's sides, in turns. Then
the frames that will be played, while nothing else is to do.
"""

from dataclasses import dataclass
from enum import Enum, auto


@dataclass(frozen=True)
class PlateState:
    """The picture without a lens.

    is_there   one lies on the GPU
    is_good    it is worth a blur
    is_whole   it is as good as it gets
    is_asked   the sides know it: their pictures are, or will be, made of it
    wait_s     until it can be made better; None: it cannot
    """

    is_there: bool
    is_good: bool
    is_whole: bool
    is_asked: bool
    wait_s: float | None


@dataclass(frozen=True)
class SideState:
    """One side of the comparison.

    is_done   its whole picture is there, or cannot be rendered
    has_work  there is a picture to go on with, as good as the plate is now
    wait_s    until work on it may go on: the hand has to rest first
    """

    is_done: bool
    has_work: bool
    wait_s: float


@dataclass(frozen=True)
class WorkState:
    """The state that decides what to render next.

    plays_rendered  frames are played that were rendered before: nothing else is needed
    sides           A, and B while it is rendered
    turn            the index of the side whose turn it is
    frames_wait_s   until a frame can be rendered ahead; None: there is none to render
    """

    plays_rendered: bool
    plate: PlateState
    sides: tuple[SideState, ...]
    turn: int
    frames_wait_s: float | None


class Work(Enum):
    """What there is to work on."""

    NOTHING = auto()
    PLATE = auto()
    SIDE = auto()
    FRAMES = auto()


@dataclass(frozen=True)
class NextWork:
    """The next piece of work.

    wait_s  until it may begin, 0 where it may now; None: not before something changes
    side    the index of the side, for SIDE
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
    side = _next_side(state) if state.plate.is_there and state.plate.is_good else None
    if side is None:
        return NextWork(Work.PLATE, state.plate.wait_s)
    return NextWork(Work.SIDE, state.sides[side].wait_s, side)


def _next_side(state: WorkState) -> int | None:
    """Return the side whose turn it is, where it has work, else another one that has."""
    ready = [index for index, side in enumerate(state.sides) if side.has_work]
    return state.turn if state.turn in ready else next(iter(ready), None)
