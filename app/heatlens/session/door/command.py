"""Define a command: one thing the user can do without further values, known by its name."""

from collections.abc import Callable
from dataclasses import dataclass

from heatlens.session.loop.messages import Problem


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

    def do(self, say: Callable[[str], None]) -> None:
        """Run the command, or pass the reason why it is unavailable to `say`."""
        why = self.why_not()
        if why:
            say(Problem(why))
        else:
            self.run()
