"""Select, drag and stretch keys with the mouse: click, selection box, drag. Drawing is elsewhere.

Stretching scales the frames of the chosen keys about the first or last one. Each step of a drag
starts from the shot at its beginning, so that keys that the dragged ones pass over are restored.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Literal, TypeVar

from heatlens.core.base.messages import report_errors
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.interpolation import Ease
from heatlens.core.model.keys.key_choice import (
    KeyId,
    KeySelection,
    all_keys,
    check_shot,
    frames_of,
    ripple_keys,
)
from heatlens.core.model.keys.key_rows import (
    ROWS,
    keyed_curve,
    keys_of,
    paste_into_row,
    with_keyed_curve,
)
from heatlens.core.model.shot.camera_track import PoseKey
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.keys.key_commands import KeyCommands
from heatlens.studio.session.shot.editing import Editing


@dataclass(frozen=True)
class DragStart:
    """The shot and the chosen keys at the press of the mouse button."""

    shot: Shot
    selection: KeySelection


Start = TypeVar("Start", bound=DragStart)


class KeyGesture(Generic[Start]):
    """A drag of keys, from the press of the mouse button to its release."""

    def __init__(self, editing: Editing, keys: KeyCommands, notify: Callable[[str], None]) -> None:
        self._editing, self._keys, self._notify = editing, keys, notify
        self._start: Start | None = None

    def release(self) -> None:
        """End the drag as one undo step, and report keys that it has replaced."""
        if self._start is not None:
            self._keys.report_replaced_keys(self._start.shot)
            self._start = None
            self._editing.settle()

    def _show_dragged(self, change: Callable[[], tuple[Shot, KeySelection]]) -> None:
        """Show the shot and the chosen keys as dragged; report why if they are impossible."""
        with report_errors(self._notify):
            shot, selection = change()
            self._editing.edit(shot)
            self._keys.select(selection)


Position = tuple[float, float]
KeyPositions = dict[KeyId, Position]  # the screen position of every key
# (shot, chosen keys, frames to move by, screen units moved upwards) -> new shot and chosen keys
Move = Callable[[Shot, KeySelection, int, float], tuple[Shot, KeySelection]]


@dataclass(frozen=True)
class _KeyDragStart(DragStart):
    """What is dragged, and where the pointer was at the press of the mouse button."""

    kind: Literal["move", "ripple", "box"]
    pointer: Position
    key: KeyId | None = None


class KeyDrag(KeyGesture[_KeyDragStart]):
    """Follows the mouse over keys: `press`, then `drag` in every frame, then `release`."""

    @property
    def box_corner(self) -> Position | None:
        """The corner where the current selection box begins; None without one."""
        return (
            self._start.pointer if self._start is not None and self._start.kind == "box" else None
        )

    @property
    def pressed_key(self) -> KeyId | None:
        """The key at which the mouse button was pressed; None without one."""
        return None if self._start is None else self._start.key

    @property
    def is_dragging(self) -> bool:
        """True while the mouse button is down."""
        return self._start is not None

    def press(
        self, pointer: Position, positions: KeyPositions, reach: float, shift: bool, ctrl: bool
    ) -> None:
        """Begin to drag the nearest key within `reach` screen units, or begin a selection box."""
        keys, shot = self._keys, self._editing.shot
        self._editing.settle()
        key = nearest_key(pointer, positions, reach)
        if key is None:
            keys.select(keys.selection if shift else frozenset())
            self._start = _KeyDragStart(shot, keys.selection, "box", pointer)
            return
        self._keys.rows.select(key.row)
        if shift:
            keys.select(keys.selection ^ {key})
        elif key not in keys.selection:
            keys.select(frozenset({key}))
        self._start = _KeyDragStart(
            shot, keys.selection, "ripple" if ctrl else "move", pointer, key
        )

    def drag(
        self, pointer: Position, positions: KeyPositions, per_frame: float, move: Move
    ) -> None:
        """Extend the box, or ripple or move the chosen keys, as far as the pointer has moved.

        `positions` are the screen positions of all keys, `per_frame` the screen units of one frame.
        `move` returns the shot with the chosen keys moved; see `Move`. A ripple moves the pressed
        key and all later ones, and leaves no key chosen.
        """
        start = self._start
        if start is None:
            return
        keys = self._keys
        if start.kind == "box":
            keys.select(start.selection | keys_in_box(start.pointer, pointer, positions))
            return
        frames = round((pointer[0] - start.pointer[0]) / per_frame)
        up = start.pointer[1] - pointer[1]
        if start.kind == "ripple" and start.key is not None:
            first, by_frames = start.key.frame, max(frames, -self._free_frames(start))
            self._show_dragged(lambda: (ripple_keys(start.shot, first, by_frames), frozenset()))
        else:
            self._show_dragged(lambda: move(start.shot, start.selection, frames, up))

    def _free_frames(self, start: _KeyDragStart) -> int:
        """Return how many frames earlier the keys can move until they meet the previous one."""
        assert start.key is not None
        earlier_frames = [key.frame for key in all_keys(start.shot) if key.frame < start.key.frame]
        return int(start.key.frame - max(earlier_frames)) - 1 if earlier_frames else 10**6


def nearest_key(pointer: Position, positions: KeyPositions, reach: float) -> KeyId | None:
    """Return the nearest key within a square around the pointer; None if there is none."""
    near_keys = [
        key
        for key, position in positions.items()
        if max(abs(position[0] - pointer[0]), abs(position[1] - pointer[1])) <= reach
    ]
    return min(
        near_keys,
        key=lambda key_id: (
            abs(positions[key_id][0] - pointer[0]) + abs(positions[key_id][1] - pointer[1])
        ),
        default=None,
    )


def keys_in_box(corner: Position, opposite: Position, positions: KeyPositions) -> KeySelection:
    """Return the keys whose position lies in the box between two opposite corners."""
    (x0, x1), (y0, y1) = (sorted(pair) for pair in zip(corner, opposite, strict=True))
    return frozenset(key for key, (x, y) in positions.items() if x0 <= x <= x1 and y0 <= y <= y1)


@dataclass(frozen=True)
class Ends:
    """The frames of the first and the last chosen key."""

    first: float
    last: float


def ends_of(selection: KeySelection) -> Ends | None:
    """Return the ends of the chosen keys; None if they all lie at one frame."""
    frames = sorted({key.frame for key in selection})
    return Ends(frames[0], frames[-1]) if len(frames) > 1 else None


def stretch_keys(shot: Shot, selection: KeySelection, ends: Ends) -> tuple[Shot, KeySelection]:
    """Scale the chosen keys to reach from `ends.first` to `ends.last`; remove keys they land on.

    The shape of the curve stays: inner handles become flatter if the pull takes longer. Keys
    between the ends move to whole frames unless two would meet. Raise LensError if the keys give
    an impossible lens.
    """
    old_ends = ends_of(selection)
    if old_ends is None:
        return shot, selection
    factor = (ends.last - ends.first) / (old_ends.last - old_ends.first)
    new_frames = _new_frames(selection, old_ends, ends, factor)
    for row in ROWS:
        frames = frames_of(selection, row)
        keys = [key for key in keys_of(shot, row) if key.frame in frames]
        if keys:
            moved_keys = [_move_key(key, new_frames, old_ends, factor) for key in keys]
            shot = paste_into_row(shot, row, moved_keys, 0)
            keyed = keyed_curve(shot, row)
            left_frames = set(frames) - {key.frame for key in moved_keys}
            shot = (
                shot
                if keyed is None
                else with_keyed_curve(shot, row, keyed.without_keys(left_frames))
            )
    return check_shot(shot), frozenset(KeyId(key.row, new_frames[key.frame]) for key in selection)


def _new_frames(
    selection: KeySelection, old_ends: Ends, ends: Ends, factor: float
) -> dict[float, float]:
    """Map each old frame to its new one, rounded unless two keys would meet on one frame."""
    frames = sorted({key.frame for key in selection})
    exact_frames = {frame: ends.first + (frame - old_ends.first) * factor for frame in frames}
    exact_frames |= {old_ends.first: ends.first, old_ends.last: ends.last}
    whole_frames = {frame: float(round(new_frame)) for frame, new_frame in exact_frames.items()}
    whole_frames |= {old_ends.first: ends.first, old_ends.last: ends.last}
    return whole_frames if len(set(whole_frames.values())) == len(frames) else exact_frames


def _move_key(
    key: Key | PoseKey, new_frames: dict[float, float], old_ends: Ends, factor: float
) -> Key | PoseKey:
    """Return a key at its new frame; its handles towards the other keys keep the shape."""
    if isinstance(key, PoseKey):
        return replace(key, frame=new_frames[key.frame])
    return replace(
        key,
        frame=new_frames[key.frame],
        ease_in=key.ease_in if key.frame == old_ends.first else _scale_ease(key.ease_in, factor),
        ease_out=key.ease_out if key.frame == old_ends.last else _scale_ease(key.ease_out, factor),
    )


def _scale_ease(ease: Ease, factor: float) -> Ease:
    """Return the ease of a segment that takes `factor` times as long."""
    return replace(ease, speed_per_frame=ease.speed_per_frame / factor)


@dataclass(frozen=True)
class _StretchStart(DragStart):
    """The dragged end, and both ends at the press of the mouse button."""

    is_last: bool
    ends: Ends


class KeyStretch(KeyGesture[_StretchStart]):
    """Follows the mouse while it drags an end: `press`, then `drag`, then `release`."""

    @property
    def ends(self) -> Ends | None:
        """The ends of the chosen keys; None if there is nothing to stretch."""
        return ends_of(self._keys.selection)

    def press(self, is_last: bool) -> None:
        """Begin to drag the last or the first end."""
        ends = self.ends
        if ends is not None:
            self._editing.settle()
            self._start = _StretchStart(self._editing.shot, self._keys.selection, is_last, ends)

    def drag(self, frame: int) -> None:
        """Move the end to a frame, at least one frame from the other end."""
        start = self._start
        if start is None:
            return
        first, last = start.ends.first, start.ends.last
        ends = (
            Ends(first, max(frame, first + 1))
            if start.is_last
            else Ends(min(frame, last - 1), last)
        )
        self._show_dragged(lambda: stretch_keys(start.shot, start.selection, ends))
