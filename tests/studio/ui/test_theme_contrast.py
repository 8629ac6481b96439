"""What is drawn can be read: contrast after WCAG 2.1, 4.5 for words and 3 for lines and marks."""

import re
from pathlib import Path

import pytest
from imgui_bundle import imgui

import heatlens.studio.ui
from heatlens.studio.session.settings.preferences import Theme
from heatlens.studio.ui import theme
from heatlens.studio.ui.theme import DARK, LIGHT, Palette

_Col = imgui.Col_
PALETTES = pytest.mark.parametrize("p", [DARK, LIGHT], ids=["dark", "light"])


def ground(p: Palette, color: int):
    """Return what is seen of a ground, which shows the surround where it is clear."""
    return color if imgui.color_convert_u32_to_float4(color).w else theme.SURROUND


def words_of(p: Palette) -> dict:
    window, bar = p.style[_Col.window_bg], ground(p, p.status_ground)
    return {
        "values and frames of the timeline": (p.text_dim, p.groove),
        "names in the timeline": (p.text_dim, window),
        "names of rows with keys": (p.handle, window),
        "words": (p.style[_Col.text], window),
        "words of a field": (p.style[_Col.text], p.style[_Col.frame_bg]),
        "words of a button": (p.style[_Col.text], p.style[_Col.button]),
        "words of a menu": (p.style[_Col.text], p.style[_Col.popup_bg]),
        "words of the menu bar": (p.style[_Col.text], p.style[_Col.menu_bar_bg]),
        "words of a chosen row": (p.style[_Col.text], p.style[_Col.header_active]),
        "words of a sought label": (p.tried, window),
        "words of a tab": (p.style[_Col.text], p.style[_Col.tab]),
        "figures on a progress bar": (p.style[_Col.text], p.style[_Col.plot_histogram]),
        "text that is selected": (p.style[_Col.text], p.style[_Col.text_selected_bg]),
        "grey words": (p.style[_Col.text_disabled], window),
        "grey words of the status bar": (p.style[_Col.text_disabled], bar),
        "dim words": (p.dim, window),
        "what was said": (p.told, bar),
        "a question in a panel": (p.told, window),
        "a problem": (p.bad, window),
        "a problem in the status bar": (p.bad, bar),
        "a value that is only tried": (p.tried, p.style[_Col.frame_bg]),
        "the frame on the playhead": (p.on_accent, p.accent),
        "the name of a mark": (p.mark, p.groove),
        "the name of the program": (p.style[_Col.text], ground(p, p.start_ground)),
        "what a recent file is": (p.text_dim, ground(p, p.start_ground)),
        "the words of a card": (p.text_dim, window),
        "the words of a chosen card": (p.text_dim, p.style[_Col.frame_bg]),
    }


def marks_of(p: Palette) -> dict:
    return {
        "the curve": (p.accent, p.groove),
        "what was recorded": (p.recorded, p.groove),
        "the record button": (p.recorded, p.style[_Col.button]),
        "the record button that is armed": (p.recorded, p.armed),
        "an icon on a button": (p.handle, p.style[_Col.button]),
        "limits of what is sharp": (p.in_focus, p.groove),
        "a key": (p.key, p.groove),
        "a chosen key": (p.handle, p.groove),
        "hyperfocal distance": (p.hyperfocal, p.groove),
        "depths on the focus bar": (p.histogram, p.groove),
        "frames in memory": (p.ready, p.groove),
        "rendered frames": (p.rendered, p.groove),
        "damaged frames": (p.damaged, p.groove),
        "a slider": (p.style[_Col.slider_grab], p.style[_Col.frame_bg]),
        "a tick": (p.style[_Col.check_mark], p.style[_Col.checkbox_selected_bg]),
        "the tab in front": (p.style[_Col.tab_selected_overline], p.style[_Col.tab_selected]),
    }


def rgb(color) -> tuple[float, float, float]:
    value = imgui.color_convert_u32_to_float4(color) if isinstance(color, int) else color
    if hasattr(value, "x"):
        return value.x, value.y, value.z
    return tuple(value)[:3]


def light(color) -> float:
    linear = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb(color))
    red, green, blue = linear
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one, other) -> float:
    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


@PALETTES
def test_words_can_be_read(p):
    assert not [name for name, pair in words_of(p).items() if contrast(*pair) < 4.5]


@PALETTES
def test_lines_and_marks_can_be_seen(p):
    assert not [name for name, pair in marks_of(p).items() if contrast(*pair) < 3.0]


@PALETTES
def test_amber_is_the_live_lens_alone_and_keys_and_marks_are_blue(p):
    hues = {name: rgb(getattr(p, name)) for name in ("accent", "live", "key", "mark", "told")}
    for name in ("accent", "live"):
        assert hues[name][0] > hues[name][1] > hues[name][2]
    for name in ("key", "mark"):
        assert hues[name][0] < hues[name][1] < hues[name][2]
    assert len(set(hues["told"])) == 1
    controls = ("slider_grab", "check_mark", "overline", "nav_cursor", "separator_active")
    slots = [slot for slot in p.style if any(name in _Col(slot).name for name in controls)]
    assert len(slots) >= 6 and all(len(set(p.style[slot])) == 1 for slot in slots)


def test_black_on_white_is_21():
    assert contrast((0, 0, 0), (1, 1, 1)) == pytest.approx(21.0)


@PALETTES
def test_what_is_beside_the_picture_is_neutral(p):
    """Large grounds have no colour that would tint the picture for the eye."""
    named = ("_bg", "title", "menu", "tab", "header", "button", "frame")
    slots = [slot for slot in p.style if any(n in _Col(slot).name for n in named)]
    grounds = [p.style[slot] for slot in slots if "overline" not in _Col(slot).name]
    grounds = [g for g in grounds if g != p.style[_Col.text_selected_bg]]
    assert len(grounds) > 15
    assert all(max(ground) - min(ground) < 0.003 for ground in grounds)
    assert len(set(theme.SURROUND)) == 1 and theme.SURROUND[0] < 0.18


def test_themes_differ_in_nothing_but_colours_and_a_light_one_is_light():
    assert light(DARK.style[_Col.window_bg]) < 0.05 < 0.5 < light(LIGHT.style[_Col.window_bg])
    assert len(Theme) == 2 and DARK.accent != LIGHT.accent and DARK.tried != LIGHT.tried


def test_every_colour_has_its_home_among_the_palettes():
    """A literal colour elsewhere would be the same in both themes."""
    literal = re.compile(r"ImVec4\(\s*[\d.]|IM_COL32|color_convert_float4_to_u32|\b0x[\dA-F]{8}")
    folder = Path(heatlens.studio.ui.__file__).parent
    found = [
        f"{path.name}: {line.strip()}"
        for path in sorted(set(folder.rglob("*.py")) - {folder / "theme.py"})
        for line in path.read_text().splitlines()
        if literal.search(line)
    ]
    assert found == []
