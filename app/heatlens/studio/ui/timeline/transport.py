"""Draw the transport row of the timeline: play, step, frame, timecode, rate and ending."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeVar

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import Ending, check_frame, check_frames_per_second
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.timeline.rendered_panel import rendered_label
from heatlens.studio.ui.timeline.tool_row import Tool, text_tool, tool_row

Key = TypeVar("Key")

_FIELD_EM, _COMBO_EM, _WIDE_EM, _MISSING_EM = 4.6, 5.6, 7.6, 10.4
_TIMECODE_EM, _RATE_EM = 6.4, 6.2
_RARE = ("first", "backwards", "last")  # in the popup: keys and the ruler do the same
_ICON_ASPECT = 1.15  # width of a button divided by its height
_PACE_NAMES = {True: "every frame", False: "real time"}
_MISSING_NAMES: dict[MissingPolicy, str] = {
    "hold": "hold missing frames",
    "black": "black for missing frames",
    "stop": "stop at missing frames",
}
_RECORD_TIP = (
    "Record a pull (Shift+R): play, and move the focus with the bar, the wheel or the picture.\n"
    "'real time' keeps the timing of the shot; 'every frame' waits for slow frames."
)
_TIMECODE_TIP = (
    "Timecode of this frame. Type one to set where the shot starts;\n"
    "clear it to use the timecode in the headers of the plates."
)
_MORE_TIP = "First and last frame, backwards, timecode, frames per second, ending and pace"
# Shapes of the buttons: triangles as (left x, right x), bars as x, over a square from -1 to 1.
_SHAPES: dict[str, tuple[tuple[tuple[float, float], ...], tuple[float, ...]]] = {
    "first": (((0.9, -0.5),), (-0.8,)),
    "previous key": (((1.0, 0.1), (0.1, -0.8)), ()),
    "back": (((0.5, -0.5),), ()),
    "backwards": (((0.8, -0.8),), ()),
    "forwards": (((-0.8, 0.8),), ()),
    "on": (((-0.5, 0.5),), ()),
    "next key": (((-1.0, -0.1), (-0.1, 0.8)), ()),
    "last": (((-0.9, 0.5),), (0.8,)),
    "stop": ((), ()),
    "record": ((), ()),
}


def transport(control: TimeControl) -> None:
    """Draw the controls in one row; rare ones and those that do not fit are in a popup."""
    em, rate = imgui.get_font_size(), control.editing.shot.frames_per_second
    frames = f"of {control.timeline.played}, {rate:.5g} fps"
    tool_row(
        "transport",
        [
            *_transport_buttons(control),
            Tool(partial(_frame_field, control), _FIELD_EM * em, 0),
            text_tool(
                frames, 6, tip="Frames to play: I and O set in and out, Shift+I clears them."
            ),
            Tool(partial(_timecode_field, control), _TIMECODE_EM * em, 5, is_rare=True),
            Tool(partial(_rate_field, control), _RATE_EM * em, 7, is_rare=True),
            *_option_tools(control),
        ],
        _MORE_TIP,
    )
    rendered_label(control)


def _transport_buttons(control: TimeControl) -> list[Tool]:
    """Return the buttons of the row, from the first frame to record."""
    timeline, direction = control.timeline, control.timeline.playback.direction
    buttons: tuple[tuple[int, str, str, str, Callable[[], None]], ...] = (
        (2, "first", "first", "First frame (Home)", lambda: timeline.go_to_end(-1)),
        (4, "previous key", "previous key", "Previous key (Up)", lambda: timeline.go_to_key(-1)),
        (1, "back", "back", "Previous frame (Left)", lambda: timeline.step(-1)),
        (3, "backwards", "stop" if direction < 0 else "backwards", "Backwards (Shift+Space)",
         lambda: timeline.play(-1)),
        (0, "forwards", "stop" if direction > 0 else "forwards", "Play (Space)",
         lambda: timeline.play(1)),
        (1, "on", "on", "Next frame (Right)", lambda: timeline.step(1)),
        (4, "next key", "next key", "Next key (Down)", lambda: timeline.go_to_key(1)),
        (2, "last", "last", "Last frame (End)", lambda: timeline.go_to_end(1)),
        (1, "record", "record", _RECORD_TIP, control.recording.arm),
    )  # fmt: skip
    width, is_armed = _ICON_ASPECT * imgui.get_frame_height(), control.recording.state.is_waiting

    has_keys = bool(timeline.key_frames)

    def drawn(name: str, shape: str, tip: str, on_press: Callable[[], None]) -> None:
        with widgets.disabled(not has_keys and name.endswith(" key")):
            if _icon_button(name, shape, tip, is_armed and name == "record"):
                on_press()

    return [
        Tool(partial(drawn, name, shape, tip, do), width, rank, 2.0, is_rare=name in _RARE)
        for rank, name, shape, tip, do in buttons
    ]


def _icon_button(name: str, shape: str, tip: str, is_on: bool = False) -> bool:
    """Draw a button with a shape; return True if it was pressed."""
    height = imgui.get_frame_height()
    corner = imgui.get_cursor_screen_pos()
    with texts.colored(theme.colors.armed_button if is_on else None, imgui.Col_.button):
        is_pressed = imgui.button(f"##{name}", ImVec2(_ICON_ASPECT * height, height))
    rects.note(f"transport {name}")
    texts.tooltip(tip)
    center = ImVec2(corner.x + 0.5 * _ICON_ASPECT * height, corner.y + height / 2)
    _draw_shape(shape, center, 0.26 * height)
    return bool(is_pressed)


def _draw_shape(shape: str, center: ImVec2, reach: float) -> None:
    """Draw the triangles, bars or other shape of a button."""
    draw = imgui.get_window_draw_list()
    is_faded = imgui.get_style().alpha < 1.0  # in a button that is disabled
    color = theme.colors.queued if is_faded else theme.colors.handle

    def at(x: float, y: float) -> ImVec2:
        return ImVec2(center.x + x * reach, center.y + y * reach)

    triangles, bars = _SHAPES[shape]
    for base, tip in triangles:
        draw.add_triangle_filled(at(base, -1), at(base, 1), at(tip, 0), color)
    for x in bars:
        draw.add_rect_filled(at(x - 0.15, -1), at(x + 0.15, 1), color)
    if shape == "record":
        draw.add_circle_filled(center, reach, theme.colors.recorded)
    if shape == "stop":
        draw.add_rect_filled(at(-0.8, -0.8), at(0.8, 0.8), theme.colors.handle)


def _frame_field(control: TimeControl) -> None:
    """Draw the field of the frame at the playhead; go to a typed frame."""
    frame = control.editing.frame
    new_frame = widgets.text_field("frame", str(frame), frame, _parse_frame, control.notify)
    if new_frame != frame:
        control.timeline.go_to(new_frame)


def _timecode_field(control: TimeControl) -> None:
    """Draw the timecode of the frame; typing one sets the timecode of the first frame."""
    timecode, parse = control.timeline.timecode, control.timeline.start_timecode
    new_timecode = widgets.text_field(
        "timecode", timecode, timecode, parse, control.notify, "timecode"
    )
    texts.tooltip(_TIMECODE_TIP)
    if new_timecode != timecode:
        control.editing.edit(replace(control.editing.shot, start_timecode=new_timecode or None))


def _rate_field(control: TimeControl) -> None:
    """Draw the field of the frames per second."""
    rate = control.editing.shot.frames_per_second
    rate_text = f"{rate:.5g} fps"
    new_rate = widgets.text_field("frames per second", rate_text, rate, _parse_rate, control.notify)
    if new_rate != rate:
        control.editing.edit(replace(control.editing.shot, frames_per_second=new_rate))


def _option_tools(control: TimeControl) -> list[Tool]:
    """Return the choices of ending, pace and, if frames are missing, their substitute."""
    em, cache = imgui.get_font_size(), control.timeline.cache
    tools = [
        Tool(partial(_ending_choice, control), _COMBO_EM * em, 8, is_rare=True),
        Tool(partial(_pace_choice, control), _WIDE_EM * em, 8, is_rare=True),
    ]
    if control.timeline.missing == "hold" and (cache is None or not cache.sequence.missing):
        return tools  # nothing is missing
    return [*tools, Tool(partial(_missing_choice, control), _MISSING_EM * em, 8)]


def _ending_choice(control: TimeControl) -> None:
    playback, words = control.timeline.playback, {ending: str(ending) for ending in Ending}
    playback.ending = combo("ending", playback.ending, words)


def _pace_choice(control: TimeControl) -> None:
    playback = control.timeline.playback
    playback.is_every_frame = combo("pace", playback.is_every_frame, _PACE_NAMES)


def _missing_choice(control: TimeControl) -> None:
    timeline = control.timeline
    timeline.missing = combo("missing frames", timeline.missing, _MISSING_NAMES)


def combo(name: str, value: Key, words: Mapping[Key, str], other_text: str = "") -> Key:
    """Draw a drop-down of `words` without a label, with the width set for the next item.

    `other_text` is shown for a value without words.
    """
    if imgui.begin_combo(f"##{name}", words.get(value, other_text)):
        for key, text in words.items():
            is_picked, _ = imgui.selectable(text, key == value)
            rects.note(f"{name}: {text}")
            if is_picked:
                value = key
        imgui.end_combo()
    rects.note(name)
    return value


def _parse_frame(text: str) -> int:
    """Parse a frame number. Raise InputError if it is none."""
    try:
        frame = int(text)
    except ValueError:
        raise InputError(f"{text!r} is not a frame number.") from None
    check_frame(frame)
    return frame


def _parse_rate(text: str) -> float:
    """Parse frames per second, as a number or a fraction. Raise InputError if it is none."""
    number_text = text.lower().removesuffix("fps").strip().replace(",", ".")
    try:
        numerator, _, denominator = number_text.partition("/")
        rate = float(numerator) / float(denominator or 1)
    except (ValueError, ZeroDivisionError):
        raise InputError(f"{text!r} is not a frame rate. Example: 24 or 24000/1001.") from None
    check_frames_per_second(rate)
    return rate
