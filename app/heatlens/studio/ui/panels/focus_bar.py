"""Draw the focus bar under the picture: a scale of distances, the depths of the scene, the focus.

Equal widths are equal dioptres. Infinity is at the right and the nearest surface at the left, as
on most lens barrels. From top to bottom the bar has a line of figures, the groove with the depths,
and the scale.
"""

import math

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import far_limit_m, hyperfocal_m, near_limit_m
from heatlens.core.model.lens.lens import Lens, measured_text
from heatlens.core.model.marks.marks import MarkAnchor
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.media.plate.coc_line import focused_at, nudge_lens
from heatlens.studio.board.facts import Facts
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.panels.depth_scale import TICK_EM, draw_histogram, draw_scale, fine_ticks_m
from heatlens.studio.ui.rects import Rect

_HEIGHT_EM, _MAX_SHARE = 5.4, 0.25  # height, and its largest share of the space under the menus
_FIGURES_EM, _SCALE_EM, _EDGE_EM = 1.55, 1.45, 0.9  # heights of the lines, space at the ends
_MINOR_EM = 0.2  # length of the fine ticks
_ARROW_EM = 0.7  # head of the arrow of a pull
_POINTER_REACH_EM = 0.4  # largest distance between the pointer and its target
_FOCUS_FONT_SCALE = 1.15  # size of the focus figure relative to the others
_GAP_EM = 0.45  # gap between figures
_NEEDLE_EM, _GHOST_EM, _LINE_EM = 0.17, 0.1, 0.067  # widths of lines


def focus_bar_height(height: float) -> float:
    """Return the height of the bar if the picture and the bar together have this height."""
    return min(_HEIGHT_EM * float(imgui.get_font_size()), _MAX_SHARE * height)


