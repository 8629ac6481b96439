"""Draw the open panels: give each one its values and apply the values that it returns."""

from dataclasses import replace
from functools import partial

from imgui_bundle import imgui

from heatlens.display.probe import seen_depth_m
from heatlens.model.plausibility import Doubt, doubts
from heatlens.plate.plate import depth_span
from heatlens.session.loop.messages import window_words
from heatlens.session.marks.plan import PlanDrawer
from heatlens.session.session import Session
from heatlens.ui.panels.display_panel import display_panel
from heatlens.ui.panels.export_panel import draw_exports
from heatlens.ui.panels.guides_panel import guides_panel
from heatlens.ui.panels.kit_panel import kit_panel
from heatlens.ui.panels.lens_panel import LensFacts, blur_panel, film_back_panel, lens_panel
from heatlens.ui.panels.looks_panel import LookStills, looks_panel
from heatlens.ui.panels.marks_panel import marks_panel
from heatlens.ui.panels.opening_panel import opening_panel
from heatlens.ui.panels.plan_panel import PlanPanel
from heatlens.ui.panels.plate_panel import PlateFacts, plate_panel
from heatlens.ui.panels.ring_map_panel import ring_map_panel
from heatlens.ui.panels.ring_panel import RingFacts, RingState, ring_panel
from heatlens.ui.panels.scene_panel import scene_panel
from heatlens.ui.panels.speed_panel import speed_panel
from heatlens.ui.picture.pictures import Pictures
from heatlens.ui.probe import listening
from heatlens.ui.state import UiState
from heatlens.ui.timeline.dope_sheet import lens_dots
from heatlens.ui.timeline.panel import timeline_panel

_Window = imgui.WindowFlags_
_NEED_A_PICTURE = (
    "Lens",
    "Plate",
    "Scene",
    "Export",
    "Marks",
    "Plan",
    "Looks",
)  # panels that are empty until a picture is open


