"""Draw the focus bar under the picture: an engraved scale, the depths of the scene, the focus.

Equal widths are equal dioptres. Infinity is at the right and the nearest surface at the left, as
on most lens barrels. From top to bottom it has a line of figures, the groove with the depths, and
the scale.
"""

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import far_limit_m, hyperfocal_m, near_limit_m
from heatlens.core.model.lens.lens import Lens, measured_text
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.media.plate.coc_line import focused_at
from heatlens.studio.session.facts import Facts
from heatlens.studio.session.lens.lens_commands import nudged
from heatlens.studio.ui import probe, texts, theme, widgets
from heatlens.studio.ui.panels.depth_scale import TICK_EM, draw_histogram, draw_scale, engraved_m
from heatlens.studio.ui.probe import Rect

_HEIGHT_EM, _PART_MOST = 5.4, 0.25  # height, and its largest share of the room under the menus
_FIGURES_EM, _SCALE_EM, _EDGE_EM = 1.55, 1.45, 0.9  # heights of the lines, room at the ends
_MINOR_EM = 0.2  # length of the fine ticks
_REACH_EM = 0.4  # largest distance between the pointer and its target
_FOCUS_PART = 1.15  # size of the focus figure relative to the others
_GAP_EM = 0.45  # gap between figures
_NEEDLE_EM, _GHOST_EM, _LINE_EM = 0.17, 0.1, 0.067  # widths of lines


def focus_bar_height(room: float) -> float:
    """Return the height of the bar where the picture and the bar have a height of `room`."""
    return min(_HEIGHT_EM * float(imgui.get_font_size()), _PART_MOST * room)


# The bar is what the window is for. As a row of the Lens panel it weighed as much as the width of
# the sensor; now it is as wide as the picture. The distance at the pointer stands beside the
# figure, where a tooltip covered the scale.
def focus_bar(
    facts: Facts, histogram: DepthHistogram, corner: ImVec2, size: ImVec2
) -> tuple[Lens, str | None]:
    """Draw the bar in the current window; return the lens, focused by a drag or the wheel.

    A press on the name of a mark focuses exactly on it. Return also the name of the mark whose flag
    the pointer rests on.
    """
    imgui.set_cursor_screen_pos(corner)
    imgui.invisible_button("focus bar", size)
    notches, lens = widgets.wheel_over_last(), facts.lens
    bar, x = _Bar(facts, histogram, corner, size), imgui.get_mouse_pos().x
    name, mark_m = bar.flag_under_pointer()
    if name is not None and imgui.is_item_activated():
        lens = focused_at(lens, 1.0 / mark_m)
    elif imgui.is_item_activated() or (imgui.is_item_active() and imgui.get_io().mouse_delta.x):
        lens = focused_at(lens, bar.dioptres_at(x))
    if notches:
        lens = nudged(lens, histogram, notches)
    bar.lens = lens
    is_pointed_at = imgui.is_item_hovered() and not imgui.is_item_active()
    bar.draw(is_pointed_at)
    return lens, name if is_pointed_at else None


