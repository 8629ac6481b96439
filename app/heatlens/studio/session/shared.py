"""What all commands work on: the open source, its shot, the preferences, and the status bar."""

from collections.abc import Callable
from dataclasses import dataclass

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import report_errors
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import CommandLineOptions


@dataclass(frozen=True)
class Shared:
    """What every command works on.

    notify      shows a sentence in the status bar
    show_error  shows an error there; after a fault of the program it also saves the shot
    wake        makes the front end draw again; threads call it
    """

    source: OpenSource
    editing: Editing
    preferences: Preferences
    command_line: CommandLineOptions
    notify: Callable[[str], None]
    show_error: Callable[[HeatlensError], None]
    wake: Callable[[], None]


class Commands:
    """The base of commands and workers on the open shot."""

    def __init__(self, shared: Shared) -> None:
        self._source, self._editing = shared.source, shared.editing
        self._preferences, self._command_line = shared.preferences, shared.command_line
        self._notify, self._wake = shared.notify, shared.wake

    def _do(self, change: Callable[[Shot], Shot]) -> None:
        """Change the shot as an undo step; report why if that is impossible."""
        with report_errors(self._notify):
            self._editing.do(change(self._editing.shot))
