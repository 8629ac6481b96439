"""Keep which panels and popups are open, and their state between frames.

It also has the user's theme, and the scale: that of the monitor times the user's scale for it.
"""

from collections.abc import Callable

from imgui_bundle import imgui

from heatlens.core.base.messages import Messages
from heatlens.core.model.view.ui_sizes import next_scale, scaled_layout, with_scale
from heatlens.studio.board.controls import FileControl, TimeControl
from heatlens.studio.board.key_drag import KeyDrag, KeyStretch
from heatlens.studio.settings.preferences import Preferences, Theme
from heatlens.studio.ui import theme
from heatlens.studio.ui.files.file_browser import FileDialogs
from heatlens.studio.ui.palette import Palette
from heatlens.studio.ui.sharing import WindowSharing
from heatlens.studio.ui.theme import DARK, LIGHT
from heatlens.studio.ui.timeline.view import TimelineView

_PALETTES = {Theme.DARK: DARK, Theme.LIGHT: LIGHT}


class ThemeChoice:
    """The user's choice of theme, stored in the preferences."""

    def __init__(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self._is_painted = False  # whether the ImGui context of this window has its colors yet

    @property
    def current(self) -> Theme:
        """The theme that the user chose in the preferences."""
        return self._preferences.values.theme

    def choose(self, new_theme: Theme) -> None:
        """Set the theme, from the next frame on."""
        self._preferences.change(theme=new_theme)

    def toggle(self) -> None:
        """Switch between the light and the dark theme."""
        self.choose(Theme.DARK if self.current is Theme.LIGHT else Theme.LIGHT)

    def apply(self) -> None:
        """Apply a changed theme; call this before a frame is drawn."""
        palette = _PALETTES[self.current]
        if theme.colors is not palette or not self._is_painted:
            theme.paint(palette)
            self._is_painted = True


class UiScale:
    """The scale of the interface; applies style and layout again when it changes."""

    def __init__(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self.screen = ""  # name of the monitor that the window is on
        self.screen_width_px = 0
        self.screen_scale = 1.0  # content scale that the system reports for that monitor
        self._applied_scale: float | None = None
        self.is_new = False  # the scale has changed since the last frame

    @property
    def user_scale(self) -> float:
        """The factor that the user chose for this monitor."""
        return self._preferences.values.ui_scales.get(self.screen, 1.0)

    @property
    def em(self) -> float:
        """Font size in pixels."""
        return theme.FONT_PX * self.screen_scale * self.user_scale

    @property
    def is_unknown(self) -> bool:
        """True for a large screen whose scale neither the system nor the user has told."""
        is_large = self.screen_width_px >= _LARGE_SCREEN_PX and self.screen_scale == 1.0
        return is_large and self.screen not in self._preferences.values.ui_scales

    def choose(self, scale: float) -> None:
        """Keep a scale for this screen, also the usual one."""
        scales = self._preferences.values.ui_scales
        self._preferences.change(ui_scales={**scales, self.screen: scale})

    def step(self, steps: int) -> None:
        """Enlarge the interface by a number of steps; a negative number makes it smaller."""
        self._set_user_scale(next_scale(self.user_scale, steps))

    def reset(self) -> None:
        """Return to the scale that the system reports."""
        self._set_user_scale(1.0)

    def _set_user_scale(self, scale: float) -> None:
        scales = with_scale(self._preferences.values.ui_scales, self.screen, scale)
        self._preferences.change(ui_scales=scales)

    def apply(self) -> None:
        """Apply a changed scale; call this between two ImGui frames."""
        new_scale, old_scale = self.screen_scale * self.user_scale, self._applied_scale
        if new_scale == old_scale:
            return
        layout = imgui.save_ini_settings_to_memory() if old_scale is not None else ""
        theme.apply(new_scale)
        self._applied_scale, self.is_new = new_scale, True
        if old_scale is not None and layout:
            imgui.load_ini_settings_from_memory(scaled_layout(layout, new_scale / old_scale))


# The names of the panels on their tabs and in the menu.
PANELS = ("Lens", "Marks", "Looks", "Display", "Export", "Source", "Reel strip", "Timeline")
_LARGE_SCREEN_PX = 3000  # width from which text of the usual size may be too small
_PREVIEW_WORDS = "This is the quick picture; the whole one follows."
_UPDATE_S = 0.25  # longest delay before the timeline shows newly read frames


class UiState:
    """The state of the interface itself; the session has the state of the work."""

    def __init__(
        self,
        time: TimeControl,
        files: FileControl,
        preferences: Preferences,
        messages: Messages,
        wake: Callable[[], None],
        sharing: WindowSharing,
    ) -> None:
        """Create the state; threads call `wake` to have the window drawn again."""
        self.files = files
        self.sharing = sharing
        self.messages = messages
        self._timeline, self.tracking = time.timeline, time.marks.anchors.tracking
        self._preferences = preferences
        hidden_panels = preferences.values.hidden_panels
        self.panels = {name: name not in hidden_panels for name in PANELS}
        self.wants_layout = True  # reset the arrangement of panels in the next frame
        self.scale = UiScale(preferences)
        self.theme = ThemeChoice(preferences)
        self.shows_keys = False
        self.is_bare = False  # the picture fills the window and everything else is hidden
        self.is_full_screen = False
        self.has_feed = False  # the second window with the picture is open
        self.menu_to_open = ""  # title of the menu to open in the next frame
        self.pull_target = ""  # the mark to which a pull is being set up
        self.opens_pull = False  # open the popup of the pull in the next frame
        self.is_over = False
        self.asks_to_quit = False  # show the question whether to stop the running export
        self.shows_export_end = True  # the result of the latest export, until it is dismissed
        self.palette = Palette()
        self.dialogs = FileDialogs(files, messages.notify, wake)
        gesture_args = time.editing, time.keys, messages.notify
        self._is_preview_told = False  # the quick picture of now is explained
        self.timeline = TimelineView(KeyDrag(*gesture_args), KeyStretch(*gesture_args))

    @property
    def hidden_panels(self) -> tuple[str, ...]:
        """The names of the panels that are closed."""
        return tuple(name for name, is_shown in self.panels.items() if not is_shown)

    @property
    def is_timeline_shown(self) -> bool:
        """True if the timeline panel is open and the source has several frames."""
        return self.panels["Timeline"] and self._timeline.is_shown

    def toggle_panel(self, name: str) -> None:
        """Open the panel if it is closed, and close it if it is open."""
        self.panels[name] = not self.panels[name]

    def toggle(self, name: str) -> None:
        """Switch one of the flags on or off: `is_bare`, `is_full_screen`, `has_feed` and so on."""
        setattr(self, name, not getattr(self, name))

    @property
    def has_feed_labels(self) -> bool:
        """True if the second window writes the names of looks into the grid."""
        return self._preferences.values.feed_labels

    @has_feed_labels.setter
    def has_feed_labels(self, is_on: bool) -> None:
        self._preferences.change(feed_labels=is_on)

    def preview_hint(self, is_preview: bool) -> str:
        """Return what the quick picture is, while the first one is shown; "" from then on."""
        is_new = not self._preferences.values.knows_previews
        if is_new and self._is_preview_told and not is_preview:
            self._preferences.change(knows_previews=True)
        self._is_preview_told = is_new and is_preview
        return _PREVIEW_WORDS if self._is_preview_told else ""

    def leave_bare(self) -> None:
        """Leave the mode that shows only the picture, and full screen."""
        self.is_bare = self.is_full_screen = False

    def reset_layout(self) -> None:
        """Open all panels; the next frame arranges them as they were at first."""
        self.panels = dict.fromkeys(self.panels, True)
        self.wants_layout = True

    def open_pull(self) -> None:
        """Open the popup for a focus pull in the next frame."""
        self.opens_pull = True

    def open_menus(self) -> None:
        """Open the first menu in the next frame; the arrow keys then lead to the others."""
        self.menu_to_open = "File"

    def quit(self) -> None:
        """End the program after this frame; ask first if an export is running."""
        self.asks_to_quit = self.files.exports.run.is_busy
        self.is_over = not self.asks_to_quit

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the timeline shows newly read frames; None without any."""
        return _UPDATE_S if self.is_timeline_shown and self._timeline.is_outdated else None