# The bar is the main control of the window, so it is as wide as the picture. The distance at the
# pointer is drawn beside the figure of the focus, because a tooltip would cover the scale.
def focus_bar(
    facts: Facts, histogram: DepthHistogram, corner: ImVec2, size: ImVec2, pull_target: str = ""
) -> tuple[Lens, str | None]:
    """Draw the bar in the current window; return the lens, focused by a drag or the wheel.

    An arrow leads from the needle to the mark `pull_target`, if a pull to it is being set up. A
    press on the name of a mark focuses exactly on it. Return also the name of the mark whose flag
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
        lens = nudge_lens(lens, histogram, notches)
    bar.lens = lens
    is_hovered = imgui.is_item_hovered() and not imgui.is_item_active()
    bar.draw(is_hovered, pull_target)
    return lens, name if is_hovered else None


class _Bar:
    """Draws the bar, and maps distances to positions on it."""

    def __init__(
        self, facts: Facts, histogram: DepthHistogram, corner: ImVec2, size: ImVec2
    ) -> None:
        self.lens, self._unit, self._histogram = facts.lens, facts.unit, histogram
        self._marks, self._keyed_m = facts.marks_m, facts.keyed_focus_m
        self._anchors = {mark.name: MarkAnchor.of(mark) for mark in facts.shot.marks}
        self._corner, self._size = corner, size
        self._em = imgui.get_font_size()
        self._draw = imgui.get_window_draw_list()
        self._left = corner.x + _EDGE_EM * self._em
        self._width = max(size.x - 2 * _EDGE_EM * self._em, 1.0)
        self._top = corner.y + _FIGURES_EM * self._em  # top of the groove
        self._bottom = max(corner.y + size.y - _SCALE_EM * self._em, self._top + 1.0)
        self._flags = self._place_flags()
        right = self._left + self._width
        rects.note_at("focus bar", (self._left, corner.y, right, corner.y + size.y))

    def dioptres_at(self, x: float) -> float:
        """Return the dioptres at a screen position."""
        share = min(max((x - self._left) / self._width, 0.0), 1.0)
        return (1.0 - share) * self._histogram.most_dioptres

    def _x_at(self, distance_m: float) -> float:
        return float(self._left + (1.0 - self._histogram.scale_position(distance_m)) * self._width)

    def flag_under_pointer(self) -> tuple[str | None, float]:
        """Return the name and the distance in m of the mark whose flag lies under the pointer."""
        for name, distance_m, (x0, y0, x1, y1) in self._flags:
            if imgui.is_mouse_hovering_rect(ImVec2(x0, y0), ImVec2(x1, y1)):
                return name, distance_m
        return None, 0.0

    def _place_flags(self) -> list[tuple[str, float, Rect]]:
        """Return names, distances and rectangles of the marks' flags that do not overlap."""
        flags, right_x, em = [], self._left + self._width, self._em
        free_x = [self._left] * max(
            int((self._bottom - self._top) / em), 1
        )  # the first free x in each row
        for name, distance_m in sorted(self._marks, key=lambda mark: mark[1]):
            x, width = self._x_at(distance_m), texts.text_width(printable(name)) + 0.6 * em
            # The flag of a mark near the right end points left.
            x = x - width if x + width > right_x else x
            row = next((row for row, free_from in enumerate(free_x) if x >= free_from), None)
            if row is not None:
                y = self._top + row * em
                flags.append((name, distance_m, (x, y, x + width, y + em)))
                free_x[row] = x + width + 1.0
        return flags

    def draw(self, is_hovered: bool, pull_target: str) -> None:
        """Draw everything; `is_hovered` adds the distance at the pointer."""
        end = ImVec2(self._corner.x + self._size.x, self._corner.y + self._size.y)
        self._draw.push_clip_rect(self._corner, end, True)
        self._draw.add_rect_filled(self._corner, end, theme.pack_color(_window_color()))
        right = self._left + self._width
        corner, groove_end = ImVec2(self._left, self._top), ImVec2(right, self._bottom)
        self._draw.add_rect_filled(corner, groove_end, theme.colors.groove, 2.0)
        near_m, far_m = near_limit_m(self.lens), far_limit_m(self.lens)
        sharp_range_x = self._x_at(near_m), self._x_at(far_m)
        size = ImVec2(self._width, self._bottom - self._top)
        draw_histogram(self._draw, self._histogram, corner, size, sharp_range_x)
        for x in sharp_range_x:
            self._draw_line(x, theme.colors.in_focus)
        self._draw_hyperfocal()
        self._draw_marks()
        self._draw_scale()
        figures = self._draw_needles(near_m, far_m)
        for name, distance_m in self._marks:
            if name == pull_target:
                self._draw_pull(self._x_at(distance_m))
        if is_hovered:
            self._draw_pointer(figures)
        self._draw.pop_clip_rect()

    def _draw_line(self, x: float, color: int, em: float = _LINE_EM, rise: float = 0.0) -> None:
        """Draw a line across the groove, which begins `rise` above it."""
        first, last = ImVec2(x, self._top - rise), ImVec2(x, self._bottom)
        self._draw.add_line(first, last, color, em * self._em)

    def _draw_hyperfocal(self) -> None:
        """Draw a triangle at the hyperfocal distance."""
        x, half_width = self._x_at(hyperfocal_m(self.lens)), 0.33 * self._em
        self._draw.add_triangle_filled(
            ImVec2(x - half_width, self._bottom),
            ImVec2(x + half_width, self._bottom),
            ImVec2(x, self._bottom - 1.4 * half_width),
            theme.colors.hyperfocal,
        )

    def _draw_marks(self) -> None:
        """Draw a line for each mark, and its name as a flag if it overlaps no other."""
        for _, distance_m in self._marks:
            self._draw_line(self._x_at(distance_m), theme.colors.mark)
        for name, _, rect in self._flags:
            x0, y0, x1, y1 = rect
            self._draw.add_rect_filled(ImVec2(x0, y0), ImVec2(x1, y1), theme.colors.mark, 1.0)
            text_corner = ImVec2(x0 + 0.3 * self._em, y0)
            self._draw.add_text(text_corner, theme.colors.on_accent, printable(name))
            rects.note_at(f"{name} on the bar", rect)

    def _draw_pull(self, target_x: float) -> None:
        """Draw an arrow from the needle to where a pull leads."""
        x, y = self._x_at(self.lens.focus_distance_m), (self._top + self._bottom) / 2
        head = min(_ARROW_EM * self._em, abs(target_x - x))
        back_x = target_x - math.copysign(head, target_x - x)
        color, tip = theme.colors.accent, ImVec2(target_x, y)
        self._draw.add_line(ImVec2(x, y), ImVec2(back_x, y), color, _NEEDLE_EM * self._em)
        self._draw.add_triangle_filled(
            tip, ImVec2(back_x, y - head / 2), ImVec2(back_x, y + head / 2), color
        )
        rects.note_at("pull on the bar", (min(x, target_x), y, max(x, target_x), y))

    def _draw_scale(self) -> None:
        """Draw the fine ticks and the labeled distances under the groove."""
        histogram, offset_m = self._histogram, self.lens.measuring_offset_m
        for distance_m in fine_ticks_m(histogram, offset_m, self._unit):
            x = self._x_at(distance_m)
            y = self._bottom + _MINOR_EM * self._em
            self._draw.add_line(ImVec2(x, self._bottom), ImVec2(x, y), theme.colors.queued)
        corner = ImVec2(self._left, self._bottom + TICK_EM * self._em)
        size = ImVec2(self._width, 0.0)
        draw_scale(self._draw, histogram, corner, size, self._unit, offset_m)

    def _draw_needles(self, near_m: float, far_m: float) -> Rect:
        """Draw the needle, its figures and a thin line at the keyed focus.

        Return the rectangle of the figures.
        """
        lens, em, keyed_m = self.lens, self._em, self._keyed_m
        if keyed_m is not None:
            self._draw_line(self._x_at(keyed_m), theme.colors.mark, _GHOST_EM, 0.25 * em)
            x = self._x_at(keyed_m)
            rects.note_at("keyed focus", (x, self._top, x, self._bottom))
        x, words = self._x_at(lens.focus_distance_m), self._distance_words(lens.focus_distance_m)
        self._draw_line(x, theme.colors.accent, _NEEDLE_EM, 0.4 * em)
        font_px = _FOCUS_FONT_SCALE * em
        width = _FOCUS_FONT_SCALE * texts.text_width(words) + 0.8 * em
        limits = self._distance_words(near_m), self._distance_words(far_m)
        # room for both limits of the sharp range beside the figure, also where the needle is at
        # an end of the bar
        gap = _GAP_EM * em
        before, after = (texts.text_width(limit) + gap for limit in limits)
        end = self._left + self._width
        x0 = min(max(x - width / 2, self._left + before), end - width - after)
        y = self._corner.y + 0.12 * em
        figure_rect = x0, y, x0 + width, y + 1.3 * em
        self._draw.add_rect_filled(
            ImVec2(*figure_rect[:2]), ImVec2(*figure_rect[2:]), theme.colors.accent, 3.0
        )
        text_corner = ImVec2(x0 + 0.4 * em, y + 0.06 * em)
        font = imgui.get_font()
        self._draw.add_text(font, font_px, text_corner, theme.colors.on_accent, words)
        rects.note_at("focus on the bar", figure_rect)
        left, right = x0 - before, x0 + width + after
        for limit, limit_x in zip(limits, (left, x0 + width + gap), strict=True):
            corner = ImVec2(limit_x, self._corner.y + 0.25 * em)
            self._draw.add_text(corner, theme.colors.in_focus, limit)
        rects.note_at("sharp range on the bar", (left, y, right, figure_rect[3]))
        return left, y, right, figure_rect[3]

    def _draw_pointer(self, occupied: Rect) -> None:
        """Draw the distance at the pointer beside the other figures, never over the scale."""
        x, em = imgui.get_mouse_pos().x, self._em
        words = self._pointer_words(x)
        width = texts.text_width(words)
        self._draw_line(x, theme.colors.text_dim)
        gap, end = _GAP_EM * em, self._left + self._width - width
        x0 = min(max(x - width / 2, self._left), end)
        if occupied[0] - gap < x0 + width and x0 < occupied[2] + gap:
            places = [occupied[0] - 2 * gap - width, occupied[2] + 2 * gap]
            fitting = [place for place in places if self._left <= place <= end]
            if not fitting:
                return
            x0 = min(fitting, key=lambda place: abs(place + width / 2 - x))
        y = self._corner.y + 0.25 * em
        self._draw.add_text(ImVec2(x0, y), theme.colors.text_dim, words)
        rects.note_at("distance at the pointer", (x0, y, x0 + width, y + em))

    def _pointer_words(self, x: float) -> str:
        """Return the distance at a screen position in full, with the name of what is there."""
        name, mark_m = self.flag_under_pointer()
        if name is not None:
            anchor = self._anchors.get(name)
            held = "" if anchor is None else f", the {anchor}"
            return f"{printable(name)}{held}: {measured_text(self.lens, mark_m, self._unit)}"
        hyper_m, reach = hyperfocal_m(self.lens), _POINTER_REACH_EM * self._em
        if abs(x - self._x_at(hyper_m)) < reach:
            return f"hyperfocal {measured_text(self.lens, hyper_m, self._unit)}"
        if self._keyed_m is not None and abs(x - self._x_at(self._keyed_m)) < reach:
            return f"key {measured_text(self.lens, self._keyed_m, self._unit)}"
        if abs(x - self._x_at(self.lens.focus_distance_m)) < reach:
            return f"focus {measured_text(self.lens, self.lens.focus_distance_m, self._unit)}"
        pointed_m = focused_at(self.lens, self.dioptres_at(x)).focus_distance_m
        return measured_text(self.lens, pointed_m, self._unit)

    def _distance_words(self, distance_m: float) -> str:
        return texts.measured_label(self.lens, distance_m, self._unit)


def _window_color() -> tuple[float, float, float]:
    """Return red, green and blue of the background of windows."""
    color = imgui.get_style().color_(imgui.Col_.window_bg)
    return color.x, color.y, color.z
