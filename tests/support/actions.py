"""The list of actions without a window: for tests that need only their names, menus and keys."""

from typing import Any

from heatlens.studio.session.door.named_commands import named_commands
from heatlens.studio.ui.action_list import actions
from heatlens.studio.ui.actions import Action


class _Nothing:
    """Has every attribute, and each is nothing again: actions can be bound to it, not done."""

    def __getattr__(self, name: str) -> "_Nothing":
        return self

    def __call__(self, *_: object) -> "_Nothing":
        raise AssertionError("This action is bound to no session.")


def listed_actions() -> tuple[Action, ...]:
    """Return every action, in the order of the menus; none of them can be done."""
    nothing: Any = _Nothing()
    return actions(named_commands(nothing), nothing)
