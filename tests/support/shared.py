"""The objects that the commands of a session share, for tests of a single command."""

from collections.abc import Callable
from types import SimpleNamespace

from heatlens.studio.session.shared import Shared
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import CommandLineOptions, Start


def shared_of(
    editing: Editing | None = None,
    notify: Callable[[str], None] = lambda sentence: None,
    source: object = None,
) -> Shared:
    """Return a `Shared` with the editing, the message function and the source of a test."""
    session_source = SimpleNamespace(plate=None) if source is None else source
    given_options = CommandLineOptions(Start(""))
    return Shared(
        session_source, editing, Preferences(), given_options, notify, notify, lambda: None
    )
