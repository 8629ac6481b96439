"""The state of a session in one frozen record, from which front ends take what they show."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.focus.coc import far_limit_m, hyperfocal_m, near_limit_m
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.core.model.view.view import ViewState
from heatlens.core.model.view.view_geometry import PictureShape
from heatlens.studio.board.command import Command
from heatlens.studio.board.facts import Facts


@dataclass(frozen=True)
class MarkState:
    """A mark with its distance at this frame; None where it is outside the picture."""

    name: str
    distance_m: float | None


@dataclass(frozen=True)
class CommandState:
    """A named command: whether it is on (None: it is not a switch), and why it is barred, or ""."""

    name: str
    label: str
    is_on: bool | None
    barred: str


IS_OBJECT = "is_object"  # marks a field whose object no JSON can hold


# A state has no field that changes by itself, such as a time: the board returns the last state
# again while nothing has changed, and its JSON is then not made anew.
@dataclass(frozen=True)
class State:
    """The state of a session that a front end shows.

    source        the name of the open source; "" for none
    opening       the name of the source that is being opened; "" for none
    title         the name of the document, with a star for unsaved changes
    message       the sentence in the status bar, or ""
    is_problem    the message is about an error
    frame         the frame at the playhead
    first, last   the frames that are played
    direction     1 while playing, -1 backwards, 0 at rest
    lens          the lens at the playhead; None if it has none
    near_m, far_m the limits of the sharp range; None without a lens
    marks, looks  those of the shot
    size_px       width and height of the picture; None before the first
    is_whole      the picture is complete, no preview
    picture       a number that changes with the picture
    shape         the shape of the display window; one pixel while nothing is open
    offset_m      the amount by which displayed distances exceed those from the pupil
    hyperfocal_m  None where the keys give no possible lens
    keyed_focus_m the focus of the keys, where the lens has another one; else None
    focus_keys    the frames of the keys of the focus
    timecode      that of the frame; None without one
    recording     the stage of the recording of a pull, in lower case
    beats_left    the number of the count-in before a pull is recorded; 0 without one
    recorded_keys the number of keys in a recorded pull
    has_camera    a camera that can move is open
    part_done     how much of the picture is rendered, 0 to 1; None once it is complete
    histogram     that of the distances in the picture; None if it has none
    """

    source: str
    opening: str
    title: str
    message: str
    is_problem: bool
    frame: int
    first: int
    last: int
    direction: int
    lens: Lens | None
    near_m: float | None
    far_m: float | None
    blur: DefocusSettings
    view: ViewState
    marks: tuple[MarkState, ...]
    looks: tuple[Look, ...]
    size_px: tuple[int, int] | None
    is_whole: bool
    picture: int
    commands: tuple[CommandState, ...]
    shape: PictureShape
    offset_m: float
    hyperfocal_m: float | None
    keyed_focus_m: float | None
    focus_keys: tuple[float, ...]
    frames_per_second: float
    timecode: str | None
    recording: str
    beats_left: int
    recorded_keys: int
    has_camera: bool
    part_done: float | None
    histogram: DepthHistogram | None = field(metadata={IS_OBJECT: True})


class CommandStates:
    """The states of commands; that of a command that is as before is the same object."""

    def __init__(self, commands: Sequence[Command]) -> None:
        """Take the commands whose states are asked for."""
        self._commands = commands
        self._states: list[CommandState] = []
        self._changing = [
            (index, command)
            for index, command in enumerate(commands)
            if command.is_on or command.barred or command.label
        ]

    def present(self) -> tuple[CommandState, ...]:
        """Return the states now, in the order of the commands."""
        if not self._states:
            self._states = [_of_command(command) for command in self._commands]
        for index, command in self._changing:
            state = _of_command(command)
            if state != self._states[index]:
                self._states[index] = state
        return tuple(self._states)


def state_of(facts: Facts, commands: tuple[CommandState, ...], picture: int) -> State:
    """Return the present facts, with the states of the commands and the number of the picture."""
    lens, shot, seen = _possible_lens(facts), facts.shot, facts.shown_picture
    return State(
        source=shot.source or "",
        opening=facts.opening,
        title=facts.title,
        message=facts.message,
        is_problem=facts.is_problem,
        frame=facts.frame,
        first=facts.played.first,
        last=facts.played.last,
        direction=facts.direction,
        lens=lens,
        near_m=None if lens is None else near_limit_m(lens),
        far_m=None if lens is None else far_limit_m(lens),
        blur=shot.defocus,
        view=facts.view,
        marks=tuple(MarkState(mark.name, at_m) for mark, at_m in facts.mark_distances_m),
        looks=shot.looks,
        size_px=None if seen is None else seen.texture.size,
        is_whole=facts.is_whole,
        picture=picture,
        commands=commands,
        shape=facts.shape,
        offset_m=facts.lens.measuring_offset_m,
        hyperfocal_m=_hyperfocal_m(facts.lens),
        keyed_focus_m=None if lens is None else facts.keyed_focus_m,
        focus_keys=tuple(key.frame for key in shot.curves.focus_distance_m.keys),
        frames_per_second=shot.frames_per_second,
        timecode=facts.timecode,
        recording=facts.recording.name.lower(),
        beats_left=facts.beats_left,
        recorded_keys=facts.recorded_keys,
        has_camera=facts.has_camera,
        part_done=facts.part_done,
        histogram=facts.histogram,
    )


def _possible_lens(facts: Facts) -> Lens | None:
    """Return the lens; None if there is none, or it is impossible at this frame."""
    try:
        return facts.lens if facts.has_lens else None
    except HeatlensError:  # between two keys of a long lens and a near focus
        return None


def _hyperfocal_m(lens: Lens) -> float | None:
    """Return the hyperfocal distance; None for an impossible lens."""
    try:
        return hyperfocal_m(lens)
    except HeatlensError:  # between two keys, the lens may be impossible
        return None


def _of_command(command: Command) -> CommandState:
    is_on = None if command.is_on is None else bool(command.is_on())
    return CommandState(command.name, label=command.shown, is_on=is_on, barred=command.why_not())
