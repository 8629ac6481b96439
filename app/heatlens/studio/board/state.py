"""The state of a session as plain values, for front ends without access to its objects."""

from collections.abc import Sequence
from dataclasses import dataclass

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.view.view import ViewState
from heatlens.studio.board.command import Command
from heatlens.studio.session.session import Session


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
    looks: tuple[str, ...]
    size_px: tuple[int, int] | None
    is_whole: bool
    picture: int
    commands: tuple[CommandState, ...]


def state_of(session: Session, commands: Sequence[Command], picture: int) -> State:
    """Return the state of the session now.

    `commands` are the named commands, and `picture` is the number of the picture.
    """
    facts, timeline, seen = session.facts, session.time.timeline, session.facts.shown_picture
    lens, shot, marks = _lens(session), facts.shot, session.time.marks
    return State(
        source=shot.source or "",
        opening=session.source.opener.opening or "",
        title=session.files.documents.window_title,
        message=session.messages.text,
        is_problem=session.messages.is_problem,
        frame=facts.frame,
        first=timeline.played.first,
        last=timeline.played.last,
        direction=timeline.playback.direction,
        lens=lens,
        near_m=None if lens is None else near_limit_m(lens),
        far_m=None if lens is None else far_limit_m(lens),
        blur=shot.defocus,
        view=facts.view,
        marks=tuple(MarkState(mark.name, marks.distances.distance_m(mark)) for mark in shot.marks),
        looks=tuple(look.name for look in shot.looks),
        size_px=None if seen is None else seen.texture.size,
        is_whole=seen is not None and seen.is_whole and not session.time.scheduler.is_rendering,
        picture=picture,
        commands=tuple(_of_command(command) for command in commands),
    )


def _lens(session: Session) -> Lens | None:
    try:
        return session.facts.lens if session.facts.has_lens else None
    except HeatlensError:  # between two keys of a long lens and a near focus
        return None


def _of_command(command: Command) -> CommandState:
    is_on = None if command.is_on is None else bool(command.is_on())
    return CommandState(command.name, command.shown, is_on, command.why_not())
