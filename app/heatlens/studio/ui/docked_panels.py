"""Draw the open panels: give each one its values and apply the values that it returns.

The Speed panel shows pictures per second, the time of each pass, memory and the GPU.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from imgui_bundle import imgui

from heatlens.core.base.messages import window_words
from heatlens.core.model.focus.plausibility import Doubt, find_doubts
from heatlens.core.model.shot.settings import Quality
from heatlens.media.plate.plate import depth_span
from heatlens.render.display.probe import visible_depth_m
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.preview.shown import Shown
from heatlens.render.preview.speed import Speed
from heatlens.studio.board.board import Board
from heatlens.studio.board.desks import TimeDesk
from heatlens.studio.board.plan import PlanDrawer
from heatlens.studio.board.session import Session
from heatlens.studio.ui import widgets
from heatlens.studio.ui.panels.blur_panel import blur_panel
from heatlens.studio.ui.panels.display_panel import display_panel
from heatlens.studio.ui.panels.export_panel import draw_exports
from heatlens.studio.ui.panels.guides_panel import guides_panel
from heatlens.studio.ui.panels.lens_panel import LensFacts, film_back_panel, kit_panel, lens_panel
from heatlens.studio.ui.panels.looks_panel import LookStills, looks_panel
from heatlens.studio.ui.panels.marks_panel import marks_panel
from heatlens.studio.ui.panels.opening_panel import opening_panel
from heatlens.studio.ui.panels.plan_panel import PlanPanel
from heatlens.studio.ui.panels.plate_panel import PlateFacts, plate_panel
from heatlens.studio.ui.panels.reel_panel import ReelStills, reel_panel
from heatlens.studio.ui.panels.ring_panel import ring_panel
from heatlens.studio.ui.panels.scene_panel import scene_panel
from heatlens.studio.ui.picture.grid import Pictures
from heatlens.studio.ui.probe import listening
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.timeline.dope_sheet import lens_dots
from heatlens.studio.ui.timeline.panel import timeline_panel

_UNMEASURED = "\N{EN DASH}"


def speed_panel(
    speed: Speed, upload_s: float, picture: Shown | None, renderer: FrameRenderer
) -> None:
    """Draw the Speed panel; its checkbox switches the renderer's stopwatch."""
    imgui.text_disabled(renderer.ctx.name)
    rows = [
        ("window", _value_text(speed.mean_ms(), "{:.1f} ms a frame")),
        ("while dragged", _value_text(speed.pictures_per_second(), "{:.0f} pictures a second")),
        ("upload", _value_text(1e3 * upload_s or None, "{:.1f} ms, once a file")),
        ("memory", f"{_resident_mb():.0f} MB"),
        ("solver", renderer.solver.name),
    ]
    if picture is not None:
        settings, (width, height) = picture.settings, picture.texture.size
        quality = "" if settings.quality is Quality.PREVIEW else f", {settings.effective_quality}"
        quality_words = "whole" if picture.is_whole else f"preview{quality}"
        rows.insert(
            0, ("picture", f"{1e3 * picture.seconds:.0f} ms, {width}x{height}, {quality_words}")
        )
    _fact_rows(rows)
    watch = renderer.stopwatch
    is_on = widgets.check("time each pass", watch.is_on)
    if is_on != watch.is_on:
        watch.is_on = is_on
        watch.times.clear()
    _fact_rows([(name, f"{1e3 * timing.seconds:.1f} ms") for name, timing in watch.times.items()])


def _value_text(value: float | None, template: str) -> str:
    """Return a value formatted by a template, or a dash if it was not measured."""
    return _UNMEASURED if value is None else template.format(value)


def _fact_rows(rows: list[tuple[str, str]]) -> None:
    for label, value in rows:
        widgets.fact_row(label, value, f"speed {label}")


