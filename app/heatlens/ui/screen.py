"""One frame of the interface: menus, panels, the picture and the status bar, in that order."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.model.coc import sharp_px
from heatlens.model.view import Compare, Overlay
from heatlens.ui import theme, widgets
from heatlens.ui.action_list import nudge_focus
from heatlens.ui.actions import pressed
from heatlens.ui.app import App
from heatlens.ui.files.shot_question import shot_question
from heatlens.ui.keys_window import keys_window
from heatlens.ui.layout import PICTURE, dock_panels, menu_bar
from heatlens.ui.panels.lens_panel import LensFacts, blur_panel, lens_panel
from heatlens.ui.panels.look_panel import look_panel
from heatlens.ui.panels.marks_panel import draw_point_marks, marks_panel, pull_popup
from heatlens.ui.panels.plate_panel import PlateFacts, plate_panel
from heatlens.ui.panels.scene_panel import scene_panel
from heatlens.ui.panels.speed_panel import speed_panel
from heatlens.ui.picture.legend import draw_legend, entries
from heatlens.ui.picture.probe import PictureReader, probe_at, probe_text, seen_depth_m
from heatlens.ui.picture.screen_pictures import layer_limits_px, picture_of_b
from heatlens.ui.picture.stream_source import NO_FILES
from heatlens.ui.picture.viewport import MIPMAPS_UNDER, Pictures, ViewportResult
from heatlens.ui.side_words import draw_sides, mouse_words
from heatlens.ui.start_screen import StartScreen, hears_keys
from heatlens.ui.timeline.dope_sheet import lens_dots
from heatlens.ui.timeline.timeline_panel import timeline_panel
from heatlens.ui.widgets import window_words

_Window = imgui.WindowFlags_
_OF_A_PICTURE = ("Lens", "Plate", "Scene", "Export", "Marks")  # panels that tell nothing without


class Screen:
    """Draws an App with ImGui; holds nothing that matters."""

    def __init__(self, app: App) -> None:
        self._app = app
        self._reader = PictureReader(app.ctx)
        self._start = StartScreen(app.ctx)
        self._hears = True  # keys are meant for what lies beneath dialogs, fields and menus
        self._hovered: tuple[int, int] | None = None

    def draw(self) -> None:
        """Between ImGui's new_frame and its render."""
        app = self._app
        app.poll()
        self._do_actions()
        is_new_layout = app.wants_layout
        self._frame_window()
        if app.panels["Lens"]:
            self._lens()
        if app.panels["Look"]:
            self._look()
        if app.panels["Plate"]:
            self._plate()
        if app.panels["Scene"] and app.scenes.scene is not None:
            self._scene()
        if app.panels["Marks"]:
            self._marks()
        if app.panels["Export"]:
            self._export()
        if app.panels["Speed"]:
            self._speed()
        if app.timeline.is_shown:
            self._timeline()
        if is_new_layout:
            for name in ("Lens", "Look"):  # in front of those that share a place with them
                imgui.set_window_focus(name)
        app.update_picture()
        self._picture()
        app.editing.rest(is_held=imgui.is_any_item_active())
        app.color.apply(app.view, app.screen)

    def _do_actions(self) -> None:
        app = self._app
        self._hears = hears_keys()  # before a popup takes its Enter and is gone
        chosen = menu_bar(app, app.actions)
        is_asked = app.filing.browser.is_open or app.documents.offer is not None
        keyed = () if is_asked else (a for a in pressed(app.actions) if not app.first.sleeps(a))
        for action in (*keyed, chosen, app.palette.draw(app)):
            if action is not None:
                action.do(app)
        if app.shows_keys:
            app.shows_keys = keys_window(app.actions, app.has_scene)
        pull_popup(app)
        shot_question(app)
        app.filing.draw()

    def _frame_window(self) -> None:
        """The window that everything docks in, and the status bar under it."""
        app, screen = self._app, imgui.get_main_viewport()
        imgui.set_next_window_pos(screen.work_pos)
        imgui.set_next_window_size(screen.work_size)
        bare = (
            _Window.no_decoration | _Window.no_move | _Window.no_docking | _Window.no_saved_settings
        )
        bare |= _Window.no_bring_to_front_on_focus | _Window.no_nav_focus | _Window.no_background
        imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0, 0))
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        imgui.begin("heatlens", None, bare)
        imgui.pop_style_var()
        status_height = imgui.get_frame_height()
        size = ImVec2(screen.work_size.x, max(screen.work_size.y - status_height, 50.0))
        dock_panels(app.wants_layout, size)
        app.wants_layout = False
        self._status()
        imgui.end()
        imgui.pop_style_var()

    def _status(self) -> None:
        app = self._app
        imgui.set_cursor_pos_x(0.6 * imgui.get_font_size())
        imgui.align_text_to_frame_padding()
        if app.message:
            imgui.text_colored(theme.ACCENT_TEXT, app.message)
        elif app.stage.opener.opening:
            imgui.text_disabled(f"Reading {app.stage.opener.opening} ...")
        elif app.stage.is_waiting and app.stage.stream is not None:
            imgui.text_disabled(window_words(app.stage.stream.words))
        else:
            imgui.text_disabled(self._probe_text())
        draw_sides(app.view, app.sides, None if app.reference is None else app.reference.path.name)

    def _probe_text(self) -> str:
        app, plate, shown = self._app, self._app.stage.plate, self._app.live.shown
        if plate is None or shown is None or self._hovered is None:
            asked = "Arrows and Enter, a digit or a click" if app.first.is_wanted else ""
            return f"{asked or mouse_words(app.has_scene)}.  ? shows the keys."
        pixel = app.stage.plate_px(app.shot, self._hovered)
        probe = probe_at(pixel, plate, app.lens, shown, app.live.version, self._reader)
        return "" if probe is None else probe_text(probe, app.view.unit)

    def _lens(self) -> None:
        app = self._app
        if self._begin("Lens", _Window.no_scroll_with_mouse) and not app.stage.is_waiting:
            sources = {} if app.begun is None else app.begun.sources
            facts = LensFacts(app.histogram, app.view.unit, sources)
            app.edit_lens(lens_panel(app.lens, facts, app.say))
            app.edit(replace(app.shot, defocus=blur_panel(app.shot.defocus, app.has_scene)))
            if app.histogram is not None and app.timeline.has_time:
                lens_dots(app)
            wheel = imgui.get_io().mouse_wheel
            if wheel and imgui.is_window_hovered(imgui.HoveredFlags_.child_windows):
                nudge_focus(app, wheel)
        imgui.end()

    def _look(self) -> None:
        app = self._app
        if self._begin("Look"):
            name = None if app.reference is None else app.reference.path.name
            app.view = look_panel(app.view, app.color, name, app.has_scene)
        imgui.end()

    def _plate(self) -> None:
        app, plate = self._app, self._app.stage.plate
        is_open, stream = self._begin("Plate"), app.stage.stream
        if is_open and stream is not None and (stream.problem or stream.losses):
            imgui.text_wrapped(window_words(stream.words))
        if is_open and plate is not None:
            hovered_m = None
            if self._hovered is not None:
                hovered_m = seen_depth_m(plate, app.stage.plate_px(app.shot, self._hovered))
            reading, unit = app.filing.reading, app.view.unit
            problem = window_words(reading.problem)
            facts = PlateFacts(plate, app.histogram, hovered_m, unit, problem, app.lens)
            reading.change(plate_panel(reading.wished, facts, app.say))
        imgui.end()

    def _scene(self) -> None:
        if self._begin("Scene", _Window.no_focus_on_appearing):
            scene_panel(self._app)
        imgui.end()

    def _export(self) -> None:
        exporter = self._app.filing.exporter
        if self._begin("Export"):
            if self._app.stage.is_streaming and not exporter.run.is_busy:
                imgui.text_wrapped(NO_FILES)
            else:
                exporter.draw()
        imgui.end()

    def _speed(self) -> None:
        app = self._app
        if self._begin("Speed"):
            app.speed.upload_s = app.stage.upload_s
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

    def _picture(self) -> None:
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(0, 0))
        still = _Window.no_scrollbar | _Window.no_scroll_with_mouse | _Window.no_background
        imgui.begin(PICTURE, None, still)
        imgui.pop_style_var()
        pictures = self._pictures()
        if self._app.first.is_wanted:
            self._hovered = None
            self._start.choose(self._app, self._hears)
        elif self._app.stage.is_black:
            imgui.text_disabled(f"  Frame {self._app.editing.frame} has no file.")
        elif self._app.stage.is_waiting:
            imgui.text_disabled("  Waiting for a renderer. Ctrl+O opens a file instead.")
        elif pictures is None:
            is_coming = self._app.stage.plate is not None or self._app.stage.opener.opening
            words = "Opening ..." if is_coming else "Nothing is open: Ctrl+O, or drop a file here."
            imgui.text_disabled(f"  {words}")
        else:
            scale = imgui.get_io().display_framebuffer_scale.x or 1.0
            self._take(self._app.viewport.draw(pictures, self._app.view, scale))
            draw_point_marks(self._app)
            self._legend()
        widgets.note("picture")
        imgui.end()

    def _legend(self) -> None:
        app = self._app
        if app.view.overlay is Overlay.NONE or app.view.compare is Compare.FLIP:
            return
        if not app.editing.has_lens:
            return
        plate = app.renderer.loaded.plate
        optics = app.renderer.optics(app.shot, app.editing.frame)
        sharp = sharp_px(app.lens, plate.display_window.width)
        limits = layer_limits_px(optics, app.shot)
        legend = entries(app.view.overlay, optics, sharp, limits, plate.depth, app.view.unit)
        draw_legend(legend, app.viewport.viewport)

    def _take(self, result: ViewportResult) -> None:
        self._app.view, self._hovered = result.view, result.hovered_px
        if result.camera is not None:
            self._app.scenes.move(result.camera)
        if result.focus_px is None:
            return
        io = imgui.get_io()
        if not (io.key_ctrl and io.key_shift):
            self._app.focus_at(result.focus_px)
        elif imgui.is_mouse_clicked(imgui.MouseButton_.left):
            self._app.timeline.marks.set_point(result.focus_px)

    def _pictures(self) -> Pictures | None:
        """What the viewport shows, drawn again where it changed."""
        app, shown, plate = self._app, self._app.live.shown, self._app.stage.plate
        if plate is None or shown is None:
            return None
        screen, loaded = app.screen, app.renderer.loaded
        view = replace(app.view, depth_of_field=app.view.depth_of_field and not self._alt())
        view = replace(view, exposure_stops=view.exposure_stops + app.lens.transmission_stops)
        screen.with_mipmaps = app.viewport.zoom < MIPMAPS_UNDER
        reference = app.reference.texture if app.reference else None
        of_method = app.sides.of_method(view)
        linear_b = picture_of_b(view, loaded, reference, of_method)
        a = screen.a(shown, app.sides.version, loaded, view, linear_b)
        b = a
        if view.compare in (Compare.WIPE, Compare.FLIP):
            b = screen.b(linear_b, loaded, view, app.sides.version if of_method else 0)
        sharp = None
        if view.depth_of_field and view.compare is not Compare.DIFFERENCE:
            sharp = screen.sharp(shown, loaded, view)
        overlay = None
        if view.overlay is not Overlay.NONE and app.editing.has_lens:
            overlay = screen.overlay(loaded, app.shot, app.editing.frame, view.overlay)
        windows = app.stage.windows(app.shot)
        return Pictures(
            a,
            b,
            sharp,
            overlay,
            *windows,
            plate.pixel_aspect_ratio,
            is_proxy=a.size != (windows[0].width, windows[0].height),
            is_b_proxy=of_method is not None and b.size != loaded.color.size,
            has_camera=app.scenes.scene is not None,
        )

    def _alt(self) -> bool:
        io = imgui.get_io()
        return bool(io.key_alt) and not io.want_text_input
