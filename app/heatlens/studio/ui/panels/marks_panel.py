"""Draw the Marks panel, the marks in the picture, and the popup for a pull between marks."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.messages import report_errors
from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.live_focus import Follow
from heatlens.core.model.lens.lens import measured_text, parse_measured_m
from heatlens.core.model.marks.mark import Mark, MarkDistance
from heatlens.core.model.marks.marks import PointMark, WorldMark
from heatlens.core.model.marks.track_mark import TrackedPoint, TrackMark
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import PullShape
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view_geometry import Point
from heatlens.media.plate.mark_distance import world_point
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.board.facts import Facts
from heatlens.studio.ui import rects, texts, theme, topmost, widgets
from heatlens.studio.ui.field_row import field_row
from heatlens.studio.ui.panels.mark_row import mark_row_controls, same_line_if_fits
from heatlens.studio.ui.state import UiState

_NAME_EM, _MIN_NAME_EM, _DISTANCE_EM = 5.0, 3.2, 4.4
_ROW_EM = 20.5  # width of the widest row without the name of its mark
_PULL = "pull focus"
_PULL_EM = 22.0, 15.0  # width and largest height of its popup
_HERE = "here"
_RADIUS_EM = 0.33  # radius of the ring around a point
_MAX_PULL_FRAMES = 100_000  # frames
_KEYS_TIP = "Makes the few keys that describe this focus, to be edited."
_STOP_TIP = "Ends the following; the focus stays as it is at this frame."
_PULL_TIP = "Pulls the focus from here to a mark (Shift+M)."
_GO_ON_TIP = "Shift+Enter: goes to the end of the pull, where the next one begins."


def mark_buttons(control: TimeControl, ui: UiState) -> None:
    """Draw the buttons that set a mark and pull to one."""
    tip = "At the distance in focus (M). Ctrl+Shift+click in the picture marks what is there."
    if widgets.button("Set mark here", "set mark", tip):
        control.marks.set_here()
    imgui.same_line()
    if widgets.button("Pull focus...", "open pull", _PULL_TIP):
        ui.open_pull()


def marks_panel(control: TimeControl, unit: str, ui: UiState) -> None:
    """Draw the list of marks in the current window; distances are shown in `unit`."""
    mark_buttons(control, ui)
    em = imgui.get_font_size()
    free_em = imgui.get_content_region_avail().x / em - _ROW_EM
    name_em = min(max(free_em, _MIN_NAME_EM), _NAME_EM)
    if not control.editing.shot.marks:
        words = "No marks yet. Ctrl+Shift+click on an actor, or press M."
        imgui.text_wrapped(texts.named_keys(words))
    elif imgui.begin_table("marks", 3, imgui.TableFlags_.sizing_fixed_fit):
        imgui.table_setup_column("name", 0, name_em * em)
        imgui.table_setup_column("distance", 0, _DISTANCE_EM * em)
        imgui.table_setup_column("buttons", imgui.TableColumnFlags_.width_stretch)
        for mark in control.editing.shot.marks:
            _mark_row(control, unit, mark)
        imgui.end_table()
    _live_rows(control)
    _close_focus_row(control, unit)


def _live_rows(control: TimeControl) -> None:
    """Draw the marks that the focus follows live, with their settings and buttons, if any."""
    live_following = control.marks.live
    if live_following.live is None:
        return
    state = "is being measured" if live_following.is_measuring else "is live"
    texts.gray_text(f"The focus follows {printable(live_following.live.words)}: it {state}.")
    rects.note("focus follows")
    follow = live_following.live.follow
    for name in options_of(Follow):
        follow = field_row(follow, name)
    if follow != live_following.live.follow:
        live_following.change(follow)
    with widgets.disabled(not live_following.live.measured):
        if widgets.button("make keys", "make keys", _KEYS_TIP):
            live_following.make_keys()
    same_line_if_fits("stop following")
    if widgets.button("stop following", "stop following", _STOP_TIP):
        live_following.stop_following()


def _mark_row(control: TimeControl, unit: str, mark: Mark) -> None:
    """Draw the name, the distance and the buttons of a mark."""
    commands = control.marks
    imgui.table_next_row()
    imgui.table_next_column()
    imgui.set_next_item_width(-1)
    name = widgets.text_field(f"mark {mark.name}", mark.name, mark.name, str.strip, control.notify)
    if name != mark.name:
        with report_errors(control.notify):
            commands.change(mark, replace(mark, name=name))
    imgui.table_next_column()
    imgui.align_text_to_frame_padding()
    distance = commands.distances.distance(mark)
    imgui.text(_distance_text(control, distance, unit))
    full_text = ""
    if distance.distance_m is not None:
        full_text = f" {measured_text(control.editing.lens, distance.distance_m, unit)}."
    texts.tooltip(f"{mark.meaning}{full_text}")
    imgui.table_next_column()
    mark_row_controls(control, mark)


def _distance_text(control: TimeControl, distance: MarkDistance, unit: str) -> str:
    """Return the distance of a mark as text, or why there is none."""
    if distance.distance_m is not None:
        return texts.measured_label(control.editing.lens, distance.distance_m, unit)
    return "hidden" if distance.is_known else "measuring"


def _close_focus_row(control: TimeControl, unit: str) -> None:
    """Draw the field of the closest focus of the lens."""
    widgets.label("close focus", "The closest focus of the lens; frames focused nearer are red.")
    lens, limit_m = control.editing.lens, control.editing.lens.close_focus_m
    limit_text = "" if limit_m is None else measured_text(lens, limit_m, unit)
    parse = widgets.optional(partial(parse_measured_m, lens))
    typed_m = widgets.text_field(
        "close focus", limit_text, limit_m, parse, control.notify, "unknown"
    )
    if typed_m != limit_m:
        with report_errors(control.notify):
            control.editing.edit_lens(replace(lens, close_focus_m=typed_m))


def pull_popup(control: TimeControl, ui: UiState, unit: str) -> None:
    """Draw the popup that sets up a focus pull; Enter or its button makes the keys."""
    pulls, ui.pull_target = control.marks.pulls, ""
    if ui.opens_pull:
        ui.opens_pull = False
        if not control.editing.shot.marks:
            control.notify("Set a mark to pull to: M, or Ctrl+Shift+click in the picture.")
            return
        pulls.suggest()
        imgui.open_popup(_PULL)
    imgui.set_next_window_pos(_pull_corner(), imgui.Cond_.appearing)
    imgui.set_next_window_size(ImVec2(_PULL_EM[0] * imgui.get_font_size(), 0))
    if imgui.begin_popup(_PULL):
        topmost.disable_key_navigation()
        ui.pull_target = pulls.target
        imgui.text(f"Pull the focus from frame {control.editing.frame}")
        _pull_fields(control, unit)
        is_pressed = _pull_button("Pull", "pull", has_shift=False)
        imgui.same_line()
        continues = _pull_button(
            "Pull and go to its end", "pull and go on", has_shift=True, tip=_GO_ON_TIP
        )
        if is_pressed or continues:
            start = control.editing.frame
            end = start + pulls.frames
            # The keys of the pull are selected, which shows the handles to stretch it.
            pulls.make(
                partial(control.keys.select_between, LensParameter.FOCUS_DISTANCE, start, end)
            )
            imgui.close_current_popup()
        if continues:
            control.timeline.go_to(end)
        imgui.same_line()
        if widgets.button("Cancel", "cancel pull"):
            imgui.close_current_popup()
        imgui.end_popup()


def _pull_corner() -> ImVec2:
    """Return where the popup of the pull begins: under the focus bar, and never over the picture.

    Where there is no room under the bar, it stands at the foot of the column of panels.
    """
    em, screen = imgui.get_font_size(), imgui.get_main_viewport()
    width, height = (em * value for value in _PULL_EM)
    bottom = screen.work_pos.y + screen.work_size.y
    picture = imgui.internal.find_window_by_name("Picture")
    if picture is None:
        return screen.get_center()
    end = ImVec2(picture.pos.x + picture.size.x, picture.pos.y + picture.size.y)
    if end.y + height <= bottom:
        return ImVec2(picture.pos.x + (picture.size.x - width) / 2, end.y)
    return ImVec2(end.x, bottom - height)


def _pull_fields(control: TimeControl, unit: str) -> None:
    """Draw the fields of a pull, which change it: marks, frames, shape and ease."""
    pulls = control.marks.pulls
    names = [mark.name for mark in control.editing.shot.marks]
    origin_name = widgets.choice("from", pulls.origin or _HERE, [_HERE, *names])
    pulls.origin = None if origin_name == _HERE else origin_name
    pulls.target = widgets.choice("to mark", pulls.target, names)
    widgets.label("frames")
    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    _, frames = imgui.input_int("##pull frames", pulls.frames)
    rects.note("pull frames")
    frames = min(max(frames, 1), _MAX_PULL_FRAMES)
    if frames != pulls.frames:
        pulls.set_length(frames)
    pulls.shape = widgets.pick_one("shape", pulls.shape)
    if pulls.shape is not PullShape.LINEAR:
        ease = pulls.ease_percent
        tip = "0 starts and stops abruptly, 100 most gently"
        pulls.ease_percent = widgets.slider("ease", ease, 0.0, 100.0, "%.0f %%", tip)
    distance_text = _distance_text(control, pulls.arrival_at, unit)
    imgui.text(f"{printable(pulls.target)} at frame {pulls.arrival}: {distance_text}")
    if pulls.end_warning:
        imgui.text_wrapped(pulls.end_warning)


def _pull_button(words: str, name: str, has_shift: bool, tip: str = "") -> bool:
    """Draw a button that Enter presses too, with or without Shift."""
    is_pressed = widgets.button(words, name, tip)
    is_typing = imgui.is_any_item_active() or imgui.get_io().key_shift != has_shift
    is_entered = any(
        imgui.is_key_pressed(key, False) for key in (imgui.Key.enter, imgui.Key.keypad_enter)
    )
    return bool(is_pressed or (is_entered and not is_typing))


def draw_point_marks(facts: Facts, view: PictureView) -> None:
    """Draw the marks that have a point as rings with names, in the window of the picture."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    for mark, point in _placed_marks(facts):
        x, y = _window_point(facts, view, point)
        rects.note_at(f"point {mark.name}", (x, y, x, y))
        radius = _RADIUS_EM * em
        draw.add_circle(ImVec2(x, y), radius, theme.OVER_PICTURE.shadow, 0, 0.2 * em)
        draw.add_circle(ImVec2(x, y), radius, theme.OVER_PICTURE.mark, 0, 0.1 * em)
        text_corner = ImVec2(x + radius + 0.2 * em, y - em / 2)
        is_hidden = isinstance(point, TrackedPoint) and point.distance_m is None
        name = printable(mark.name) + " (hidden)" * is_hidden
        draw.add_text(ImVec2(text_corner.x + 1, text_corner.y + 1), theme.OVER_PICTURE.shadow, name)
        draw.add_text(text_corner, theme.OVER_PICTURE.mark, name)


def mark_in_window(facts: Facts, view: PictureView, name: str) -> Point | None:
    """Return where the mark `name` lies in the window; None if it has no point in the picture."""
    points = (point for mark, point in _placed_marks(facts) if mark.name == name)
    return next((_window_point(facts, view, point) for point in points), None)


def _placed_marks(facts: Facts) -> Iterator[tuple[Mark, PointMark | TrackedPoint]]:
    """Yield the marks that have a point in the picture at this frame, with that point."""
    for mark in facts.shot.marks:
        point: Mark | TrackedPoint | None = mark
        if isinstance(mark, TrackMark):
            point = mark.point_at(facts.frame)
        elif isinstance(mark, WorldMark) and facts.plate is not None:
            point = world_point(facts.plate, mark, facts.lens)
        if isinstance(point, PointMark | TrackedPoint):
            yield mark, point


def _window_point(facts: Facts, view: PictureView, point: PointMark | TrackedPoint) -> Point:
    """Return where the center of a mark's pixel is in the window."""
    picture_point = facts.picture_point((point.x_px + 0.5, point.y_px + 0.5))
    return view.geometry.window_at_picture(picture_point)
