"""The user's theme, and the scale: that of the monitor times the user's scale for it."""

from imgui_bundle import imgui

from heatlens.session.settings.preferences import Preferences, Theme
from heatlens.session.settings.ui_sizes import next_scale, scaled_layout, with_scale
from heatlens.ui import theme
from heatlens.ui.palettes import DARK, LIGHT

_PALETTES = {Theme.DARK: DARK, Theme.LIGHT: LIGHT}


class ThemeChoice:
    """The user's choice of theme, stored in the preferences."""

    def __init__(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self._is_painted = False  # whether the ImGui context of this window has its colours yet

    @property
    def now(self) -> Theme:
        """The theme that the user chose."""
        return self._preferences.now.theme

    def choose(self, chosen: Theme) -> None:
        """Set the theme, from the next frame on."""
        self._preferences.change(theme=chosen)

    def toggle(self) -> None:
        """Switch between the light and the dark theme."""
        self.choose(Theme.DARK if self.now is Theme.LIGHT else Theme.LIGHT)

    def apply(self) -> None:
        """Apply a changed theme; call this before a frame is drawn."""
        wanted = _PALETTES[self.now]
        if theme.colors is not wanted or not self._is_painted:
            theme.paint(wanted)
            self._is_painted = True


class UiScale:
    """The scale of the interface; applies style and layout again when it changes."""

    def __init__(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self.screen = ""  # name of the monitor that the window is on
        self.of_screen = 1.0  # content scale that the system reports for that monitor
        self._applied: float | None = None
        self.is_new = False  # the scale has changed since the last frame

    @property
    def chosen(self) -> float:
        """The factor that the user chose for this monitor."""
        return self._preferences.now.ui_scales.get(self.screen, 1.0)

    @property
    def em(self) -> float:
        """Font size in pixels."""
        return theme.FONT_PX * self.of_screen * self.chosen

    def step(self, steps: int) -> None:
        """Enlarge the interface by so many steps; a negative number makes it smaller."""
        self._choose(next_scale(self.chosen, steps))

    def reset(self) -> None:
        """Return to the scale that the system reports."""
        self._choose(1.0)

    def _choose(self, scale: float) -> None:
        scales = with_scale(self._preferences.now.ui_scales, self.screen, scale)
        self._preferences.change(ui_scales=scales)

    def apply(self) -> None:
        """Apply a changed scale; call this between two ImGui frames."""
        wanted, before = self.of_screen * self.chosen, self._applied
        if wanted == before:
            return
        layout = imgui.save_ini_settings_to_memory() if before is not None else ""
        theme.apply(wanted)
        self._applied, self.is_new = wanted, True
        if before is not None and layout:
            imgui.load_ini_settings_from_memory(scaled_layout(layout, wanted / before))
