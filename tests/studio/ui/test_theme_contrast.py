"""Contrast of both themes after WCAG 2.1: at least 4.5 for text and 3 for lines and marks."""

import re
from pathlib import Path

import pytest
from imgui_bundle import imgui

import heatlens.studio.ui
from heatlens.studio.settings.preferences import Theme
from heatlens.studio.ui import theme
from heatlens.studio.ui.theme import DARK, LIGHT, Palette

_Col = imgui.Col_
PALETTES = pytest.mark.parametrize("p", [DARK, LIGHT], ids=["dark", "light"])


def ground(p: Palette, color: int):
    """Return the color of a background, which is the surround if it is transparent."""
    return color if imgui.color_convert_u32_to_float4(color).w else theme.SURROUND


def text_pairs(p: Palette) -> dict:
    window, bar = p.style[_Col.window_bg], ground(p, p.status_ground)
    return {
        "values and frames of the timeline": (p.text_dim, p.groove),
        "names in the timeline": (p.text_dim, window),
        "names of rows with keys": (p.handle, window),
        "words": (p.style[_Col.text], window),
        "words of a field": (p.style[_Col.text], p.style[_Col.frame_bg]),
        "words of a button": (p.style[_Col.text], p.style[_Col.button]),
        "words of a menu": (p.style[_Col.text], p.style[_Col.popup_bg]),
        "a link to the manual": (p.style[_Col.text_link], p.style[_Col.child_bg]),
        "words of the menu bar": (p.style[_Col.text], p.style[_Col.menu_bar_bg]),
        "words of a chosen row": (p.style[_Col.text], p.style[_Col.header_active]),
        "words of a sought label": (p.trial, window),
        "words of a tab": (p.style[_Col.text], p.style[_Col.tab]),
        "figures on a progress bar": (p.style[_Col.text], p.style[_Col.plot_histogram]),
        "text that is selected": (p.style[_Col.text], p.style[_Col.text_selected_bg]),
        "grey words": (p.style[_Col.text_disabled], window),
        "grey words of the status bar": (p.style[_Col.text_disabled], bar),
        "dim words": (p.dim, window),
        "what was said": (p.message, bar),
        "a question in a panel": (p.message, window),
        "a problem": (p.bad, window),
        "a problem in the status bar": (p.bad, bar),
        "a value that is only tried": (p.trial, p.style[_Col.frame_bg]),
        "the frame on the playhead": (p.on_accent, p.accent),
        "the name of a mark": (p.mark, p.groove),
        "the name of the program": (p.style[_Col.text], ground(p, p.start_ground)),
        "what a recent file is": (p.text_dim, ground(p, p.start_ground)),
        "the words of a card": (p.text_dim, window),
        "the words of a chosen card": (p.text_dim, p.style[_Col.frame_bg]),
        "limits of what is sharp, in figures": (p.in_focus, window),
        **{
            f"{words} on {name}": (color, below)
            for words, color in {
                "red": p.bad,
                "what is recorded": p.recorded,
                "amber": p.live,
                "the needle's amber": p.accent,
                "grey": p.dim,
                "hints": p.style[_Col.text_disabled],
            }.items()
            for name, below in {
                "a field": p.style[_Col.frame_bg],
                "a button": p.style[_Col.button],
                "the status bar": bar,
            }.items()
        },
    }


def faded(p: Palette, color, below):
    """Return a color of a control that cannot be used, over what is below it."""
    share = p.disabled_alpha
    return tuple(
        share * top + (1 - share) * low for top, low in zip(rgb(color), rgb(below), strict=True)
    )


def disabled_pairs(p: Palette) -> dict:
    window, popup = p.style[_Col.window_bg], p.style[_Col.popup_bg]
    fills = {"field": p.style[_Col.frame_bg], "button": p.style[_Col.button]}
    faded_fills = {name: faded(p, fill, window) for name, fill in fills.items()}
    return {
        "words of a label": (faded(p, p.style[_Col.text_disabled], window), window),
        "words of a menu": (p.style[_Col.text_disabled], popup),
        **{
            f"words of a {name}": (faded(p, p.style[_Col.text], fill), fill)
            for name, fill in faded_fills.items()
        },
    }