def _resident_mb() -> float:
    """Return the resident memory of this process in MB; 0 if the system does not report it."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * 4096 / 1e6


# Panels that are empty until a picture is open, and the flags of windows that have any.
_PICTURE_PANELS = ("Lens", "Plate", "Scene", "Export", "Marks", "Plan", "Looks")
_FLAGS = {
    "Scene": imgui.WindowFlags_.no_focus_on_appearing,
    "Reel": imgui.WindowFlags_.no_focus_on_appearing,
    "Timeline": imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_focus_on_appearing,
}


# Panels stay empty until something is open. Otherwise, while a file of the command line is read,
# they would show a default lens that then jumps to that of the file.
class DockedPanels:
    """Draws the panels that are open."""

    def __init__(self, session: Session, board: Board, ui: UiState, screen: ScreenPictures) -> None:
        self._session, self._board = session, board
        self._facts, self._editing, self._time = session.facts, session.editing, session.time
        self._say = session.messages.say
        self._ui = ui
        self._plan_drawer, self._plan_panel = PlanDrawer(), PlanPanel()
        self._hovered: tuple[int, int] | None = None
        self._reel_stills = ReelStills(session.facts, session.pictures, screen)
        self.stills = LookStills(session.facts, session.pictures)

    def draw(self, hovered: tuple[int, int] | None, pictures: Pictures | None) -> None:
        """Draw the panels; `hovered` is the pixel of the display window under the pointer.

        `pictures` are those in the viewport; stills of looks and scenes are taken from them.
        """
        self._hovered = hovered
        panels: dict[str, Callable[[], None]] = {
            "Lens": self._draw_lens,
            "Display": self._draw_display,
            "Plate": self._draw_plate,
            "Scene": partial(scene_panel, self._time),
            "Marks": partial(marks_panel, self._time, self._facts.unit, self._ui),
            "Plan": self._draw_plan,
            "Looks": partial(
                looks_panel, self._facts, self._board, self._session.pictures, self.stills
            ),
            "Reel": partial(reel_panel, self._ui.files, self._facts.unit, self._reel_stills),
            "Guides": self._draw_guides,
            "Export": self._draw_export,
            "Speed": self._draw_speed,
            "Timeline": partial(timeline_panel, self._time, self._ui.timeline, self._facts.unit),
        }
        for name, draw in panels.items():
            if self._is_shown(name):
                if name == "Looks":
                    self.stills.take_thumbnail(pictures)
                if name == "Reel":
                    self._reel_stills.begin(self._ui.files, pictures)
                self._draw_panel(name, draw)

    def _is_shown(self, name: str) -> bool:
        """Return True if a panel is open and has something to show."""
        if name == "Timeline":
            return self._ui.is_timeline_shown
        has_content = {
            "Scene": self._facts.has_camera,
            "Reel": self._ui.files.reel.reel is not None,
        }
        return self._ui.panels[name] and has_content.get(name, True)

    def _draw_panel(self, name: str, draw: Callable[[], None]) -> None:
        """Draw the window of a panel, and its content unless it is covered or has no picture."""
        is_visible, is_open = imgui.begin(name, True, _FLAGS.get(name, 0))
        self._ui.panels[name] = bool(is_open)
        if is_visible and self._ui.files.start_choices.is_nothing_open and name in _PICTURE_PANELS:
            imgui.text_disabled("Waits for a picture.")
        elif is_visible:
            draw()
        imgui.end()

    def _draw_lens(self) -> None:
        """Draw the Lens panel, and apply changes of the lens, the kit and the blur."""
        facts, say, lens = self._facts, self._say, self._session.lens
        if facts.is_waiting:
            return
        start_lens, plate, kits = lens.commands.start_lens, facts.plate, lens.commands.kits
        lens_facts = LensFacts(
            *(facts.histogram, facts.unit, {} if start_lens is None else start_lens.sources),
            *(self._editing.trial_parameters, self._current_doubts()),
            brings_coc=plate is not None and not plate.has_distances,
            kit_lens=kits.mounted_lens,
        )
        ring_panel(lens, facts.unit, say)
        with listening() as drawn_rows:
            self._editing.edit_lens(lens_panel(facts.lens, lens_facts, say))
        size_row(self._time)
        kit_panel(facts.shot.kit, facts.lens, lens)
        ask_image = partial(self._ui.dialogs.ask, "opening")
        self._editing.edit_lens(opening_panel(facts.lens, say, ask_image))
        with listening() as folded_rows:
            self._editing.edit_lens(film_back_panel(facts.lens, say))
        defocus = blur_panel(facts.shot.defocus, facts.has_many_views)
        self._editing.edit(replace(facts.shot, defocus=defocus))
        if facts.histogram is not None and self._time.timeline.has_time:
            lens_dots(self._time, drawn_rows | folded_rows)

    def _current_doubts(self) -> tuple[Doubt, ...]:
        """Return implausible values of lens and plate; none for a scene, whose unit is known."""
        facts, plate = self._facts, self._facts.plate
        if plate is None or facts.has_camera or not plate.has_distances:
            return ()
        return find_doubts(facts.lens, depth_span(plate, facts.shot.plate_options.scene_unit_m))

    def _draw_display(self) -> None:
        """Draw the Display panel, and apply changes of the view."""
        facts, pictures = self._facts, self._session.pictures
        name = None if facts.reference is None else facts.reference.path.name
        pictures.view.state = display_panel(
            facts.view, pictures.color, name, facts.has_many_views, self._say, facts.shot.grade
        )

    def _draw_plate(self) -> None:
        """Draw the Plate panel, and read the plate again with changed options."""
        facts, plate, stream = self._facts, self._facts.plate, self._facts.stream
        if stream is not None and (stream.refusal or stream.arriving):
            imgui.text_wrapped(window_words(stream.status_text))
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
        ask_behind = partial(self._ui.dialogs.ask, "behind")
        pick_matte = partial(self._time.marks.pick_matte, reading.change_matte)
        reading.change(plate_panel(reading.options, plate_facts, self._say, ask_behind, pick_matte))

    def _draw_export(self) -> None:
        """Draw the Export panel, or the reason why nothing can be exported."""
        exports = self._ui.files.exports
        if exports.why_not:
            imgui.text_wrapped(exports.why_not)
        else:
            draw_exports(self._ui.files, self._session.pictures)

    def _draw_speed(self) -> None:
        pictures, upload_s = self._session.pictures, self._session.source.picture.upload_s
        speed_panel(self._time.speed, upload_s, pictures.live.output, pictures.renderer)

    def _draw_plan(self) -> None:
        """Draw the Plan panel, and apply a dragged focus or mark."""
        facts, plate, marks = self._facts, self._facts.plate, self._time.marks
        if plate is None:
            return
        if not plate.has_distances:
            imgui.text_wrapped("A plan needs distances, and this plate has none.")
            return
        mark_distances = [
            (mark, distance_m)
            for mark in facts.shot.marks
            if (distance_m := marks.distances.distance_m(mark)) is not None
        ]
        plan = self._plan_drawer.plan(
            plate, facts.lens, mark_distances, facts.picture_shape.width_px
        )
        moves = self._plan_panel.draw(plan, facts.lens, facts.unit)
        if moves.focus_m is not None:
            self._session.lens.commands.focus(moves.focus_m)
        elif moves.mark:
            marks.move_distance(moves.mark, moves.mark_m)

    def _draw_guides(self) -> None:
        view, squeeze = self._session.pictures.view, self._facts.lens.squeeze
        view.state = guides_panel(view.state, squeeze, self._say)


_NO_MARK_WORDS = "the picture zooms"
_FRAMING_TIP = (
    "What a change of the focal length keeps. With the size of a mark, the camera of a scene moves "
    "along its axis until what is there is as large as before: focus, keys and marks follow. "
    "Ctrl and the wheel move the camera, and the focal length follows."
)


def size_row(desk: TimeDesk) -> None:
    """Draw the choice of the mark that keeps its size while the focal length changes."""
    size = desk.scenes.size
    words: dict[str | None, str] = {None: _NO_MARK_WORDS} | {
        name: f"same size of {name}" for name in size.names
    }
    mark_name = widgets.pick("framing", size.chosen, words, _FRAMING_TIP)
    if mark_name != size.chosen:
        size.chosen = mark_name
