"""Define a command: one thing the user can do without further values, known by its name."""

from collections.abc import Callable
from dataclasses import dataclass

from heatlens.base.errors import InputError


@dataclass(frozen=True, eq=False)
class Command:
    """One thing the user can do.

    name    unique name
    menu    title of its menu
    run     the function that does it
    is_on   returns the state of a switch; None for commands that switch nothing
    barred  returns the reason why the command is unavailable now, or ""
    label   returns the text that a menu shows instead of the name
    """

    name: str
    menu: str
    run: Callable[[], object]
    is_on: Callable[[], bool] | None = None
    barred: Callable[[], str] | None = None
    label: Callable[[], str] | None = None

    @property
    def shown(self) -> str:
        """The text in the menu: `label()` where the command has one, else the name."""
        return self.name if self.label is None else self.label()

    def why_not(self) -> str:
        """Return the reason, a sentence, why the command is unavailable now; else ""."""
        return "" if self.barred is None else self.barred()

    def do(self) -> None:
        """Run the command. Raise InputError with the reason if it is unavailable."""
        why = self.why_not()
        if why:
            raise InputError(why)
        self.run()