def line_pairs(p: Palette) -> dict:
    return {
        "the curve": (p.accent, p.groove),
        "what was recorded": (p.recorded, p.groove),
        "the record button": (p.recorded, p.style[_Col.button]),
        "the record button that is armed": (p.recorded, p.armed_button),
        "an icon on a button": (p.handle, p.style[_Col.button]),
        "limits of what is sharp": (p.in_focus, p.groove),
        "a key": (p.key, p.groove),
        "a chosen key": (p.handle, p.groove),
        "hyperfocal distance": (p.hyperfocal, p.groove),
        "depths on the focus bar": (p.histogram, p.groove),
        "frames on disk": (p.on_disk, p.groove),
        "frames that are read next": (p.queued, p.groove),
        "the dot of a row without keys": (p.queued, p.style[_Col.window_bg]),
        "the rim of a card": (p.on_disk, ground(p, p.start_ground)),
        "frames in memory": (p.ready, p.groove),
        "rendered frames": (p.rendered, p.groove),
        "damaged frames": (p.damaged, p.groove),
        "the rim of a control": (p.style[_Col.border], p.style[_Col.window_bg]),
        "the rim of a control in a popup": (p.style[_Col.border], p.style[_Col.popup_bg]),
        "a button that is on": (p.style[_Col.check_mark], p.style[_Col.window_bg]),
        "a slider": (p.style[_Col.slider_grab], p.style[_Col.frame_bg]),
        "a tick": (p.style[_Col.check_mark], p.style[_Col.checkbox_selected_bg]),
        "the tab in front": (p.style[_Col.tab_selected_overline], p.style[_Col.tab_selected]),
    }


# What marks an area without being read alone: its rim, its line or its words are in the pairs.
AREAS = {"in_focus_band", "tolerance_band", "box", "played", "shadow", "dimming", "disc_ground"}
# Drawn over the pixels of a picture, or colors that lamps have.
OVER_PIXELS = {"guide", "pixel_grid", "window_line", "fringe_red", "fringe_blue"}


class Watched:
    """A palette that notes which of its colors are taken."""

    def __init__(self, palette: Palette) -> None:
        self.palette, self.taken = palette, set()

    def __getattr__(self, name: str):
        self.taken.add(name)
        return getattr(self.palette, name)


def test_pairs_have_every_color_that_is_drawn():
    watched = Watched(DARK)
    for pairs in (text_pairs, line_pairs, disabled_pairs, over_picture_pairs):
        pairs(watched)
    colors = {name for name in vars(Palette) if not name.startswith("_")}
    assert colors - watched.taken == AREAS - {"shadow"} | OVER_PIXELS


def over_picture_pairs(p: Palette) -> dict:
    """Return what is drawn on its own ground over a picture, which is white there."""

    def over_white(color, opacity: float) -> tuple[float, ...]:
        return tuple(opacity * top + (1 - opacity) for top in rgb(color))

    notice = over_white(p.style[_Col.window_bg], theme.NOTICE_OPACITY)
    label = over_white(p.shadow, imgui.color_convert_u32_to_float4(p.shadow).w)
    return {
        "a notice": (p.message, notice),
        "a lesson": (p.style[_Col.text], notice),
        "a button of a notice": (p.style[_Col.text], p.style[_Col.button]),
        "the name of a look": (p.handle, label),
    }


def test_words_over_a_white_picture_have_a_contrast_of_at_least_4_5():
    pairs = over_picture_pairs(theme.OVER_PICTURE)
    assert not [name for name, pair in pairs.items() if contrast(*pair) < 4.5]


