"""Draw the open panels: give each one its values and apply the values that it returns.

The Speed panel shows pictures per second, the time of each pass, memory and the GPU.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from imgui_bundle import imgui

from heatlens.core.model.focus.plausibility import Doubt, doubts
from heatlens.core.model.shot.settings import Quality
from heatlens.media.plate.plate import depth_span
from heatlens.render.display.probe import seen_depth_m
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.preview.shown import Shown
from heatlens.studio.session.marks.plan import PlanDrawer
from heatlens.studio.session.messages import window_words
from heatlens.studio.session.scenes.size_keeping import SizeKeeping
from heatlens.studio.session.session import Session
from heatlens.studio.session.speed import Speed
from heatlens.studio.ui import widgets
from heatlens.studio.ui.panels.blur_panel import blur_panel
from heatlens.studio.ui.panels.display_panel import display_panel
from heatlens.studio.ui.panels.export_panel import draw_exports
from heatlens.studio.ui.panels.guides_panel import guides_panel
from heatlens.studio.ui.panels.lens_panel import (
    LensFacts,
    film_back_panel,
    kit_panel,
    lens_panel,
)
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
    speed: Speed, upload_s: float, shown: Shown | None, renderer: FrameRenderer
) -> None:
    """Draw the panel; its checkbox switches the renderer's stopwatch."""
    imgui.text_disabled(renderer.ctx.name)
    rows = [
        ("window", _text(speed.mean_ms(), "{:.1f} ms a frame")),
        ("while dragged", _text(speed.pictures_per_second(), "{:.0f} pictures a second")),
        ("upload", _text(1e3 * upload_s or None, "{:.1f} ms, once a file")),
        ("memory", f"{_resident_mb():.0f} MB"),
        ("solver", renderer.solver.name),
    ]
    if shown is not None:
        settings, (width, height) = shown.settings, shown.texture.size
        quality = "" if settings.quality is Quality.PREVIEW else f", {settings.at_quality}"
        whole = "whole" if shown.is_whole else f"preview{quality}"
        rows.insert(0, ("picture", f"{1e3 * shown.seconds:.0f} ms, {width}x{height}, {whole}"))
    _rows(rows)
    watch = renderer.stopwatch
    is_on = widgets.check("time each pass", watch.on)
    if is_on != watch.on:
        watch.on = is_on
        watch.times.clear()
    _rows([(name, f"{1e3 * t.seconds:.1f} ms") for name, t in watch.times.items()])


def _text(value: float | None, words: str) -> str:
    return _UNMEASURED if value is None else words.format(value)


def _rows(rows: list[tuple[str, str]]) -> None:
    for label, value in rows:
        widgets.fact(label, value, f"speed {label}")


