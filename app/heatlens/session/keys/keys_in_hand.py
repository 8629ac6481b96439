"""The base of all drags of keys: each starts from a shot and becomes one undo step."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from heatlens.model.shot import Shot
from heatlens.session.keys.key_commands import KeyCommands
from heatlens.session.shot.editing import Editing


class HeldKeys(Protocol):
    """The state at the press of the mouse button."""

    @property
    def shot(self) -> Shot:
        """The shot at that time."""


Held = TypeVar("Held", bound=HeldKeys)


class KeysInHand(Generic[Held]):
    """A drag of keys, from the press of the mouse button to its release."""

    def __init__(self, editing: Editing, keys: KeyCommands, say: Callable[[str], None]) -> None:
        self._editing = editing
        self._keys = keys
        self._say = say
        self._held: Held | None = None

    def release(self) -> None:
        """End the drag as one undo step, and report keys that it has replaced."""
        if self._held is not None:
            self._keys.tell_of_replaced(self._held.shot)
            self._held = None
            self._editing.settle()
