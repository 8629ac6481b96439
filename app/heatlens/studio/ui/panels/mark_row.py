"""Draw the controls of a mark in its row: focus, follow, what it holds on to, delete."""

from dataclasses import replace

from imgui_bundle import imgui

from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, MarkAnchor, MatteMark, MattePart
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, texts, widgets

_HOLD_EM, _WIDEST_HOLD = 6.0, "surface    "
_FOLLOW_TIP = "Keys the focus on it at every frame from in to out; frames not in memory are read."
_LIVE_TIP = "Keeps the focus on it in place of keys: changed plates, marks or lenses change it."
_CORRECT_TIP = "Ctrl+Shift+click then tells where the surface is at this frame."
_STOP_TIP = "Ends the tracking of the surface; the mark stays as it was."
_PART_TIP = "The part of the object that is measured: its middle, or its nearest part."
_GAP = 4.0  # between the buttons of a mark, in pixels
_HOLD_TIP = (
    "What the mark holds on to over the frames: the thing of a matte, a place in the world, a\n"
    "surface that is tracked, or a pixel of the picture. The click chooses; change it here."
)


def mark_row_controls(control: TimeControl, mark: Mark) -> None:
    """Draw the controls of a mark, and run the command of a pressed one."""
    commands = control.marks
    if widgets.button(f"focus##{mark.name}", f"go {mark.name}"):
        commands.focus_on(mark)
    tracking = commands.anchors.tracking
    if tracking.follows(mark):
        same_line_if_fits("stop tracking")
        if widgets.button(f"stop tracking##{mark.name}", f"stop {mark.name}", _STOP_TIP):
            tracking.stop(mark)
    elif not isinstance(mark, DistanceMark):
        same_line_if_fits("follow")
        with widgets.disabled(commands.is_reading):
            if widgets.button(f"follow##{mark.name}", f"follow {mark.name}", _FOLLOW_TIP):
                commands.follow(mark)
        same_line_if_fits(_WIDEST_HOLD)
        _hold_choice(control, mark)
    if isinstance(mark, TrackMark) and control.timeline.cache is not None:
        same_line_if_fits("correct")
        if widgets.button(f"correct##{mark.name}", f"correct {mark.name}", _CORRECT_TIP):
            commands.anchors.correct(mark)
    if isinstance(mark, MatteMark):
        _part_button(control, mark)
    same_line_if_fits("x")
    if widgets.button(f"x##{mark.name}", f"delete {mark.name}"):
        commands.delete(mark)


def _hold_choice(control: TimeControl, mark: Mark) -> None:
    """Draw the drop-down of what the mark holds on to, and of keeping the focus on it."""
    commands, anchor = control.marks, MarkAnchor.of(mark)
    imgui.set_next_item_width(_HOLD_EM * imgui.get_font_size())
    is_open = imgui.begin_combo(f"##hold {mark.name}", str(anchor or "object"))
    rects.note(f"hold {mark.name}")
    if not is_open:
        texts.tooltip(_HOLD_TIP)
        return
    with widgets.disabled(commands.is_reading):
        for other in _anchors(control, anchor):
            is_picked, _ = imgui.selectable(f"the {other}", other is anchor)
            rects.note(f"hold {mark.name}: {other}")
            if is_picked and other is not anchor:
                commands.anchors.anchor_to(mark, other)
    imgui.separator()
    if imgui.selectable("keep the focus on it", False)[0]:
        commands.live.follow(mark)
    rects.note(f"live {mark.name}")
    texts.tooltip(_LIVE_TIP)
    imgui.end_combo()


def _anchors(control: TimeControl, anchor: MarkAnchor | None) -> tuple[MarkAnchor, ...]:
    """Return what a mark that holds on to `anchor` can hold on to in the open source."""
    if anchor is None or anchor is MarkAnchor.THING:
        return () if anchor is None else (anchor,)
    places = (
        (MarkAnchor.PLACE,) if control.marks.anchors.has_world or anchor is MarkAnchor.PLACE else ()
    )
    surfaces = (MarkAnchor.SURFACE,) if control.timeline.cache is not None else ()
    return (*places, *surfaces, MarkAnchor.PIXEL)


def _part_button(control: TimeControl, mark: MatteMark) -> None:
    """Draw the button that switches the measured part of a thing."""
    words = f"measure: {mark.part}"
    same_line_if_fits(words)
    if widgets.button(f"{words}##{mark.name}", f"part {mark.name}", _PART_TIP):
        other_parts = [part for part in MattePart if part is not mark.part]
        control.marks.change(mark, replace(mark, part=other_parts[0]))


def same_line_if_fits(word: str) -> None:
    """Stay in the line if a button with this word fits there, else begin the next line."""
    width = imgui.calc_text_size(word).x + 2 * imgui.get_style().frame_padding.x
    end = imgui.get_item_rect_max().x + _GAP + width
    if end <= imgui.internal.get_current_window().work_rect.max.x:
        imgui.same_line(0.0, _GAP)