class _Bar:
    """Draws the bar, and knows what lies where."""

    def __init__(
        self, facts: Facts, histogram: DepthHistogram, corner: ImVec2, size: ImVec2
    ) -> None:
        self.lens, self._unit, self._histogram = facts.lens, facts.unit, histogram
        self._marks, self._keyed_m = facts.marks_m, facts.keyed_focus_m
        self._corner, self._size = corner, size
        self._em = imgui.get_font_size()
        self._draw = imgui.get_window_draw_list()
        self._left = corner.x + _EDGE_EM * self._em
        self._width = max(size.x - 2 * _EDGE_EM * self._em, 1.0)
        self._top = corner.y + _FIGURES_EM * self._em  # top of the groove
        self._bottom = max(corner.y + size.y - _SCALE_EM * self._em, self._top + 1.0)
        self._flags = self._placed_flags()
        right = self._left + self._width
        probe.note_at("focus bar", (self._left, corner.y, right, corner.y + size.y))

    def dioptres_at(self, x: float) -> float:
        """Return the dioptres at a screen position."""
        part = min(max((x - self._left) / self._width, 0.0), 1.0)
        return (1.0 - part) * self._histogram.most_dioptres

    def _x_at(self, distance_m: float) -> float:
        return float(self._left + (1.0 - self._histogram.part_at(distance_m)) * self._width)

    def flag_under_pointer(self) -> tuple[str | None, float]:
        """Return the name and the distance in m of the mark whose flag lies under the pointer."""
        for name, distance_m, (x0, y0, x1, y1) in self._flags:
            if imgui.is_mouse_hovering_rect(ImVec2(x0, y0), ImVec2(x1, y1)):
                return name, distance_m
        return None, 0.0

    def _placed_flags(self) -> list[tuple[str, float, Rect]]:
        """Return names, distances and rectangles of the marks' flags that touch no other."""
        flags, end, em = [], self._left + self._width, self._em
        free_x = [self._left] * max(
            int((self._bottom - self._top) / em), 1
        )  # the first free x in each row
        for name, distance_m in sorted(self._marks, key=lambda mark: mark[1]):
            x, width = self._x_at(distance_m), texts.text_width(printable(name)) + 0.6 * em
            x = (
                x - width if x + width > end else x
            )  # the flag of a mark near the right end points left
            row = next((row for row, free in enumerate(free_x) if x >= free), None)
            if row is not None:
                y = self._top + row * em
                flags.append((name, distance_m, (x, y, x + width, y + em)))
                free_x[row] = x + width + 1.0
        return flags

    def draw(self, is_pointed_at: bool) -> None:
        """Draw everything; `is_pointed_at` adds the distance at the pointer."""
        end = ImVec2(self._corner.x + self._size.x, self._corner.y + self._size.y)
        self._draw.push_clip_rect(self._corner, end, True)
        self._draw.add_rect_filled(self._corner, end, theme.packed(_window_color()))
        right = self._left + self._width
        corner, groove_end = ImVec2(self._left, self._top), ImVec2(right, self._bottom)
        self._draw.add_rect_filled(corner, groove_end, theme.colors.groove, 2.0)
        near_m, far_m = near_limit_m(self.lens), far_limit_m(self.lens)
        lit = self._x_at(near_m), self._x_at(far_m)
        size = ImVec2(self._width, self._bottom - self._top)
        draw_histogram(self._draw, self._histogram, corner, size, lit)
        for x in lit:
            self._line(x, theme.colors.in_focus)
        self._draw_hyperfocal()
        self._draw_marks()
        self._draw_scale()
        figures = self._draw_needles(near_m, far_m)
        if is_pointed_at:
            self._draw_pointer(figures)
        self._draw.pop_clip_rect()

    def _line(self, x: float, color: int, em: float = _LINE_EM, rise: float = 0.0) -> None:
        first, last = ImVec2(x, self._top - rise), ImVec2(x, self._bottom)
        self._draw.add_line(first, last, color, em * self._em)

    def _draw_hyperfocal(self) -> None:
        x, half = self._x_at(hyperfocal_m(self.lens)), 0.33 * self._em
        self._draw.add_triangle_filled(
            ImVec2(x - half, self._bottom),
            ImVec2(x + half, self._bottom),
            ImVec2(x, self._bottom - 1.4 * half),
            theme.colors.hyperfocal,
        )

    def _draw_marks(self) -> None:
        """Draw a line for each mark, and its name as a flag of tape if it touches no other."""
        for _, distance_m in self._marks:
            self._line(self._x_at(distance_m), theme.colors.mark)
        for name, _, rect in self._flags:
            x0, y0, x1, y1 = rect
            self._draw.add_rect_filled(ImVec2(x0, y0), ImVec2(x1, y1), theme.colors.mark, 1.0)
            at = ImVec2(x0 + 0.3 * self._em, y0)
            self._draw.add_text(at, theme.colors.on_accent, printable(name))
            probe.note_at(f"{name} on the bar", rect)

    def _draw_scale(self) -> None:
        histogram, offset_m = self._histogram, self.lens.measuring_offset_m
        for distance_m in engraved_m(histogram, offset_m, self._unit):
            x = self._x_at(distance_m)
            y = self._bottom + _MINOR_EM * self._em
            self._draw.add_line(ImVec2(x, self._bottom), ImVec2(x, y), theme.colors.queued)
        corner = ImVec2(self._left, self._bottom + TICK_EM * self._em)
        size = ImVec2(self._width, 0.0)
        draw_scale(self._draw, histogram, corner, size, self._unit, offset_m)

    def _draw_needles(self, near_m: float, far_m: float) -> Rect:
        """Draw the needle and its figures, and the ghost of the keys; return where figures lie."""
        lens, em, keyed_m = self.lens, self._em, self._keyed_m
        if keyed_m is not None:
            self._line(self._x_at(keyed_m), theme.colors.mark, _GHOST_EM, 0.25 * em)
            x = self._x_at(keyed_m)
            probe.note_at("keyed focus", (x, self._top, x, self._bottom))
        x, words = self._x_at(lens.focus_distance_m), self._words(lens.focus_distance_m)
        self._line(x, theme.colors.accent, _NEEDLE_EM, 0.4 * em)
        font_px = _FOCUS_PART * em
        width = _FOCUS_PART * texts.text_width(words) + 0.8 * em
        x0 = min(max(x - width / 2, self._left), self._left + self._width - width)
        y = self._corner.y + 0.12 * em
        plate = x0, y, x0 + width, y + 1.3 * em
        self._draw.add_rect_filled(ImVec2(*plate[:2]), ImVec2(*plate[2:]), theme.colors.accent, 3.0)
        at = ImVec2(x0 + 0.4 * em, y + 0.06 * em)
        font = imgui.get_font()
        self._draw.add_text(font, font_px, at, theme.colors.on_accent, words)
        probe.note_at("focus on the bar", plate)
        left = self._figure(self._words(near_m), plate[0], -1)
        right = self._figure(self._words(far_m), plate[2], 1)
        return left, y, right, plate[3]

    def _figure(self, words: str, x: float, side: int) -> float:
        """Draw a limit of what is sharp beside the figure of the focus, if there is room.

        Return the x of its far end.
        """
        width, gap = texts.text_width(words), _GAP_EM * self._em
        x0 = x + gap if side > 0 else x - gap - width
        if x0 < self._corner.x or x0 + width > self._corner.x + self._size.x:
            return x
        at = ImVec2(x0, self._corner.y + 0.25 * self._em)
        self._draw.add_text(at, theme.colors.in_focus, words)
        return x0 + width if side > 0 else x0

    def _draw_pointer(self, taken: Rect) -> None:
        """Draw the distance at the pointer beside the other figures, never over the scale."""
        x, em = imgui.get_mouse_pos().x, self._em
        words = self._pointed_words(x)
        if words == self._words(self.lens.focus_distance_m):
            return  # the needle already shows it
        width = texts.text_width(words)
        self._line(x, theme.colors.text_dim)
        x0, gap = x - width / 2, _GAP_EM * em
        if taken[0] - gap < x0 + width and x0 < taken[2] + gap:
            x0 = taken[2] + 2 * gap if x > (taken[0] + taken[2]) / 2 else taken[0] - 2 * gap - width
        if x0 < self._corner.x:
            x0 = taken[2] + 2 * gap
        elif x0 + width > self._corner.x + self._size.x:
            x0 = taken[0] - 2 * gap - width
        y = self._corner.y + 0.25 * em
        self._draw.add_text(ImVec2(x0, y), theme.colors.text_dim, words)
        probe.note_at("distance at the pointer", (x0, y, x0 + width, y + em))

    def _pointed_words(self, x: float) -> str:
        hyper_m, reach = hyperfocal_m(self.lens), _REACH_EM * self._em
        if abs(x - self._x_at(hyper_m)) < reach:
            return f"hyperfocal {self._words(hyper_m)}"
        if self._keyed_m is not None and abs(x - self._x_at(self._keyed_m)) < reach:
            return f"key {self._words(self._keyed_m)}"
        return self._words(focused_at(self.lens, self.dioptres_at(x)).focus_distance_m)

    def _words(self, distance_m: float) -> str:
        return measured_text(self.lens, distance_m, self._unit)


def _window_color() -> tuple[float, float, float]:
    color = imgui.get_style().color_(imgui.Col_.window_bg)
    return color.x, color.y, color.z
