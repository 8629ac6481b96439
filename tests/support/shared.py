"""What commands of a session share, for tests of one of them alone."""

from collections.abc import Callable
from types import SimpleNamespace

from heatlens.studio.session.settings.preferences import Preferences
from heatlens.studio.session.shared import Shared
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.session.shot.start import GivenOptions, Start


def shared_of(
    editing: Editing | None = None,
    say: Callable[[str], None] = lambda sentence: None,
    source: object = None,
) -> Shared:
    """Return it with an editing, a status bar and a source of a test; nothing else is open."""
    found = SimpleNamespace(plate=None) if source is None else source
    given = GivenOptions(Start(""))
    return Shared(found, editing, Preferences(), given, say, say, lambda: None)