def rgb(color) -> tuple[float, float, float]:
    value = imgui.color_convert_u32_to_float4(color) if isinstance(color, int) else color
    if hasattr(value, "x"):
        return value.x, value.y, value.z
    return tuple(value)[:3]


def relative_luminance(color) -> float:
    linear = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb(color))
    red, green, blue = linear
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(color, other_color) -> float:
    low, high = sorted((relative_luminance(color), relative_luminance(other_color)))
    return (high + 0.05) / (low + 0.05)


@PALETTES
def test_text_has_a_contrast_of_at_least_4_5(p):
    assert not [name for name, pair in text_pairs(p).items() if contrast(*pair) < 4.5]


@PALETTES
def test_words_of_disabled_controls_have_a_contrast_of_at_least_4_5(p):
    assert not [name for name, pair in disabled_pairs(p).items() if contrast(*pair) < 4.5]


def test_every_control_has_a_rim_in_both_themes(gui):
    for palette in (DARK, LIGHT):
        theme.paint(palette)
        assert imgui.get_style().frame_border_size >= 1.0
        assert imgui.get_style().disabled_alpha == pytest.approx(palette.disabled_alpha)
    theme.paint(DARK)


@PALETTES
def test_lines_and_marks_have_a_contrast_of_at_least_3(p):
    assert not [name for name, pair in line_pairs(p).items() if contrast(*pair) < 3.0]


@PALETTES
def test_amber_is_only_for_the_live_lens_and_blue_for_keys_and_marks(p):
    hues = {name: rgb(getattr(p, name)) for name in ("accent", "live", "key", "mark", "message")}
    for name in ("accent", "live"):
        assert hues[name][0] > hues[name][1] > hues[name][2]
    for name in ("key", "mark"):
        assert hues[name][0] < hues[name][1] < hues[name][2]
    assert len(set(hues["message"])) == 1
    controls = ("slider_grab", "check_mark", "overline", "nav_cursor", "separator_active")
    slots = [slot for slot in p.style if any(name in _Col(slot).name for name in controls)]
    assert len(slots) >= 6 and all(len(set(p.style[slot])) == 1 for slot in slots)


def test_contrast_of_black_on_white_is_21():
    assert contrast((0, 0, 0), (1, 1, 1)) == pytest.approx(21.0)


@PALETTES
def test_backgrounds_beside_the_picture_are_gray(p):
    """Large backgrounds are gray, since a color would change how the picture looks."""
    named = ("_bg", "title", "menu", "tab", "header", "button", "frame")
    slots = [slot for slot in p.style if any(n in _Col(slot).name for n in named)]
    grounds = [p.style[slot] for slot in slots if "overline" not in _Col(slot).name]
    grounds = [g for g in grounds if g != p.style[_Col.text_selected_bg]]
    assert len(grounds) > 15
    assert all(max(ground) - min(ground) < 0.003 for ground in grounds)
    assert len(set(theme.SURROUND)) == 1 and theme.SURROUND[0] < 0.18


def test_dark_and_light_theme_differ_in_luminance_and_accents():
    assert (
        relative_luminance(DARK.style[_Col.window_bg])
        < 0.05
        < 0.5
        < relative_luminance(LIGHT.style[_Col.window_bg])
    )
    assert len(Theme) == 2 and DARK.accent != LIGHT.accent and DARK.trial != LIGHT.trial


def test_no_color_literals_outside_the_theme_module():
    """A literal color outside `theme.py` would be the same in both themes."""
    literal = re.compile(r"ImVec4\(\s*[\d.]|IM_COL32|color_convert_float4_to_u32|\b0x[\dA-F]{8}")
    folder = Path(heatlens.studio.ui.__file__).parent
    literal_lines = [
        f"{path.name}: {line.strip()}"
        for path in sorted(set(folder.rglob("*.py")) - {folder / "theme.py"})
        for line in path.read_text().splitlines()
        if literal.search(line)
    ]
    assert literal_lines == []
