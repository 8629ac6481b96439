"""Which theme the interface is drawn in, as the user chose it."""

from heatlens.session.preferences import Preferences, Theme
from heatlens.ui import theme
from heatlens.ui.palettes import DARK, LIGHT

_PALETTES = {Theme.DARK: DARK, Theme.LIGHT: LIGHT}


class ThemeChoice:
    """Takes the colours of the theme that is remembered."""

    def __init__(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self._is_painted = False  # in the ImGui context of this window

    @property
    def now(self) -> Theme:
        """The one that the user chose."""
        return self._preferences.now.theme

    def choose(self, chosen: Theme) -> None:
        """Draw in another theme from the next frame on."""
        self._preferences.change(theme=chosen)

    def toggle(self) -> None:
        """Choose the light theme, or the dark one again."""
        self.choose(Theme.DARK if self.now is Theme.LIGHT else Theme.LIGHT)

    def apply(self) -> None:
        """Take over a theme that was chosen; to be called before a frame is drawn."""
        wanted = _PALETTES[self.now]
        if theme.colors is not wanted or not self._is_painted:
            theme.paint(wanted)
            self._is_painted = True
