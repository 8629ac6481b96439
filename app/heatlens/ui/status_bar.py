"""The line under everything: what was said, what is under the pointer, what A and B are."""

from dataclasses import replace

from imgui_bundle import imgui

from heatlens.display.probe import PictureReader, probe_at, probe_text
from heatlens.printable import printable
from heatlens.session.kept_screen import KeptFrame, KeptScreen
from heatlens.session.session import Session
from heatlens.ui import theme
from heatlens.ui.side_words import draw_sides, mouse_words


class StatusBar:
    """Draws the status bar."""

    def __init__(self, session: Session, kept: KeptScreen) -> None:
        self._session = session
        self._kept = kept
        self._reader = PictureReader(session.renderer.ctx)

    def draw(self, hovered: tuple[int, int] | None) -> None:
        """Draw the bar; `hovered` is the pixel of the display window under the pointer."""
        session = self._session
        imgui.set_cursor_pos_x(0.6 * imgui.get_font_size())
        imgui.align_text_to_frame_padding()
        if session.message:
            imgui.text_colored(theme.ACCENT_TEXT, session.message)
        elif session.source.opener.opening:
            imgui.text_disabled(f"Reading {printable(session.source.opener.opening)} ...")
        elif session.source.is_waiting and session.source.stream is not None:
            imgui.text_disabled(f"Listening on {session.source.stream.address} ...")
        else:
            imgui.text_disabled(self.words(hovered))
        reference = None if session.reference is None else session.reference.path.name
        draw_sides(session.view, session.sides, reference, session.seen)

    def words(self, hovered: tuple[int, int] | None) -> str:
        """Return what is under the pointer; beside the picture, what can be done."""
        session, plate, shown = self._session, self._session.source.plate, self._session.seen
        is_past = session.pull.is_alone  # what plays is not of the plate that is there
        if plate is None or shown is None or hovered is None or is_past:
            asked = (
                "Arrows and Enter, a digit or a click" if session.start_choices.is_wanted else ""
            )
            return f"{asked or mouse_words(session.has_scene)}.  ? shows the keys."
        self._kept.uploaded(shown)
        pixel = session.source.plate_px(session.shot, hovered)
        version = shown.key if isinstance(shown, KeptFrame) else shown
        probe = probe_at(pixel, plate, session.lens, shown, version, self._reader)
        if probe is None:
            return ""
        if session.has_scene:  # which may be drawn smaller than it is
            _, whole = session.source.windows(session.shot)
            coc_px = probe.coc_px * whole.width / plate.display_window.width
            probe = replace(probe, display_px=hovered, data_px=hovered, coc_px=coc_px)
        return probe_text(probe, session.view.unit)
