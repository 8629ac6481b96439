"""What is drawn can be read: contrast after WCAG 2.1, 4.5 for words and 3 for lines and marks."""

import pytest
from imgui_bundle import imgui

from heatlens.ui import theme

_Col = imgui.Col_
GROOVE, WINDOW = theme.GROOVE, theme._STYLE[_Col.window_bg]
WORDS = {
    "values and frames of the timeline": (theme.TEXT_DIM, GROOVE),
    "names in the timeline": (theme.TEXT_DIM, WINDOW),
    "words": (theme._STYLE[_Col.text], WINDOW),
    "words of a field": (theme._STYLE[_Col.text], theme._STYLE[_Col.frame_bg]),
    "words of a button": (theme._STYLE[_Col.text], theme._STYLE[_Col.button]),
    "grey words": (theme._STYLE[_Col.text_disabled], WINDOW),
    "dim words": (theme.DIM, WINDOW),
    "what was said": (theme.ACCENT_TEXT, theme._STYLE[_Col.menu_bar_bg]),
    "a problem": (theme.BAD, WINDOW),
    "a value that is only tried": (theme.TRIED, theme._STYLE[_Col.frame_bg]),
    "the frame on the playhead": (theme.ON_ACCENT, theme.ACCENT),
    "the name of a mark": (theme.MARK, GROOVE),
}
MARKS = {
    "the curve": (theme.ACCENT, GROOVE),
    "what was recorded": (theme.RECORDED, GROOVE),
    "the record button": (theme.RECORDED, theme._STYLE[_Col.button]),
    "limits of what is sharp": (theme.IN_FOCUS, GROOVE),
    "a key": (theme.KEY, GROOVE),
    "a chosen key": (theme.ACCENT, GROOVE),
    "hyperfocal distance": (theme.HYPERFOCAL, GROOVE),
    "depths on the focus bar": (theme.HISTOGRAM, GROOVE),
    "frames in memory": (theme.READY, GROOVE),
    "rendered frames": (theme.RENDERED, GROOVE),
    "damaged frames": (theme.DAMAGED, GROOVE),
    "a slider": (theme._STYLE[_Col.slider_grab], theme._STYLE[_Col.frame_bg]),
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


@pytest.mark.parametrize("name", WORDS)
def test_words_can_be_read(name):
    assert contrast(*WORDS[name]) >= 4.5


@pytest.mark.parametrize("name", MARKS)
def test_lines_and_marks_can_be_seen(name):
    assert contrast(*MARKS[name]) >= 3.0


def test_black_on_white_is_21():
    assert contrast((0, 0, 0), (1, 1, 1)) == pytest.approx(21.0)
