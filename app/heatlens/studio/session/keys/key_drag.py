"""Select, drag and stretch keys with the mouse: click, selection box, drag. Drawing is elsewhere.

Stretching scales the frames of the chosen keys about the first or last one. Each step of a drag
starts from the shot at its beginning, so that keys that the dragged ones pass over are restored.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Literal, TypeVar

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.interpolation import Ease
from heatlens.core.model.shot.framing import PoseKey
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.keys.key_choice import (
    Chosen,
    KeyId,
    all_keys,
    checked,
    frames_of,
    rippled,
)
from heatlens.studio.session.keys.key_commands import KeyCommands
from heatlens.studio.session.keys.key_rows import ROWS, keyed_of, keys_of, with_keyed, with_pasted
from heatlens.studio.session.messages import reported
from heatlens.studio.session.shot.editing import Editing


@dataclass(frozen=True)
class HeldKeys:
    """The shot and the chosen keys at the press of the mouse button."""

    shot: Shot
    chosen: Chosen


Held = TypeVar("Held", bound=HeldKeys)


class KeysInHand(Generic[Held]):
    """A drag of keys, from the press of the mouse button to its release."""

    def __init__(self, editing: Editing, keys: KeyCommands, say: Callable[[str], None]) -> None:
        self._editing, self._keys, self._say = editing, keys, say
        self._held: Held | None = None

    def release(self) -> None:
        """End the drag as one undo step, and report keys that it has replaced."""
        if self._held is not None:
            self._keys.tell_of_replaced(self._held.shot)
            self._held = None
            self._editing.settle()

    def _show(self, changed: Callable[[], tuple[Shot, Chosen]]) -> None:
        """Show the shot and the chosen keys as dragged; report why if they are impossible."""
        with reported(self._say):
            shot, chosen = changed()
            self._editing.edit(shot)
            self._keys.choose(chosen)


Place = tuple[float, float]
Places = dict[KeyId, Place]  # the screen position of every key
# (shot, chosen keys, frames to move by, screen units moved upwards) -> new shot and chosen keys
Move = Callable[[Shot, Chosen, int, float], tuple[Shot, Chosen]]


@dataclass(frozen=True)
class _Held(HeldKeys):
    """What is dragged, and where it was taken."""

    kind: Literal["move", "ripple", "box"]
    at: Place
    key: KeyId | None = None


class KeyDrag(KeysInHand[_Held]):
    """Follows the mouse over keys: `press`, then `drag` in every frame, then `release`."""

    @property
    def box_from(self) -> Place | None:
        """The corner where the current selection box begins; None without one."""
        return self._held.at if self._held is not None and self._held.kind == "box" else None

    @property
    def is_holding(self) -> bool:
        """True while the mouse button is down."""
        return self._held is not None

    def press(self, at: Place, places: Places, reach: float, shift: bool, ctrl: bool) -> None:
        """Begin to drag the nearest key within `reach` screen units, or begin a selection box."""
        keys, shot = self._keys, self._editing.shot
        self._editing.settle()
        key = nearest(at, places, reach)
        if key is None:
            keys.choose(keys.chosen if shift else frozenset())
            self._held = _Held(shot, keys.chosen, "box", at)
            return
        self._keys.rows.choose(key.row)
        if shift:
            keys.choose(keys.chosen ^ {key})
        elif key not in keys.chosen:
            keys.choose(frozenset({key}))
        self._held = _Held(shot, keys.chosen, "ripple" if ctrl else "move", at, key)

    def drag(self, at: Place, places: Places, per_frame: float, move: Move) -> None:
        """Follow the pointer."""
        held = self._held
        if held is None:
            return
        keys = self._keys
        if held.kind == "box":
            keys.choose(held.chosen | inside(held.at, at, places))
            return
        frames, up = round((at[0] - held.at[0]) / per_frame), held.at[1] - at[1]
        if held.kind == "ripple" and held.key is not None:
            first, by_frames = held.key.frame, max(frames, -self._room(held))
            self._show(lambda: (rippled(held.shot, first, by_frames), frozenset()))
        else:
            self._show(lambda: move(held.shot, held.chosen, frames, up))

    def _room(self, held: _Held) -> int:
        """Return how many frames earlier the keys can move until they meet the previous one."""
        assert held.key is not None
        earlier = [key.frame for key in all_keys(held.shot) if key.frame < held.key.frame]
        return int(held.key.frame - max(earlier)) - 1 if earlier else 10**6


def nearest(at: Place, places: Places, reach: float) -> KeyId | None:
    """Return the nearest key within a square around the pointer; None if there is none."""
    near = [key for key, p in places.items() if max(abs(p[0] - at[0]), abs(p[1] - at[1])) <= reach]
    return min(
        near, key=lambda k: abs(places[k][0] - at[0]) + abs(places[k][1] - at[1]), default=None
    )


def inside(corner: Place, other: Place, places: Places) -> Chosen:
    """Return the keys in a box."""
    (x0, x1), (y0, y1) = (sorted(pair) for pair in zip(corner, other, strict=True))
    return frozenset(k for k, (x, y) in places.items() if x0 <= x <= x1 and y0 <= y <= y1)


@dataclass(frozen=True)
class Ends:
    """The frames of the first and the last chosen key."""

    first: float
    last: float


def ends_of(chosen: Chosen) -> Ends | None:
    """Return the ends of the chosen keys; None if they all lie at one frame."""
    frames = sorted({key.frame for key in chosen})
    return Ends(frames[0], frames[-1]) if len(frames) > 1 else None


def stretched(shot: Shot, chosen: Chosen, ends: Ends) -> tuple[Shot, Chosen]:
    """Scale the chosen keys to reach from `ends.first` to `ends.last`; remove keys they land on.

    The shape of the curve stays: inner handles become flatter if the pull takes longer. Keys
    between the ends move to whole frames unless two would meet. Raise LensError if the keys give
    an impossible lens.
    """
    before = ends_of(chosen)
    if before is None:
        return shot, chosen
    factor = (ends.last - ends.first) / (before.last - before.first)
    place = _places(chosen, before, ends, factor)
    for row in ROWS:
        frames = frames_of(chosen, row)
        keys = [key for key in keys_of(shot, row) if key.frame in frames]
        if keys:
            moved = [_moved(key, place, before, factor) for key in keys]
            shot = with_pasted(shot, row, moved, 0)
            keyed, left = keyed_of(shot, row), set(frames) - {key.frame for key in moved}
            shot = shot if keyed is None else with_keyed(shot, row, keyed.without_keys(left))
    return checked(shot), frozenset(KeyId(key.row, place[key.frame]) for key in chosen)


def _places(chosen: Chosen, before: Ends, ends: Ends, factor: float) -> dict[float, float]:
    """Map each old frame to its new one, rounded unless two keys would meet on one frame."""
    frames = sorted({key.frame for key in chosen})
    exact = {frame: ends.first + (frame - before.first) * factor for frame in frames}
    exact |= {before.first: ends.first, before.last: ends.last}
    whole = {frame: float(round(at)) for frame, at in exact.items()}
    whole |= {before.first: ends.first, before.last: ends.last}
    return whole if len(set(whole.values())) == len(frames) else exact


def _moved(
    key: Key | PoseKey, place: dict[float, float], before: Ends, factor: float
) -> Key | PoseKey:
    """Return a key at its new frame; its handles towards the other keys keep the shape."""
    if isinstance(key, PoseKey):
        return replace(key, frame=place[key.frame])
    return replace(
        key,
        frame=place[key.frame],
        ease_in=key.ease_in if key.frame == before.first else _slower(key.ease_in, factor),
        ease_out=key.ease_out if key.frame == before.last else _slower(key.ease_out, factor),
    )


def _slower(ease: Ease, factor: float) -> Ease:
    return replace(ease, speed_per_frame=ease.speed_per_frame / factor)


@dataclass(frozen=True)
class _HeldEnd(HeldKeys):
    """The dragged end, and both ends at the press of the mouse button."""

    is_last: bool
    ends: Ends


class KeyStretch(KeysInHand[_HeldEnd]):
    """Follows the mouse while it drags an end: `press`, then `drag`, then `release`."""

    @property
    def ends(self) -> Ends | None:
        """The ends of the chosen keys; None if there is nothing to stretch."""
        return ends_of(self._keys.chosen)

    def press(self, is_last: bool) -> None:
        """Begin to drag the last or the first end."""
        ends = self.ends
        if ends is not None:
            self._editing.settle()
            self._held = _HeldEnd(self._editing.shot, self._keys.chosen, is_last, ends)

    def drag(self, frame: int) -> None:
        """Move the end to a frame, at least one frame from the other end."""
        held = self._held
        if held is None:
            return
        first, last = held.ends.first, held.ends.last
        ends = (
            Ends(first, max(frame, first + 1)) if held.is_last else Ends(min(frame, last - 1), last)
        )
        self._show(lambda: stretched(held.shot, held.chosen, ends))
