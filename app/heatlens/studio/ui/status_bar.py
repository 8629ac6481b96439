"""Draw the status bar: values under the pointer, the last message, and the names of A and B."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.render.display.pixel_reading import PictureReader, reading_at, reading_text
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.rendered_frames.screen_work import CachedFrame, ScreenWork
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import PictureControl
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.state import UiState
from heatlens.studio.ui.texts import fit_text, named_keys, text_width
from heatlens.studio.ui.work_bar import work_bar, work_bar_width

_EDGE_EM = 0.6
_MAX_MESSAGE_SHARE = 0.65  # largest share of the width that a message takes from the readout


class StatusBar:
    """Draws the status bar."""

    def __init__(
        self,
        board: Board,
        control: PictureControl,
        ui: UiState,
        cached_screen: ScreenWork,
    ) -> None:
        self._board, self._control = board, control
        self._ui, self._cached_screen = ui, cached_screen
        self._reader = PictureReader(control.renderer.ctx)

    def draw(self, hovered_px: tuple[int, int] | None) -> None:
        """Draw the bar; `hovered_px` is the pixel of the display window under the pointer.

        The readout is at the left with the message beside it; at the right are the work that goes
        on behind the window, and the sides.
        """
        facts, control, em = self._board.facts, self._control, imgui.get_font_size()
        reference = None if facts.reference is None else facts.reference.path.name
        sides = sides_words(facts.view, control, reference, facts.shown_picture)
        if sides and control.view.is_drawn:
            sides = f"{sides}    {zoom_words(control.view.zoom)}"
        right_x = imgui.get_window_width() - _EDGE_EM * em
        work_width = work_bar_width(self._ui)
        left_end = right_x - work_width - (imgui.calc_text_size(sides).x + em if sides else 0.0)
        _draw_background()
        imgui.set_cursor_pos_x(_EDGE_EM * em)
        imgui.align_text_to_frame_padding()
        self._draw_left(hovered_px, left_end)
        if work_width:
            imgui.same_line(max(left_end, em))
            work_bar(self._ui)
        if sides:
            imgui.same_line(right_x - imgui.calc_text_size(sides).x)
            imgui.text_disabled(printable(sides))
            rects.note("sides")

    # The texts are cut where the export and the message begin, so that what is at the right end of
    # the bar stays in it.
    def _draw_left(self, hovered_px: tuple[int, int] | None, end: float) -> None:
        """Draw the readout or a hint, and the message beside it; `end` is the right limit."""
        message = named_keys(self._message)
        left_words = named_keys(self._left_words(hovered_px))
        em = imgui.get_font_size()
        free_width = end - imgui.get_cursor_pos_x() - em
        gap = 1.5 * em if left_words and message else 0.0
        message_width = (
            min(text_width(message), _MAX_MESSAGE_SHARE * free_width) if left_words else free_width
        )
        if left_words:
            _draw_fitted(left_words, free_width - (message_width + gap if message else 0.0))
            rects.note("readout")
        if message:
            if left_words:
                imgui.same_line(0.0, gap)
            self._draw_message(message, end - imgui.get_cursor_pos_x() - em)

    def _left_words(self, hovered_px: tuple[int, int] | None) -> str:
        """Return the file being read, else the readout or a hint; "" if a message replaces it."""
        facts = self._board.facts
        if facts.opening:
            return f"Reading {printable(facts.opening)} ..."
        if facts.is_waiting and facts.stream is not None:
            return f"Listening on {facts.stream.address} ..."
        return "" if hovered_px is None and self._message else self.words(hovered_px)

    @property
    def _message(self) -> str:
        """The latest message; "" for a problem, which is told over the picture."""
        facts = self._board.facts
        return "" if facts.is_problem else facts.message

    def _draw_message(self, message: str, width: float) -> None:
        """Draw the message, cut to `width`; a tooltip shows all of it."""
        fitted_text = fit_text(message, width)
        imgui.text_colored(theme.colors.message, fitted_text)
        rects.note("message")
        if fitted_text != message and imgui.is_item_hovered():
            imgui.set_tooltip(message)

    def words(self, hovered_px: tuple[int, int] | None) -> str:
        """Return the values under the pointer, or a hint if the pointer is not over the picture."""
        return self._values_at(hovered_px) or self._hint()

    def _hint(self) -> str:
        """Return a hint about the mouse, the start screen or the first quick picture."""
        facts, is_start = self._board.facts, self._ui.files.start_choices.is_shown
        is_preview = facts.shown_picture is not None and facts.is_rendering and not is_start
        hint = "Arrows and Enter, a digit or a click" if is_start else mouse_words(facts.has_camera)
        if progress := self._control.builder.progress:
            return f"Preparing the graphics driver, {progress}: pictures are coarse until then"
        return self._ui.preview_hint(is_preview) or f"{hint}.  F1 shows the keys."

    def _values_at(self, hovered_px: tuple[int, int] | None) -> str:
        """Return the values under the pointer; "" beside the picture, as on its margin."""
        facts = self._board.facts
        plate, picture = facts.plate, facts.shown_picture
        if plate is None or picture is None or hovered_px is None or facts.plays_cached_frames:
            return ""
        if facts.view.compare is Compare.GRID:
            return "Click a picture to take its look.  Escape leaves the grid."
        self._cached_screen.upload(picture)
        pixel = facts.plate_px(hovered_px)
        version = picture.key if isinstance(picture, CachedFrame) else picture
        frame_px = facts.frame_px(pixel)
        values = reading_at(pixel, plate, facts.lens, picture, version, self._reader, frame_px)
        if values is None:
            return ""
        if facts.has_camera:  # a scene's preview may be smaller
            coc_px = values.coc_px * facts.windows()[1].width / plate.display_window.width
            values = replace(values, display_px=hovered_px, data_px=hovered_px, coc_px=coc_px)
        channel = printable(self._control.channel.words_at(values.data_px))
        return channel + reading_text(values, facts.unit, facts.lens)


def _draw_fitted(words: str, width: float) -> None:
    """Draw gray text, cut to `width`; a tooltip shows all of it."""
    fitted_words = fit_text(words, width)
    imgui.text_disabled(fitted_words)
    if fitted_words != words and imgui.is_item_hovered():
        imgui.set_tooltip(words)


def _draw_background() -> None:
    """Fill the background of the bar, since the window around it has none."""
    corner, width = imgui.get_cursor_screen_pos(), imgui.get_window_width()
    end = ImVec2(corner.x + width, corner.y + imgui.get_frame_height())
    imgui.get_window_draw_list().add_rect_filled(corner, end, theme.colors.status_ground)


def zoom_words(zoom: float) -> str:
    """Return the zoom as text: "50 %", "1600 %"."""
    return f"{100 * zoom:.0f} %" if zoom >= 0.1 else f"{100 * zoom:.1f} %"


def mouse_words(has_camera: bool) -> str:
    """Return what the mouse does in the picture; `has_camera` adds the gestures of a scene."""
    if not has_camera:
        return "Click in the picture to focus"
    return "Click to focus.  Right drag orbits, Ctrl+right drag moves sideways, Ctrl+wheel dollies"


def sides_words(
    view: ViewState, control: PictureControl, reference: str | None, picture_a: ShownPicture | None
) -> str:
    """Return for example "A: diffusion    B: gather"; only A if B is not shown.

    `reference` is the file name of the reference picture, `picture_a` the picture of side A.
    """
    if picture_a is None:
        return ""
    a = side_words(picture_a) if view.depth_of_field else "pinhole"
    if view.compare is Compare.OFF:
        return a
    if view.compare is Compare.GRID:
        return "looks side by side"
    if view.a_look and control.sides.picture_of_a(view) is not None:
        a = _look_words(view.a_look, control)
    return f"A: {a}    B: {_b_words(view, control, reference)}"


def _look_words(name: str, control: PictureControl) -> str:
    """Return the name of a look, marked as a preview until its whole picture is rendered."""
    return f"look {name}, preview" if control.sides.is_unfinished(name) else f"look {name}"


def side_words(picture: ShownPicture) -> str:
    """Return the method and progress of a picture, for example "raytraced, 16 of 256 views"."""
    rendered, requested = picture.settings, picture.shot.defocus
    if requested.method.needs_scene and rendered.views < requested.views:
        return f"{requested.method}, {rendered.views} of {requested.views} views"
    return str(requested.method) if picture.is_whole else f"{requested.method}, preview"


def _b_words(view: ViewState, control: PictureControl, reference: str | None) -> str:
    """Return what side B shows: a look, another method, the reference, or the pinhole picture."""
    picture_b = control.sides.picture_of_b(view)
    if view.against is Against.LOOK and picture_b is not None:
        return _look_words(view.b_look, control)
    if view.against is Against.SHOT and picture_b is not None:
        return printable(control.other_shot.name)
    if view.against is Against.CHANNEL:
        return printable(view.channel)
    if picture_b is not None:
        return side_words(picture_b)
    if view.against is Against.REFERENCE and reference is not None:
        return reference
    return "pinhole"
