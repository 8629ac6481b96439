"""Remember and apply the theme that the user chose."""

from heatlens.session.settings.preferences import Preferences, Theme
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
