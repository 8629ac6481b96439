"""What of the window is open, and what its panels remember from one frame to the next."""

from collections.abc import Callable

from heatlens.session.key_drag import KeyDrag
from heatlens.session.key_stretch import KeyStretch
from heatlens.session.session import Session
from heatlens.ui.files.file_dialogs import FileDialogs
from heatlens.ui.palette import Palette
from heatlens.ui.theme_choice import ThemeChoice
from heatlens.ui.timeline.view import TimelineView
from heatlens.ui.ui_scale import UiScale

# The panels, as they are called on their tabs and in the menu.
PANELS = (
    "Lens",
    "Look",
    "Plate",
    "Scene",
    "Export",
    "Marks",
    "Looks",
    "Guides",
    "Speed",
    "Timeline",
)
_BEHIND_S = 0.25  # news of the frames may be told so late


class UiState:
    """The state of the interface, apart from the session that it shows."""

    def __init__(self, session: Session, wake: Callable[[], None] = lambda: None) -> None:
        """Take `wake`, which is called from threads to have the window drawn again."""
        self._session = session
        hidden = session.preferences.now.hidden_panels
        self.panels = {name: name not in hidden for name in PANELS}
        self.wants_layout = True  # in the next frame
        self.scale = UiScale(session.preferences)
        self.theme = ThemeChoice(session.preferences)
        self.shows_keys = False
        self.is_bare = False  # the picture fills the window, everything else is hidden
        self.is_full_screen = False
        self.has_feed = False  # a second window shows the picture alone
        self.menu_to_open = ""  # in the next frame
        self.opens_pull = False  # the popup of the pull, in the next frame
        self.is_over = False
        self.asks_to_quit = False  # an export is under way
        self.shows_export_end = True  # how the latest export ended, until it was read
        self.palette = Palette()
        self.dialogs = FileDialogs(session.files, session.say, wake)
        held_by = session.editing, session.keys, session.say
        self.timeline = TimelineView(KeyDrag(*held_by), KeyStretch(*held_by))

    @property
    def hidden_panels(self) -> tuple[str, ...]:
        """The names of the panels that are closed."""
        return tuple(name for name, is_shown in self.panels.items() if not is_shown)

    @property
    def is_timeline_shown(self) -> bool:
        """Return True where the timeline is open and has something to show."""
        session = self._session
        has_time = session.source.plate is not None and session.timeline.has_time
        return self.panels["Timeline"] and has_time

    def toggle_panel(self, name: str) -> None:
        """Open a closed panel, close an open one."""
        self.panels[name] = not self.panels[name]

    def toggle_bare(self) -> None:
        """Hide everything but the picture, or show it all again."""
        self.is_bare = not self.is_bare

    def toggle_full_screen(self) -> None:
        """Let the window fill its screen, or be a window again."""
        self.is_full_screen = not self.is_full_screen

    def toggle_feed(self) -> None:
        """Show the picture alone in a second window, or close that."""
        self.has_feed = not self.has_feed

    @property
    def has_feed_labels(self) -> bool:
        """Return True where looks beside each other are named in the second window."""
        return self._session.preferences.now.feed_labels

    def toggle_feed_labels(self) -> None:
        """Name the looks in the second window, or leave their pictures clean."""
        self._session.preferences.change(feed_labels=not self.has_feed_labels)

    def leave_bare(self) -> None:
        """Come back from the picture alone and from the full screen."""
        self.is_bare = self.is_full_screen = False

    def toggle_keys(self) -> None:
        """Show or hide the list of keys."""
        self.shows_keys = not self.shows_keys

    def reset_layout(self) -> None:
        """Open all panels where they were in the beginning."""
        self.panels = dict.fromkeys(self.panels, True)
        self.wants_layout = True

    def open_pull(self) -> None:
        """Ask in the next frame where to pull the focus to, and how fast."""
        self.opens_pull = True

    def open_menus(self) -> None:
        """Open the first menu in the next frame; the arrow keys then go through all of them."""
        self.menu_to_open = "File"

    def quit(self) -> None:
        """End the program after this frame; ask first where that would stop an export."""
        self.asks_to_quit = self._session.exports.run.is_busy
        self.is_over = not self.asks_to_quit

    def seconds_until_needed(self) -> float | None:
        """Return how long the loop may sleep without an event; None: until there is one."""
        wait_s = self._session.seconds_until_needed()
        if not (self.is_timeline_shown and self._session.timeline.is_behind):
            return wait_s
        return _BEHIND_S if wait_s is None else min(wait_s, _BEHIND_S)
