"""How large the interface is: the scale of the screen times the one that the user chose for it."""

from imgui_bundle import imgui

from heatlens.session.preferences import Preferences
from heatlens.session.ui_sizes import next_scale, scaled_layout, with_scale
from heatlens.ui import theme


class UiScale:
    """Applies style and layout again where the scale has changed."""

    def __init__(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self.screen = ""  # name of the screen that the window is on
        self.of_screen = 1.0  # as the screen's own settings say
        self._applied: float | None = None

    @property
    def chosen(self) -> float:
        """The scale that the user chose for the screen."""
        return self._preferences.now.ui_scales.get(self.screen, 1.0)

    @property
    def em(self) -> float:
        """Height of the letters in pixels."""
        return theme.FONT_PX * self.of_screen * self.chosen

    def step(self, steps: int) -> None:
        """Draw the interface larger, or smaller where `steps` is negative."""
        self._choose(next_scale(self.chosen, steps))

    def reset(self) -> None:
        """Draw the interface as large as the screen's own settings ask."""
        self._choose(1.0)

    def _choose(self, scale: float) -> None:
        scales = with_scale(self._preferences.now.ui_scales, self.screen, scale)
        self._preferences.change(ui_scales=scales)

    def apply(self) -> None:
        """Take over a changed scale; to be called between two frames of ImGui."""
        wanted, before = self.of_screen * self.chosen, self._applied
        if wanted == before:
            return
        layout = imgui.save_ini_settings_to_memory() if before is not None else ""
        theme.apply(wanted)
        self._applied = wanted
        if before is not None and layout:
            imgui.load_ini_settings_from_memory(scaled_layout(layout, wanted / before))
