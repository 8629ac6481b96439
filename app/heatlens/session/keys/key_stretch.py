"""Stretch a pull in time: scale the frames of the chosen keys about the first or last one.

Each step of a drag starts from the shot at its beginning, so that keys that the dragged ones pass
over are restored.
"""

from dataclasses import dataclass, replace

from heatlens.model.curves.curve import Key
from heatlens.model.curves.interpolation import Ease
from heatlens.model.shot.framing import PoseKey
from heatlens.model.shot.shot import Shot
from heatlens.session.keys.key_choice import Chosen, KeyId, checked, frames_of
from heatlens.session.keys.key_drag import HeldKeys, KeysInHand
from heatlens.session.keys.key_rows import ROWS, keyed_of, keys_of, with_keyed, with_pasted


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
class _Held(HeldKeys):
    """The dragged end, and both ends at the press of the mouse button."""

    is_last: bool
    ends: Ends


class KeyStretch(KeysInHand[_Held]):
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
            self._held = _Held(self._editing.shot, self._keys.chosen, is_last, ends)

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
