"""Draw the open panels: give each one its values and apply the values that it returns."""

from collections.abc import Callable
from functools import partial

from imgui_bundle import imgui

from heatlens.core.base.messages import window_words
from heatlens.core.model.focus.plausibility import Doubt, find_doubts
from heatlens.media.plate.plate import depth_span
from heatlens.render.display.pixel_reading import visible_depth_m
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.board.plan import PlanDrawer
from heatlens.studio.board.session import Session
from heatlens.studio.ui import widgets
from heatlens.studio.ui.panels.display_panel import display_panel
from heatlens.studio.ui.panels.export_panel import draw_exports
from heatlens.studio.ui.panels.lens_panel import LensFacts, film_back_panel, kit_panel, lens_panel
from heatlens.studio.ui.panels.looks_panel import LookStills, looks_panel
from heatlens.studio.ui.panels.marks_panel import mark_buttons, marks_panel
from heatlens.studio.ui.panels.opening_panel import opening_panel
from heatlens.studio.ui.panels.plan_panel import PlanPanel
from heatlens.studio.ui.panels.reel_stills import ReelStills
from heatlens.studio.ui.panels.reel_strip import ReelStrip, StripButtons
from heatlens.studio.ui.panels.rendering_panel import rendering_panel, speed_rows
from heatlens.studio.ui.panels.ring_panel import ring_panel
from heatlens.studio.ui.panels.scene_panel import scene_panel
from heatlens.studio.ui.panels.source_panel import PlateFacts, depth_rows, file_rows, plate_panel
from heatlens.studio.ui.panels.source_rows import matte_rows
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.rects import listening
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.timeline.dope_sheet import lens_dots
from heatlens.studio.ui.timeline.panel import timeline_panel
from heatlens.studio.ui.window_commands import save_reel

# Panels that are empty until a picture is open, and the flags of windows that have any.
_PICTURE_PANELS = ("Lens", "Marks", "Looks", "Export")
# Six tabs stand side by side in the column, without room for crosses: the Window menu closes them.
_CLOSED_BY_TAB = ("Timeline",)
_FLAGS = {
    "Source": imgui.WindowFlags_.no_focus_on_appearing,
    "Reel strip": imgui.WindowFlags_.no_focus_on_appearing,
    "Timeline": imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_focus_on_appearing,
}


