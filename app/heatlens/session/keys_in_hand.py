"""What every drag of keys has in common: it goes on from a shot, and becomes one step of undo."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from heatlens.model.shot import Shot
from heatlens.session.editing import Editing
from heatlens.session.key_commands import KeyCommands


class HeldKeys(Protocol):
    """What the button that went down took hold of."""

    @property
    def shot(self) -> Shot:
        """The shot as it was then."""


Held = TypeVar("Held", bound=HeldKeys)


class KeysInHand(Generic[Held]):
    """Keys that are held, from the press of a button until it is let go."""

    def __init__(self, editing: Editing, keys: KeyCommands, say: Callable[[str], None]) -> None:
        self._editing = editing
        self._keys = keys
        self._say = say
        self._held: Held | None = None

    def release(self) -> None:
        """Make what was dragged a step, and say which keys it has replaced."""
        if self._held is not None:
            self._keys.tell_of_replaced(self._held.shot)
            self._held = None
            self._editing.settle()
