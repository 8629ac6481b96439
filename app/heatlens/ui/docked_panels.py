"""The panels in their places: each is handed what it shows, and what it returns is taken."""

from dataclasses import replace

from imgui_bundle import imgui

from heatlens.display.probe import seen_depth_m
from heatlens.model.plausibility import Doubt, doubts
from heatlens.plate.plate import depth_span
from heatlens.source.kind import NO_FILES
from heatlens.ui.action_list import nudge_focus
from heatlens.ui.app import App
from heatlens.ui.panels.lens_panel import LensFacts, blur_panel, lens_panel
from heatlens.ui.panels.look_panel import look_panel
from heatlens.ui.panels.marks_panel import marks_panel
from heatlens.ui.panels.plate_panel import PlateFacts, plate_panel
from heatlens.ui.panels.scene_panel import scene_panel
from heatlens.ui.panels.speed_panel import speed_panel
from heatlens.ui.timeline.dope_sheet import lens_dots
from heatlens.ui.timeline.panel import timeline_panel
from heatlens.ui.widgets import window_words

_Window = imgui.WindowFlags_
_OF_A_PICTURE = ("Lens", "Plate", "Scene", "Export", "Marks")  # panels that tell nothing without


class DockedPanels:
    """Draws those that are open."""

    def __init__(self, app: App) -> None:
        self._app = app

    def draw(self, hovered: tuple[int, int] | None) -> None:
        """`hovered`: pixel of the display window under the pointer."""
        app = self._app
        if app.panels["Lens"]:
            self._lens()
        if app.panels["Look"]:
            self._look()
        if app.panels["Plate"]:
            self._plate(hovered)
        if app.panels["Scene"] and app.has_scene:
            self._scene()
        if app.panels["Marks"]:
            self._marks()
        if app.panels["Export"]:
            self._export()
        if app.panels["Speed"]:
            self._speed()
        if app.timeline.is_shown:
            self._timeline()

    def _lens(self) -> None:
        app = self._app
        if self._begin("Lens", _Window.no_scroll_with_mouse) and not app.source.is_waiting:
            sources = {} if app.begun is None else app.begun.sources
            facts = LensFacts(app.histogram, app.view.unit, sources, self._doubts())
            app.edit_lens(lens_panel(app.lens, facts, app.say))
            app.edit(replace(app.shot, defocus=blur_panel(app.shot.defocus, app.has_scene)))
            if app.histogram is not None and app.timeline.has_time:
                lens_dots(app)
            wheel = imgui.get_io().mouse_wheel
            if wheel and imgui.is_window_hovered(imgui.HoveredFlags_.child_windows):
                nudge_focus(app, wheel)
        imgui.end()

    def _doubts(self) -> tuple[Doubt, ...]:
        """Of the lens in front of a plate; the lengths of a scene are told by its file."""
        app, plate = self._app, self._app.source.plate
        if plate is None or app.has_scene or not plate.has_distances:
            return ()
        return doubts(app.lens, depth_span(plate, app.shot.plate_options.scene_unit_m))

    def _look(self) -> None:
        app = self._app
        if self._begin("Look"):
            name = None if app.reference is None else app.reference.path.name
            app.view = look_panel(app.view, app.color, name, app.has_scene)
        imgui.end()

    def _plate(self, hovered: tuple[int, int] | None) -> None:
        app, plate = self._app, self._app.source.plate
        is_open, stream = self._begin("Plate"), app.source.stream
        if is_open and stream is not None and (stream.problem or stream.losses):
            imgui.text_wrapped(window_words(stream.words))
        if is_open and plate is not None:
            hovered_m = None
            if hovered is not None:
                hovered_m = seen_depth_m(plate, app.source.plate_px(app.shot, hovered))
            reading, unit = app.filing.reading, app.view.unit
            problem = window_words(reading.problem)
            facts = PlateFacts(
                plate, app.histogram, hovered_m, unit, problem, app.lens, self._doubts()
            )
            reading.change(plate_panel(reading.wished, facts, app.say))
        imgui.end()

    def _scene(self) -> None:
        if self._begin("Scene", _Window.no_focus_on_appearing):
            scene_panel(self._app)
        imgui.end()

    def _export(self) -> None:
        exporter = self._app.filing.exporter
        if self._begin("Export"):
            if not self._app.source.is_repeatable and not exporter.run.is_busy:
                imgui.text_wrapped(NO_FILES)
            else:
                exporter.draw()
        imgui.end()

    def _speed(self) -> None:
        app = self._app
        if self._begin("Speed"):
            app.speed.upload_s = app.source.picture.upload_s
            speed_panel(app.speed, app.live.shown, app.renderer)
        imgui.end()

    def _marks(self) -> None:
        if self._begin("Marks"):
            marks_panel(self._app)
        imgui.end()

    def _timeline(self) -> None:
        if self._begin("Timeline", _Window.no_scrollbar | _Window.no_scroll_with_mouse):
            timeline_panel(self._app)
        imgui.end()

    def _begin(self, name: str, flags: int = 0) -> bool:
        shown, is_open = imgui.begin(name, True, flags)
        self._app.panels[name] = bool(is_open)
        if shown and self._app.first.has_nothing and name in _OF_A_PICTURE:
            imgui.text_disabled("Waits for a picture.")
            return False
        return shown