class DockedPanels:
    """Draws the panels that are open."""

    def __init__(self, session: Session, ui: UiState) -> None:
        self._session = session
        self._ui = ui
        self._planned, self._plan_panel = PlanDrawer(), PlanPanel()
        self.stills = LookStills(session.facts, session.pictures)

    def draw(self, hovered: tuple[int, int] | None, pictures: Pictures | None) -> None:
        """Draw the panels; `hovered` is the pixel of the display window under the pointer.

        `pictures` are those in the viewport; the stills of looks are taken from them.
        """
        session, panels = self._session, self._ui.panels
        if panels["Lens"]:
            self._lens()
        if panels["Display"]:
            self._display()
        if panels["Plate"]:
            self._plate(hovered)
        if panels["Scene"] and session.facts.has_camera:
            self._scene()
        if panels["Marks"]:
            self._marks()
        if panels["Plan"]:
            self._plan()
        if panels["Looks"]:
            self._looks(pictures)
        if panels["Guides"]:
            self._guides()
        if panels["Export"]:
            self._export()
        if panels["Speed"]:
            self._speed()
        if self._ui.is_timeline_shown:
            self._timeline()

    def _lens(self) -> None:
        session = self._session
        if self._begin("Lens") and not session.source.is_waiting:
            begun = session.lens.commands.start_lens
            sources = {} if begun is None else begun.sources
            tried, doubtful = session.editing.tried, self._doubts()
            kits = session.lens.commands.kits
            plate = session.source.picture.plate
            facts = LensFacts(
                session.facts.histogram,
                session.facts.view.unit,
                sources,
                tried,
                doubtful,
                brings_coc=plate is not None and not plate.has_distances,
                kit_lens=kits.mounted,
            )
            self._ring()
            with listening() as drawn:
                session.editing.edit_lens(
                    lens_panel(session.facts.lens, facts, session.messages.say)
                )
            kit_panel(session.facts.shot.kit, session.facts.lens, kits)
            ask_image = partial(self._ui.dialogs.ask, "opening")
            session.editing.edit_lens(
                opening_panel(session.facts.lens, session.messages.say, ask_image)
            )
            with listening() as folded:
                session.editing.edit_lens(film_back_panel(session.facts.lens, session.messages.say))
            defocus = blur_panel(session.facts.shot.defocus, session.facts.has_many_views)
            session.editing.edit(replace(session.facts.shot, defocus=defocus))
            if session.facts.histogram is not None and session.time.timeline.has_time:
                lens_dots(session.time, drawn | folded)
        imgui.end()

    def _ring(self) -> None:
        ring = self._session.lens.ring
        if ring.receiver is None or ring.heard is None:
            return
        receiver = ring.receiver
        facts = RingFacts(
            *(str(receiver.address), ring.heard, receiver.refused, receiver.lost),
            *(ring.to_picture_s, receiver.fault),
        )
        chosen = ring_panel(RingState(ring.is_followed, ring.source), facts)
        ring_map_panel(ring, self._session.facts.view.unit, self._session.messages.say)
        ring.is_followed = chosen.is_followed
        if chosen.source != ring.source:
            ring.listen_to(chosen.source)

    def _doubts(self) -> tuple[Doubt, ...]:
        """Return implausible values of lens and plate; a scene has none, for it gives its units."""
        session, plate = self._session, self._session.source.plate
        if plate is None or session.facts.has_camera or not plate.has_distances:
            return ()
        return doubts(
            session.facts.lens, depth_span(plate, session.facts.shot.plate_options.scene_unit_m)
        )

    def _display(self) -> None:
        session = self._session
        if self._begin("Display"):
            name = None if session.facts.reference is None else session.facts.reference.path.name
            session.pictures.view.state = display_panel(
                session.facts.view,
                session.pictures.color,
                name,
                session.facts.has_many_views,
                session.messages.say,
            )
        imgui.end()

    def _plate(self, hovered: tuple[int, int] | None) -> None:
        session, plate = self._session, self._session.source.plate
        is_open, stream = self._begin("Plate"), session.source.stream
        if is_open and stream is not None and (stream.refusal or stream.arriving):
            imgui.text_wrapped(window_words(stream.words))
        if is_open and plate is not None:
            hovered_m = None
            if hovered is not None:
                frame_px = session.source.frame_px(session.facts.lens, hovered)
                plate_px = session.source.feed.plate_px(session.facts.shot, frame_px)
                hovered_m = seen_depth_m(plate, plate_px)
            reading, unit = session.files.commands.reading, session.facts.view.unit
            problem = window_words(reading.problem)
            facts = PlateFacts(
                plate=plate,
                histogram=session.facts.histogram,
                hovered_m=hovered_m,
                unit=unit,
                problem=problem,
                lens=session.facts.lens,
                doubts=self._doubts(),
                read=reading.read,
            )
            ask = partial(self._ui.dialogs.ask, "behind")
            reading.change(plate_panel(reading.options, facts, session.messages.say, ask))
        imgui.end()

    def _scene(self) -> None:
        if self._begin("Scene", _Window.no_focus_on_appearing):
            session = self._session
            scene_panel(session.scenes, session.editing, session.messages.say)
        imgui.end()

    def _export(self) -> None:
        exports = self._session.files.exports
        if self._begin("Export"):
            if exports.why_not:
                imgui.text_wrapped(exports.why_not)
            else:
                draw_exports(exports)
        imgui.end()

    def _speed(self) -> None:
        session = self._session
        if self._begin("Speed"):
            session.time.speed.upload_s = session.source.picture.upload_s
            speed_panel(session.time.speed, session.pictures.live.shown, session.pictures.renderer)
        imgui.end()

    def _marks(self) -> None:
        if self._begin("Marks"):
            marks_panel(self._session.time, self._session.facts.unit, self._ui)
        imgui.end()

    def _plan(self) -> None:
        session, plate = self._session, self._session.source.plate
        is_open = self._begin("Plan")
        if is_open and plate is not None and not plate.has_distances:
            imgui.text_wrapped("A plan needs distances, and this plate has none.")
        elif is_open and plate is not None:
            facts, marks = session.facts, session.time.marks
            known = [(m, at) for m in facts.shot.marks if (at := marks.distance_m(m)) is not None]
            plan = self._planned.plan(plate, facts.lens, known, facts.picture_shape.width_px)
            moves = self._plan_panel.draw(plan, facts.lens, facts.unit)
            if moves.focus_m is not None:
                session.lens.commands.focus(moves.focus_m)
            elif moves.mark:
                marks.put(moves.mark, moves.mark_m)
        imgui.end()

    def _looks(self, pictures: Pictures | None) -> None:
        self.stills.take(pictures)
        if self._begin("Looks"):
            looks_panel(self._session.facts, self._session.pictures, self.stills)
        imgui.end()

    def _guides(self) -> None:
        if self._begin("Guides"):
            session = self._session
            session.pictures.view.state = guides_panel(
                session.facts.view, session.facts.lens.squeeze, session.messages.say
            )
        imgui.end()

    def _timeline(self) -> None:
        if self._begin("Timeline", _Window.no_scroll_with_mouse):
            timeline_panel(self._session.time, self._ui.timeline, self._session.facts.unit)
        imgui.end()

    def _begin(self, name: str, flags: int = 0) -> bool:
        shown, is_open = imgui.begin(name, True, flags)
        self._ui.panels[name] = bool(is_open)
        if shown and self._session.files.start_choices.has_nothing and name in _NEED_A_PICTURE:
            imgui.text_disabled("Waits for a picture.")
            return False
        return shown