def _resident_mb() -> float:
    """Return the resident memory of this process in MB; 0 if the system does not report it."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * 4096 / 1e6


# Panels that are empty until a picture is open, and the flags of windows that have any.
_NEED_A_PICTURE = ("Lens", "Plate", "Scene", "Export", "Marks", "Plan", "Looks")
_FLAGS = {
    "Scene": imgui.WindowFlags_.no_focus_on_appearing,
    "Reel": imgui.WindowFlags_.no_focus_on_appearing,
    "Timeline": imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_focus_on_appearing,
}


# Until a file of the command line had been read, panels showed a lens that nobody had chosen, which
# then jumped to that of the file. They now stay empty until something is open.
class DockedPanels:
    """Draws the panels that are open."""

    def __init__(self, session: Session, ui: UiState, screen: ScreenPictures) -> None:
        self._session = session
        self._facts, self._editing, self._time = session.facts, session.editing, session.time
        self._say = session.messages.say
        self._ui = ui
        self._planned, self._plan_panel = PlanDrawer(), PlanPanel()
        self._hovered: tuple[int, int] | None = None
        self._reel_stills = ReelStills(session.facts, session.pictures, screen)
        self.stills = LookStills(session.facts, session.pictures)

    def draw(self, hovered: tuple[int, int] | None, pictures: Pictures | None) -> None:
        """Draw the panels; `hovered` is the pixel of the display window under the pointer.

        `pictures` are those in the viewport; stills of looks and scenes are taken from them.
        """
        self._hovered = hovered
        panels: dict[str, Callable[[], None]] = {
            "Lens": self._lens,
            "Display": self._display,
            "Plate": self._plate,
            "Scene": partial(scene_panel, self._session.scenes, self._editing, self._say),
            "Marks": partial(marks_panel, self._time, self._facts.unit, self._ui),
            "Plan": self._plan,
            "Looks": partial(looks_panel, self._facts, self._session.pictures, self.stills),
            "Reel": partial(reel_panel, self._ui.files.reel, self._facts.unit, self._reel_stills),
            "Guides": self._guides,
            "Export": self._export,
            "Speed": self._speed,
            "Timeline": partial(timeline_panel, self._time, self._ui.timeline, self._facts.unit),
        }
        for name, draw in panels.items():
            if self._is_shown(name):
                if name == "Looks":
                    self.stills.take(pictures)
                if name == "Reel":
                    self._reel_stills.begin(self._ui.files.reel, pictures)
                self._draw_one(name, draw)

    def _is_shown(self, name: str) -> bool:
        if name == "Timeline":
            return self._ui.is_timeline_shown
        has_any = {"Scene": self._facts.has_camera, "Reel": self._ui.files.reel.reel is not None}
        return self._ui.panels[name] and has_any.get(name, True)

    def _draw_one(self, name: str, draw: Callable[[], None]) -> None:
        """Draw the window of a panel, and what is in it unless it is covered or has no picture."""
        shown, is_open = imgui.begin(name, True, _FLAGS.get(name, 0))
        self._ui.panels[name] = bool(is_open)
        if shown and self._ui.files.start_choices.has_nothing and name in _NEED_A_PICTURE:
            imgui.text_disabled("Waits for a picture.")
        elif shown:
            draw()
        imgui.end()

    def _lens(self) -> None:
        facts, say, lens = self._facts, self._say, self._session.lens
        if facts.is_waiting:
            return
        begun, plate, kits = lens.commands.start_lens, facts.plate, lens.commands.kits
        shown = LensFacts(
            *(facts.histogram, facts.unit, {} if begun is None else begun.sources),
            *(self._editing.tried, self._doubts()),
            brings_coc=plate is not None and not plate.has_distances,
            kit_lens=kits.mounted,
        )
        ring_panel(lens.ring, facts.unit, say)
        with listening() as drawn:
            self._editing.edit_lens(lens_panel(facts.lens, shown, say))
        size_row(self._session.scenes.size)
        kit_panel(facts.shot.kit, facts.lens, kits)
        ask_image = partial(self._ui.dialogs.ask, "opening")
        self._editing.edit_lens(opening_panel(facts.lens, say, ask_image))
        with listening() as folded:
            self._editing.edit_lens(film_back_panel(facts.lens, say))
        defocus = blur_panel(facts.shot.defocus, facts.has_many_views)
        self._editing.edit(replace(facts.shot, defocus=defocus))
        if facts.histogram is not None and self._time.timeline.has_time:
            lens_dots(self._time, drawn | folded)

    def _doubts(self) -> tuple[Doubt, ...]:
        """Return implausible values of lens and plate; a scene has none, for it gives its units."""
        facts, plate = self._facts, self._facts.plate
        if plate is None or facts.has_camera or not plate.has_distances:
            return ()
        return doubts(facts.lens, depth_span(plate, facts.shot.plate_options.scene_unit_m))

    def _display(self) -> None:
        facts, pictures = self._facts, self._session.pictures
        name = None if facts.reference is None else facts.reference.path.name
        pictures.view.state = display_panel(
            facts.view, pictures.color, name, facts.has_many_views, self._say, facts.shot.grade
        )

    def _plate(self) -> None:
        facts, plate, stream = self._facts, self._facts.plate, self._facts.stream
        if stream is not None and (stream.refusal or stream.arriving):
            imgui.text_wrapped(window_words(stream.words))
        if plate is None:
            return
        hovered_m = None
        if self._hovered is not None:
            hovered_m = seen_depth_m(plate, facts.plate_px(facts.frame_px(self._hovered)))
        reading = self._ui.files.commands.reading
        shown = PlateFacts(
            *(plate, facts.histogram, hovered_m, facts.unit, window_words(reading.problem)),
            *(facts.lens, self._doubts(), reading.read),
        )
        ask = partial(self._ui.dialogs.ask, "behind")
        pick = partial(self._time.marks.pick_thing, reading.take_thing)
        reading.change(plate_panel(reading.options, shown, self._say, ask, pick))

    def _export(self) -> None:
        exports = self._ui.files.exports
        if exports.why_not:
            imgui.text_wrapped(exports.why_not)
        else:
            draw_exports(exports, self._time.pull.cluster)

    def _speed(self) -> None:
        pictures, upload_s = self._session.pictures, self._session.source.picture.upload_s
        speed_panel(self._time.speed, upload_s, pictures.live.shown, pictures.renderer)

    def _plan(self) -> None:
        facts, plate, marks = self._facts, self._facts.plate, self._time.marks
        if plate is None:
            return
        if not plate.has_distances:
            imgui.text_wrapped("A plan needs distances, and this plate has none.")
            return
        known = [(m, at) for m in facts.shot.marks if (at := marks.distances.of_m(m)) is not None]
        plan = self._planned.plan(plate, facts.lens, known, facts.picture_shape.width_px)
        moves = self._plan_panel.draw(plan, facts.lens, facts.unit)
        if moves.focus_m is not None:
            self._session.lens.commands.focus(moves.focus_m)
        elif moves.mark:
            marks.put(moves.mark, moves.mark_m)

    def _guides(self) -> None:
        view, squeeze = self._session.pictures.view, self._facts.lens.squeeze
        view.state = guides_panel(view.state, squeeze, self._say)


_ZOOMS = "the picture zooms"
_FRAMING_TIP = (
    "What a change of the focal length keeps. With the size of a mark, the camera of a scene moves "
    "along its axis until what is there is as large as before: focus, keys and marks follow. "
    "Ctrl and the wheel move the camera, and the focal length follows."
)


def size_row(size: SizeKeeping) -> None:
    """Draw the choice of the mark whose thing keeps its size while the focal length changes."""
    words: dict[str | None, str] = {None: _ZOOMS} | {it: f"same size of {it}" for it in size.names}
    chosen = widgets.pick("framing", size.chosen, words, _FRAMING_TIP)
    if chosen != size.chosen:
        size.chosen = chosen
