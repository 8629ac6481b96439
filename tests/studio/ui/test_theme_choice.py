"""The theme: chosen in the menu, remembered, with the same surround of the picture in both."""

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.render.gpu.device import Device
from heatlens.studio.settings.preferences import Preferences, PreferenceValues, Theme
from heatlens.studio.ui import theme
from heatlens.studio.ui.theme import DARK, LIGHT
from support.gui import gui_of
from support.session_files import QUICK, room_file


@pytest.fixture(autouse=True)
def dark_again():
    """Leave the colours as other tests expect them."""
    yield
    theme.colors = DARK


def brightness(gui, name: str) -> float:
    """Return the median brightness (0 to 255) of the control drawn last under a name."""
    x0, y0, x1, y1 = (round(value) for value in gui.rect(name))
    return float(np.median(gui.screenshot()[y0:y1, x0:x1]))


def test_light_theme_is_chosen_in_the_menu_and_remembered(ctx: Device, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    preferences = Preferences.load(tmp_path / "config")
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        gui.settled()
        (x, y), size = gui.session.pictures.view.viewport.corner, gui.session.pictures.view.viewport
        picture_area = (
            slice(round(y), round(y + size.size[1])),
            slice(round(x), round(x + size.size[0])),
        )
        dark, before = brightness(gui, "kit"), gui.screenshot()[picture_area]
        gui.do("Light theme")
        assert theme.colors is LIGHT and brightness(gui, "kit") > 200 > 80 > dark
        np.testing.assert_array_equal(
            gui.screenshot()[picture_area], before
        )  # the picture, its surround
        assert next(a for a in gui.screen.commands if a.name == "Light theme").is_on()
        gui.session.save_preferences()
    reloaded = Preferences.load(tmp_path / "config")
    assert reloaded.values.theme is Theme.LIGHT
    with gui_of(ctx, plate, reloaded, defocus=QUICK) as gui:
        gui.frame(2)
        assert brightness(gui, "kit") > 200
        gui.do("Light theme")
        assert brightness(gui, "kit") < 80


def test_text_over_the_picture_has_the_same_colors_in_both_themes(ctx: Device, tmp_path):
    """The surround of the picture is dark in both themes, so text over it is the same too."""
    plate, pictures = room_file(tmp_path / "room.exr"), []
    for chosen_theme in Theme:
        preferences = Preferences(PreferenceValues(theme=chosen_theme))
        with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
            gui.do("Near, in focus, far")
            gui.settled()
            view = gui.session.pictures.view.viewport
            (x, y), (width, height) = view.corner, view.size
            shown = gui.screenshot()[round(y) : round(y + height), round(x) : round(x + width)]
            pictures.append(shown)
            colored = imgui.get_style_color_vec4(imgui.Col_.text)
            with theme.over_picture():
                assert imgui.get_style_color_vec4(imgui.Col_.text).x > 0.8
            assert imgui.get_style_color_vec4(imgui.Col_.text).x == colored.x
    np.testing.assert_array_equal(*pictures)
