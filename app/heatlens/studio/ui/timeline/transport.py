"""Draw the transport row of the timeline: play, step, frame, timecode, rate and ending."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeVar

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import check_frame, check_frames_per_second
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.studio.session.desks import TimeDesk
from heatlens.studio.session.time.playback import Ending
from heatlens.studio.ui import probe, texts, theme, widgets
from heatlens.studio.ui.timeline.rendered_panel import rendered_label
from heatlens.studio.ui.timeline.tool_row import Tool, tool_row, word
from heatlens.studio.ui.timeline.view import TimelineView

Key = TypeVar("Key")

_FIELD_EM, _COMBO_EM, _WIDE_EM, _MISSING_EM = 4.6, 5.6, 7.6, 10.4
_TIMECODE_EM, _RATE_EM = 6.4, 6.2
_ICON = 1.15  # width of a button for its height
_PACES = {True: "every frame", False: "real time"}
_MISSING: dict[MissingPolicy, str] = {
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


def transport(desk: TimeDesk, view: TimelineView) -> None:
    """Draw the controls in one row; those without room are in a popup at its end."""
    em, frames = imgui.get_font_size(), f"of {desk.timeline.played}"
    tool_row(
        "transport",
        [
            *_buttons(desk),
            Tool(partial(_frame_field, desk), _FIELD_EM * em, 0),
            word(frames, 6, tip="Frames to play: I and O set in and out, Shift+I clears them."),
            Tool(partial(_timecode_field, desk), _TIMECODE_EM * em, 5),
            Tool(partial(_rate_field, desk), _RATE_EM * em, 7),
            *_choices(desk),
        ],
    )
    rendered_label(desk, view)


def _buttons(desk: TimeDesk) -> list[Tool]:
    timeline, direction = desk.timeline, desk.timeline.playback.direction
    does: tuple[tuple[int, str, str, str, Callable[[], None]], ...] = (
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
        (1, "record", "record", _RECORD_TIP, desk.recording.arm),
    )  # fmt: skip
    width, is_armed = _ICON * imgui.get_frame_height(), desk.recording.state.is_waiting

    def drawn(name: str, shape: str, tip: str, do: Callable[[], None]) -> None:
        if _icon(name, shape, tip, is_armed and name == "record"):
            do()

    return [
        Tool(partial(drawn, name, shape, tip, do), width, rank, gap=2.0)
        for rank, name, shape, tip, do in does
    ]


def _icon(name: str, shape: str, tip: str, is_on: bool = False) -> bool:
    side = imgui.get_frame_height()
    corner = imgui.get_cursor_screen_pos()
    with texts.colored(theme.colors.armed if is_on else None, imgui.Col_.button):
        pressed = imgui.button(f"##{name}", ImVec2(_ICON * side, side))
    probe.note(f"transport {name}")
    texts.tooltip(tip)
    middle = ImVec2(corner.x + 0.5 * _ICON * side, corner.y + side / 2)
    _draw_shape(shape, middle, 0.26 * side)
    return bool(pressed)


def _draw_shape(shape: str, middle: ImVec2, reach: float) -> None:
    draw, color = imgui.get_window_draw_list(), theme.colors.handle

    def at(x: float, y: float) -> ImVec2:
        return ImVec2(middle.x + x * reach, middle.y + y * reach)

    triangles, bars = _SHAPES[shape]
    for base, tip in triangles:
        draw.add_triangle_filled(at(base, -1), at(base, 1), at(tip, 0), color)
    for x in bars:
        draw.add_rect_filled(at(x - 0.15, -1), at(x + 0.15, 1), color)
    if shape == "record":
        draw.add_circle_filled(middle, reach, theme.colors.recorded)
    if shape == "stop":
        draw.add_rect_filled(at(-0.8, -0.8), at(0.8, 0.8), theme.colors.handle)


def _frame_field(desk: TimeDesk) -> None:
    frame = desk.editing.frame
    chosen = widgets.text_field("frame", str(frame), frame, _parse_frame, desk.say)
    if chosen != frame:
        desk.timeline.go(chosen)


def _timecode_field(desk: TimeDesk) -> None:
    """Draw the timecode of the frame; typing one sets the timecode of the first frame."""
    shown, parse = desk.timeline.timecode, desk.timeline.start_timecode
    chosen = widgets.text_field("timecode", shown, shown, parse, desk.say, "timecode")
    texts.tooltip(_TIMECODE_TIP)
    if chosen != shown:
        desk.editing.edit(replace(desk.editing.shot, start_timecode=chosen or None))


def _rate_field(desk: TimeDesk) -> None:
    rate = desk.editing.shot.frames_per_second
    shown = f"{rate:.5g} fps"
    chosen = widgets.text_field("frames per second", shown, rate, _parse_rate, desk.say)
    if chosen != rate:
        desk.editing.edit(replace(desk.editing.shot, frames_per_second=chosen))


def _choices(desk: TimeDesk) -> list[Tool]:
    em, cache = imgui.get_font_size(), desk.timeline.cache
    tools = [
        Tool(partial(_ending, desk), _COMBO_EM * em, 8),
        Tool(partial(_pace, desk), _WIDE_EM * em, 8),
    ]
    if desk.timeline.missing == "hold" and (cache is None or not cache.sequence.missing):
        return tools  # nothing is missing
    return [*tools, Tool(partial(_missing_frames, desk), _MISSING_EM * em, 8)]


def _ending(desk: TimeDesk) -> None:
    playback, words = desk.timeline.playback, {ending: str(ending) for ending in Ending}
    playback.ending = combo("ending", playback.ending, words)


def _pace(desk: TimeDesk) -> None:
    playback = desk.timeline.playback
    playback.is_every_frame = combo("pace", playback.is_every_frame, _PACES)


def _missing_frames(desk: TimeDesk) -> None:
    timeline = desk.timeline
    timeline.missing = combo("missing frames", timeline.missing, _MISSING)


def combo(name: str, value: Key, words: Mapping[Key, str], other: str = "") -> Key:
    """Draw a drop-down of `words` without a label, as wide as the next item was set to be.

    `other` is shown for a value without words.
    """
    if imgui.begin_combo(f"##{name}", words.get(value, other)):
        for key, text in words.items():
            picked, _ = imgui.selectable(text, key == value)
            probe.note(f"{name}: {text}")
            if picked:
                value = key
        imgui.end_combo()
    probe.note(name)
    return value


def _parse_frame(text: str) -> int:
    try:
        frame = int(text)
    except ValueError:
        raise InputError(f"{text!r} is not a frame number.") from None
    check_frame(frame)
    return frame


def _parse_rate(text: str) -> float:
    cleaned = text.lower().removesuffix("fps").strip().replace(",", ".")
    try:
        over, _, under = cleaned.partition("/")
        rate = float(over) / float(under or 1)
    except (ValueError, ZeroDivisionError):
        raise InputError(f"{text!r} is not a frame rate. Example: 24 or 24000/1001.") from None
    check_frames_per_second(rate)
    return rate
