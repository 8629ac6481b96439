"""Render the visible pictures in short time slices.

What to render next is decided by a pure function of the state, `next_work`. The order is always the
same: first the quick answer to a change; then the plate, until it is good enough to be blurred (a
scene must be drawn large and antialiased); then the pictures of the comparison's sides, in turns;
then, while there is nothing else to do, the first preview of a drag, and the frames to be played.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.base.messages import Worker
from heatlens.core.model.view.picture_view import PictureView
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.preview.speed import Speed
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.pictures.compare_sides import CompareSides, Side
from heatlens.studio.session.pictures.live_picture import PlateVersion
from heatlens.studio.session.playing.frames_ahead import FramesAhead
from heatlens.studio.session.shared import Commands, Shared


@dataclass(frozen=True)
class PlateState:
    """The state of the picture before the blur.

    exists        there is a picture on the GPU
    is_good       it is good enough to be blurred
    is_whole      it has its final quality
    is_requested  the sides were requested to render from it
    wait_s        seconds until it can be improved; None if it cannot
    """

    exists: bool
    is_good: bool
    is_whole: bool
    is_requested: bool
    wait_s: float | None


@dataclass(frozen=True)
class SideState:
    """The state of one side of the comparison.

    is_finished   its whole picture is finished, or cannot be rendered
    has_work      there is a picture to continue, at the present quality of the plate
    wait_s        seconds until work may continue, because the input has to rest first
    is_answering  there is no picture of the latest change yet, not even a quick one
    """

    is_finished: bool
    has_work: bool
    wait_s: float
    is_answering: bool = False


@dataclass(frozen=True)
class WorkState:
    """The state that decides what to render next.

    plays_rendered  frames rendered before are playing, so that nothing has to be rendered
    sides           A, and B while it is rendered
    turn_index      the index of the side whose turn it is
    frames_wait_s   seconds until something unseen can be rendered; None if nothing is left
    """

    plays_rendered: bool
    plate: PlateState
    sides: tuple[SideState, ...]
    turn_index: int
    frames_wait_s: float | None


class Work(Enum):
    """What to work on next: nothing, the plate, a side of the comparison, or what is unseen."""

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
    is_plate_finished = plate.is_whole and plate.is_requested
    return not (is_plate_finished and all(side.is_finished for side in sides))


# The answer to a change comes first, because the user waits for it. It continues in slices between
# two checks of the input: the first pictures of a driver build dozens of programs, and in one piece
# they would block the window for 3 to 4 s. Then the plate becomes finer. Frames ahead come last,
# because they may be needed later and the visible picture is needed now.
def next_work(state: WorkState) -> NextWork:
    """Return what to work on next, and in how many seconds it may begin."""
    if state.plays_rendered:
        return NextWork(Work.NOTHING, None)
    if not is_rendering(state.plate, state.sides):
        wait_s = state.frames_wait_s
        return NextWork(Work.NOTHING if wait_s is None else Work.FRAMES, wait_s)
    side = _next_side(state) if state.plate.exists else None
    if side is None:
        return NextWork(Work.PLATE, state.plate.wait_s)
    return NextWork(Work.SIDE, state.sides[side].wait_s, side)


# A scene is blurred only once it is good, because a film picture of few antialiasing views would
# only be replaced by one of 64. An answer does not wait for that, as a quick picture of a coarse
# plate is better than none.
def _next_side(state: WorkState) -> int | None:
    """Return the side to render, preferably the one whose turn it is; None if the plate is next.

    A side that answers a change comes first and does not wait until the plate is good.
    """
    sides = tuple(enumerate(state.sides))
    ready = [index for index, side in sides if side.has_work and side.is_answering]
    if not ready and state.plate.is_good:
        ready = [index for index, side in sides if side.has_work]
    return state.turn_index if state.turn_index in ready else next(iter(ready), None)


# Longest slice of rendering before the loop handles input again. A slice ends only after its
# current step, so with steps of up to 18 ms, input is handled every 30 ms. While a scene rests, its
# steps take up to `scene_preview.SLOW_S`.
_SLICE_S = 0.012


class VisibleWork:
    """Determines the work that is left for the visible pictures."""

    def __init__(self, source: OpenSource, sides: CompareSides) -> None:
        self._source = source
        self._sides = sides

    @property
    def is_rendering(self) -> bool:
        """True while a visible picture is not complete."""
        return is_rendering(self.plate, self.sides)

    @property
    def plate(self) -> PlateState:
        """The state of the picture before the lens."""
        source = self._source
        is_requested = (
            source.plate is None or self._sides.a.requested_plate == source.picture.version
        )
        return PlateState(
            exists=source.plate is not None,
            is_good=source.feed.is_good,
            is_whole=source.feed.is_whole,
            is_requested=is_requested,
            wait_s=source.feed.seconds_until_needed(),
        )

    @property
    def sides(self) -> tuple[SideState, ...]:
        """The states of the pictures through the lens."""
        return tuple(self._side_state(side) for side in self._sides.active_sides)

    def _side_state(self, side: Side) -> SideState:
        """Return the state of one side of the comparison."""
        has_work = side.has_work(self._source.feed.is_whole)
        wait_s = side.seconds_to_rest()
        return SideState(not side.is_working, has_work, wait_s, side.is_answering)


class RenderScheduler(Commands, Worker):
    """Answers changes at once as well as time allows, and continues with `next_work`."""

    def __init__(
        self,
        shared: Shared,
        sides: CompareSides,
        visible: VisibleWork,
        frames_ahead: FramesAhead,
        view: PictureView,
        speed: Speed,
    ) -> None:
        super().__init__(shared)
        self._sides, self._visible, self._frames_ahead = sides, visible, frames_ahead
        self._view, self._speed = view, speed
        self._show_error = shared.show_error

    # State

    @property
    def is_rendering(self) -> bool:
        """True while a visible picture is not complete."""
        return self._visible.is_rendering

    @property
    def is_working(self) -> bool:
        """True while there is a picture to continue: a visible one, or one to be played."""
        return not self._frames_ahead.plays_cached_frames and (
            self.is_rendering or self._rehearses or self._frames_ahead.has_work
        )

    @property
    def _rehearses(self) -> bool:
        """True while the first preview is rendered unseen, for who may drag next."""
        return self._speed.has_window and self._sides.rehearsal.is_due

    @property
    def shown_picture(self) -> ShownPicture | None:
        """The picture through the lens to show: the live one, or a cached frame in its place."""
        live_picture, frame = self._sides.a.output, self._editing.frame
        is_current = (
            live_picture is not None and live_picture.frame == frame and not self.is_rendering
        )
        if (
            is_current
            and self._source.is_settled_at(frame)
            and not self._frames_ahead.plays_cached_frames
        ):
            return live_picture
        return self._frames_ahead.screen.frame_at_playhead() or live_picture

    @property
    def picture_key(self) -> object:
        """A key that changes with the plate's picture or those of the sides."""
        return self._source.picture.version, self._sides.outputs

    @property
    def drawing_key(self) -> object:
        """A key that changes whenever there is something new to draw."""
        return self.picture_key, self._frames_ahead.frames_made, self._frames_ahead.is_counting

    # Work

    def update(self) -> None:
        """Answer a change of the shot with a picture that fits the time; report errors."""
        if not self._frames_ahead.plays_cached_frames:
            self._run_and_report(self._request_pictures)

    # The feed is updated here, at the last moment before the picture is requested. Otherwise an
    # undo after the scene was drawn would make the blur draw all 64 views of the new camera at
    # once, and the window would stand still meanwhile.
    def _request_pictures(self) -> None:
        """Update the plate at the playhead, and request the pictures of all sides from it."""
        source, shot, frame = self._source, self._editing.seen_shot, self._editing.frame
        source.feed.refresh()  # only now, so that a picture saved before was of the same frame
        source.feed.update(shot, frame)
        if source.plate is not None and source.is_settled_at(frame):
            plate = PlateVersion(source.picture.version, source.picture.is_finer)
            times = self._speed.budget_s, self._speed.answer_s
            drawn_shot, view = source.feed.drawn_shot(shot), self._view
            self._sides.request(view.state, drawn_shot, frame, times[0], plate, view.zoom, times[1])

    def work(self) -> None:
        """Continue the next piece of work for one slice; report errors."""
        self._run_and_report(self._continue_next)

    def _continue_next(self) -> None:
        """Continue a side, the plate or the frames ahead for one slice."""
        piece = self._next_piece
        if piece.work is Work.SIDE:
            self._sides.work(piece.side, _SLICE_S, self._source.feed.is_whole)
        elif piece.work is Work.PLATE:
            self._source.feed.refine(_SLICE_S)
        elif self._rehearses:
            self._sides.rehearsal.work(_SLICE_S)
        else:
            self._frames_ahead.work()

    def _run_and_report(self, function: Callable[[], None]) -> None:
        """Call a function and report its errors."""
        try:
            with report_faults("The picture could not be made"):
                function()
        except HeatlensError as error:
            self._show_error(error)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds that the loop may sleep; None: until something changes."""
        return self._next_piece.wait_s

    @property
    def _next_piece(self) -> NextWork:
        """The next piece of work, by the state of the visible pictures."""
        plate, sides = self._visible.plate, self._visible.sides
        frames_wait_s = None
        if not is_rendering(plate, sides):
            frames_wait_s = 0.0 if self._rehearses else self._frames_ahead.seconds_until_needed()
        plays = self._frames_ahead.plays_cached_frames
        return next_work(WorkState(plays, plate, sides, self._sides.turn_index, frames_wait_s))