# Panels stay empty until something is open. Otherwise, while a file of the command line is read,
# they would show a default lens that then jumps to that of the file.
class DockedPanels:
    """Draws the panels that are open."""

    def __init__(self, session: Session, board: Board, ui: UiState, screen: ScreenPictures) -> None:
        self._session, self._board = session, board
        self._editing, self._time = session.editing, session.time
        self._notify = session.messages.notify
        self._ui = ui
        self._plan_drawer, self._plan_panel = PlanDrawer(), PlanPanel()
        self._hovered: tuple[int, int] | None = None
        self._examined_source: str | None = None  # the source whose depth was looked at for doubts
        self._reel_stills = ReelStills(board, session.pictures, screen)
        buttons = StripButtons(partial(ui.dialogs.ask, "reel shot"), partial(save_reel, ui))
        self._had_reel = False
        self._reel_strip = ReelStrip(ui.files, self._reel_stills, buttons)
        self.stills = LookStills(board, session.pictures)

    def draw(self, hovered: tuple[int, int] | None, pictures: Pictures | None) -> None:
        """Draw the panels; `hovered` is the pixel of the display window under the pointer.

        `pictures` are those in the viewport; stills of looks and scenes are taken from them.
        """
        self._hovered = hovered
        panels: dict[str, Callable[[], None]] = {
            "Lens": self._draw_lens,
            "Marks": self._draw_marks,
            "Looks": partial(looks_panel, self._board, self._session.pictures, self.stills),
            "Display": self._draw_display,
            "Export": self._draw_export,
            "Source": self._draw_source,
            "Reel strip": partial(self._reel_strip.draw, self._board.facts.unit),
            "Timeline": partial(
                timeline_panel, self._time, self._ui.timeline, self._board.facts.unit
            ),
        }
        has_reel = self._ui.files.reel.reel is not None
        if has_reel and not self._had_reel:
            self._ui.panels["Reel strip"] = True
        self._had_reel = has_reel
        for name, draw in panels.items():
            if self._is_shown(name):
                if name == "Looks":
                    self.stills.take_thumbnail(pictures)
                if name == "Reel strip":
                    self._reel_stills.begin(self._ui.files, pictures)
                self._draw_panel(name, draw)
        self._show_doubtful_source()

    def _show_doubtful_source(self) -> None:
        """Bring the Source panel to the front, once for each source whose depth is doubtful."""
        plate, source = self._board.facts.plate, self._board.facts.shot.source
        if plate is None or source == self._examined_source:
            return
        self._examined_source = source
        if plate.depth.question or any(it.about == "depth" for it in self._current_doubts()):
            self._ui.panels["Source"] = True
            imgui.set_window_focus("Source")

    def _is_shown(self, name: str) -> bool:
        """Return True if a panel is open and has something to show."""
        if name == "Timeline":
            return self._ui.is_timeline_shown
        has_content = {
            "Source": not self._ui.files.start_choices.is_nothing_open,
            "Reel strip": self._ui.files.reel.reel is not None,
        }
        return self._ui.panels[name] and has_content.get(name, True)

    def _draw_panel(self, name: str, draw: Callable[[], None]) -> None:
        """Draw the window of a panel, and its content unless it is covered or has no picture."""
        has_closer = True if name in _CLOSED_BY_TAB else None
        is_visible, is_open = imgui.begin(name, has_closer, _FLAGS.get(name, 0))
        self._ui.panels[name] = is_open is not False
        if is_visible and self._ui.files.start_choices.is_nothing_open and name in _PICTURE_PANELS:
            imgui.text_disabled("Open a picture first.")
        elif is_visible:
            draw()
        imgui.end()

    def _draw_lens(self) -> None:
        """Draw the Lens panel, and apply changes of the lens, the kit and the blur."""
        facts, notify, lens = self._board.facts, self._notify, self._session.lens
        if facts.is_waiting:
            return
        start_lens, plate, kits = lens.commands.start_lens, facts.plate, lens.commands.kits
        lens_facts = LensFacts(
            *(facts.histogram, facts.unit, {} if start_lens is None else start_lens.sources),
            *(self._editing.trial_parameters, self._current_doubts()),
            brings_coc=plate is not None and not plate.has_distances,
            kit_lens=kits.mounted_lens,
        )
        ring_panel(lens, facts.unit, notify)
        with listening() as drawn_rows:
            buttons = partial(mark_buttons, self._time, self._ui)
            self._board.change(lens_panel(facts.lens, lens_facts, notify, buttons))
        size_row(self._time)
        facts = self._board.facts
        kit_panel(facts.shot.kit, facts.lens, lens)
        ask_image = partial(self._ui.dialogs.ask, "opening")
        self._board.change(opening_panel(self._board.facts.lens, notify, ask_image))
        with listening() as folded_rows:
            self._board.change(film_back_panel(self._board.facts.lens, notify))
        self._draw_mattes()
        facts = self._board.facts
        self._board.change(
            rendering_panel(facts.shot.defocus, facts.has_many_views, self._draw_speed)
        )
        if facts.histogram is not None and self._time.timeline.has_time:
            flags = imgui.HoveredFlags_.allow_when_blocked_by_active_item
            is_pointed_at = imgui.is_window_hovered(flags)
            lens_dots(self._time, drawn_rows | folded_rows, is_pointed_at)

    def _current_doubts(self) -> tuple[Doubt, ...]:
        """Return implausible values of lens and plate; none for a scene, whose unit is known."""
        facts, plate = self._board.facts, self._board.facts.plate
        if plate is None or facts.has_camera or not plate.has_distances:
            return ()
        return find_doubts(facts.lens, depth_span(plate, facts.shot.plate_options.scene_unit_m))

    def _draw_display(self) -> None:
        """Draw the Display panel, and apply changes of the view."""
        facts, pictures = self._board.facts, self._session.pictures
        name = None if facts.reference is None else facts.reference.path.name
        self._board.change(
            display_panel(
                *(facts.view, pictures.color, name, facts.has_many_views, self._notify),
                *(facts.shot.grade, facts.lens.squeeze, pictures.channel.choices),
            )
        )

    def _draw_mattes(self) -> None:
        """Draw the mattes that the blur of a plate heeds, and read it again with changed ones."""
        if self._board.facts.has_camera:
            return
        reading = self._ui.files.commands.reading
        pick_matte = partial(self._time.marks.pick_matte, reading.change_matte)
        reading.change(matte_rows(reading.options, self._notify, pick_matte))

    def _draw_source(self) -> None:
        """Draw the Source panel: the scene, or how the plate is read, with changed options."""
        facts = self._board.facts
        plate, stream = facts.plate, facts.stream
        if stream is not None and (stream.refusal or stream.arriving):
            imgui.text_wrapped(window_words(stream.status_text))
        if facts.has_camera:
            scene_panel(self._time)
        if plate is None:
            return
        hovered_m = None
        if self._hovered is not None:
            hovered_m = visible_depth_m(plate, facts.plate_px(facts.frame_px(self._hovered)))
        reading = self._ui.files.commands.reading
        plate_facts = PlateFacts(
            *(plate, facts.histogram, hovered_m, facts.unit, window_words(reading.problem)),
            *(facts.lens, self._current_doubts(), reading.read_options),
        )
        if facts.has_camera:
            if widgets.folded_header("Depth and file", ()):
                depth_rows(plate_facts)
                file_rows(plate_facts)
            return
        ask_behind = partial(self._ui.dialogs.ask, "behind")
        reading.change(plate_panel(reading.options, plate_facts, self._notify, ask_behind))

    def _draw_export(self) -> None:
        """Draw the Export panel, or the reason why nothing can be exported."""
        exports = self._ui.files.exports
        if exports.why_not:
            imgui.text_wrapped(exports.why_not)
        else:
            draw_exports(self._ui.files, self._session.pictures)

    def _draw_speed(self) -> None:
        """Draw the times of playback, upload and rendering."""
        pictures, upload_s = self._session.pictures, self._session.source.picture.upload_s
        speed_rows(self._time.speed, upload_s, pictures.live.output, pictures.renderer)

    def _draw_marks(self) -> None:
        """Draw the Marks panel: the list, and under it the plan."""
        marks_panel(self._time, self._board.facts.unit, self._ui)
        self._draw_plan()

    def _draw_plan(self) -> None:
        """Draw the plan, and apply a dragged focus or mark."""
        facts, plate, marks = self._board.facts, self._board.facts.plate, self._time.marks
        if plate is None or not plate.has_distances:
            return
        imgui.separator_text("Plan")
        mark_distances = [
            (mark, distance_m)
            for mark, distance_m in facts.mark_distances_m
            if distance_m is not None
        ]
        plan = self._plan_drawer.plan(plate, facts.lens, mark_distances, facts.shape.width_px)
        moves = self._plan_panel.draw(plan, facts.lens, facts.unit)
        if moves.focus_m is not None:
            self._session.lens.commands.focus(moves.focus_m)
        elif moves.mark:
            marks.move_distance(moves.mark, moves.mark_m)


_NO_MARK_WORDS = "picture zooms"
_FRAMING_TIP = (
    "What a change of the focal length keeps. With the size of a mark, the camera of a scene moves "
    "along its axis until what is there is as large as before: focus, keys and marks follow. "
    "Ctrl and the wheel move the camera, and the focal length follows."
)


def size_row(control: TimeControl) -> None:
    """Draw the choice of the mark that keeps its size while the focal length changes."""
    size = control.scenes.size
    words: dict[str | None, str] = {None: _NO_MARK_WORDS} | {
        name: f"camera moves, {name} keeps its size" for name in size.names
    }
    mark_name = widgets.pick("lens change", size.chosen, words, _FRAMING_TIP)
    if mark_name != size.chosen:
        size.chosen = mark_name
