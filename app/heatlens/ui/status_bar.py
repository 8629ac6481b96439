"""The line under everything: what was said, what is under the pointer, what A and B are."""

from dataclasses import replace

from imgui_bundle import imgui

from heatlens.display.probe import PictureReader, probe_at, probe_text
from heatlens.ui import theme
from heatlens.ui.app import App
from heatlens.ui.side_words import draw_sides, mouse_words
from heatlens.ui.timeline.kept_screen import KeptFrame
from heatlens.ui.widgets import window_words


class StatusBar:
    """Draws it."""

    def __init__(self, app: App) -> None:
        self._app = app
        self._reader = PictureReader(app.ctx)

    def draw(self, hovered: tuple[int, int] | None) -> None:
        """`hovered`: pixel of the display window under the pointer."""
        app = self._app
        imgui.set_cursor_pos_x(0.6 * imgui.get_font_size())
        imgui.align_text_to_frame_padding()
        if app.message:
            imgui.text_colored(theme.ACCENT_TEXT, app.message)
        elif app.source.opener.opening:
            imgui.text_disabled(f"Reading {app.source.opener.opening} ...")
        elif app.source.is_waiting and app.source.stream is not None:
            imgui.text_disabled(window_words(app.source.stream.words))
        else:
            imgui.text_disabled(self.words(hovered))
        reference = None if app.reference is None else app.reference.path.name
        draw_sides(app.view, app.sides, reference, app.turns.seen)

    def words(self, hovered: tuple[int, int] | None) -> str:
        """What is under the pointer; beside the picture, what can be done."""
        app, plate, shown = self._app, self._app.source.plate, self._app.turns.seen
        is_past = app.pull.is_alone  # what plays is not of the plate that is there
        if plate is None or shown is None or hovered is None or is_past:
            asked = "Arrows and Enter, a digit or a click" if app.first.is_wanted else ""
            return f"{asked or mouse_words(app.has_scene)}.  ? shows the keys."
        app.pull.screen.uploaded(shown)
        pixel = app.source.plate_px(app.shot, hovered)
        version = shown.key if isinstance(shown, KeptFrame) else app.live.version
        probe = probe_at(pixel, plate, app.lens, shown, version, self._reader)
        if probe is None:
            return ""
        if app.has_scene:  # which may be drawn smaller than it is
            _, whole = app.source.windows(app.shot)
            coc_px = probe.coc_px * whole.width / plate.display_window.width
            probe = replace(probe, display_px=hovered, data_px=hovered, coc_px=coc_px)
        return probe_text(probe, app.view.unit)
