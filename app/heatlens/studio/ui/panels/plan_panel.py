"""Draw the plan: the camera, what is sharp, surfaces and marks from above, to scale."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.units import FOOT_M
from heatlens.studio.board.plan import Plan, PlanMark
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.panels.depth_scale import tick_text

_EDGE_EM, _CAMERA_EM, _MIN_HEIGHT_EM = 1.0, 1.0, 8.0
_DOT_EM, _LINE_EM, _NEEDLE_EM = 0.12, 0.067, 0.17
_ZOOM, _ZOOM_LEAST, _ZOOM_MOST = 1.25, 0.1, 50.0  # zoom factor of one wheel notch; its limits
_MAX_LINES = 7  # largest number of distance lines


@dataclass(frozen=True)
class PlanMoves:
    """A drag by the user: the focus or a mark, and its new distance in m; None and "" for none."""

    focus_m: float | None = None
    mark: str = ""
    mark_m: float = 0.0


class PlanPanel:
    """Draws the plan into the current window; a drag moves the focus or a mark, the wheel zooms."""

    def __init__(self) -> None:
        self._dragged_mark = ""  # the name of the mark that is dragged
        self._zoom = 1.0
        self._reach_m = 1.0  # stays during a drag, so that the mark stays under the pointer

    def draw(self, plan: Plan, lens: Lens, unit: str) -> PlanMoves:
        """Draw the plan into the rest of the window; return what the user dragged."""
        em, free_size = imgui.get_font_size(), imgui.get_content_region_avail()
        corner = imgui.get_cursor_screen_pos()
        size = ImVec2(free_size.x, max(free_size.y, _MIN_HEIGHT_EM * em))
        widgets.invisible_button("plan", corner, size)
        zoom = self._zoom * _ZOOM ** widgets.wheel_over_last()
        self._zoom = min(max(zoom, _ZOOM_LEAST), _ZOOM_MOST)
        if not imgui.is_item_active():
            self._reach_m = plan.reach_m / self._zoom
        plan = replace(plan, reach_m=self._reach_m)
        drawing = _Drawing(plan, lens, unit, corner, size)
        drawing.draw()
        if imgui.is_item_activated():
            self._dragged_mark = drawing.mark_under_pointer()
        if not imgui.is_item_active():
            return PlanMoves()
        pointer_m = drawing.distance_at(imgui.get_mouse_pos().y)
        is_moved = imgui.is_mouse_dragging(imgui.MouseButton_.left, 1.0)
        if self._dragged_mark:
            return PlanMoves(None, self._dragged_mark, pointer_m) if is_moved else PlanMoves()
        return PlanMoves(pointer_m) if is_moved or imgui.is_item_activated() else PlanMoves()


class _Drawing:
    """Draws a plan; maps meters to the screen."""

    def __init__(self, plan: Plan, lens: Lens, unit: str, corner: ImVec2, size: ImVec2) -> None:
        self._plan, self._lens, self._unit = plan, lens, unit
        self._corner, self._size = corner, size
        self._em, self._draw_list = imgui.get_font_size(), imgui.get_window_draw_list()
        edge = _EDGE_EM * self._em
        plan_size = size.x - 2 * edge, size.y - edge - 2 * _CAMERA_EM * self._em
        width = 2.0 * plan.half_tangent * plan.reach_m
        self._pixels_per_m = max(min(plan_size[0] / width, plan_size[1] / plan.reach_m), 1e-6)
        self._x0 = corner.x + size.x / 2
        self._y0 = corner.y + size.y - 2 * _CAMERA_EM * self._em  # the y of the camera
        self._flags: list[tuple[PlanMark, tuple[float, float, float, float]]] = []

    def _screen_point(self, side_m: float, distance_m: float) -> ImVec2:
        """Return the screen position of a point, at most at the far end of the plan."""
        shown_m = min(distance_m, self._plan.reach_m)
        return ImVec2(
            self._x0 + side_m * self._pixels_per_m, self._y0 - shown_m * self._pixels_per_m
        )

    def distance_at(self, y: float) -> float:
        """Return the distance in m at a screen position, within the plan."""
        least_m = 1.02e-3 * self._lens.focal_length_mm
        return min(max((self._y0 - y) / self._pixels_per_m, least_m), self._plan.reach_m)

    def mark_under_pointer(self) -> str:
        """Return the name of the mark under the pointer that can be moved; "" for none."""
        for mark, (x0, y0, x1, y1) in self._flags:
            if mark.is_movable and imgui.is_mouse_hovering_rect(ImVec2(x0, y0), ImVec2(x1, y1)):
                return mark.name
        return ""

    def draw(self) -> None:
        """Draw distances, sharp range, surfaces, camera and marks, and the focus on top of them."""
        end = ImVec2(self._corner.x + self._size.x, self._corner.y + self._size.y)
        self._draw_list.push_clip_rect(self._corner, end, True)
        self._draw_list.add_rect_filled(self._corner, end, theme.colors.groove, 2.0)
        self._draw_distances()
        self._draw_sharp_range()
        self._draw_surfaces()
        self._draw_camera()
        self._draw_marks()
        self._draw_focus()
        self._draw_list.pop_clip_rect()

    def _view_line(self, distance_m: float) -> tuple[ImVec2, ImVec2]:
        """Return the ends of a line across the camera's view at a distance."""
        half_m = self._plan.half_tangent * min(distance_m, self._plan.reach_m)
        return self._screen_point(-half_m, distance_m), self._screen_point(half_m, distance_m)

    @property
    def _focus_words(self) -> str:
        """The distance of the focus in words."""
        return texts.measured_label(self._lens, self._lens.focus_distance_m, self._unit)

    @property
    def _focus_flag(self) -> tuple[ImVec2, ImVec2]:
        """The corners of the flag of the focus, at the left end of its plane."""
        first, em = self._plane_points(0.0)[0], self._em
        width = texts.text_width(self._focus_words) + 0.6 * em
        corner = ImVec2(max(first.x - width, self._corner.x), first.y - 0.6 * em)
        return corner, ImVec2(corner.x + width, corner.y + 1.2 * em)

    def _draw_distances(self) -> None:
        """Draw lines at round distances, with the labels that the flag of the focus leaves."""
        flag_corner, flag_end = self._focus_flag
        for distance_m in round_steps_m(self._plan.reach_m, self._unit):
            y = self._screen_point(0.0, distance_m).y
            first, last = ImVec2(self._corner.x, y), ImVec2(self._corner.x + self._size.x, y)
            self._draw_list.add_line(first, last, theme.colors.played, _LINE_EM * self._em)
            text_corner = ImVec2(self._corner.x + 0.3 * self._em, y - self._em)
            words = tick_text(distance_m, self._unit)
            right = text_corner.x + texts.text_width(words)
            is_beside = flag_corner.x >= right or flag_corner.y >= y or text_corner.y >= flag_end.y
            if is_beside:
                self._draw_list.add_text(text_corner, theme.colors.text_dim, words)

    def _plane_points(self, dioptres: float) -> list[ImVec2]:
        """Return points, from left to right, of the plane `dioptres` nearer than the focus."""
        side_shares = np.linspace(-1.0, 1.0, len(self._plan.plane)).tolist()
        sharp_dioptres = 1.0 / self._lens.focus_distance_m + self._plan.plane + dioptres
        reach_m, half_tangent = self._plan.reach_m, self._plan.half_tangent
        distances_m = [
            min(1.0 / value, reach_m) if value > 0 else reach_m for value in sharp_dioptres.tolist()
        ]
        return [
            self._screen_point(share * half_tangent * distance_m, distance_m)
            for share, distance_m in zip(side_shares, distances_m, strict=True)
        ]

    def _draw_plane(self, dioptres: float, color: int, width_em: float) -> None:
        """Draw the plane `dioptres` nearer than the focus, `width_em` thick."""
        for first, last in pairwise(self._plane_points(dioptres)):
            self._draw_list.add_line(first, last, color, width_em * self._em)

    def _draw_sharp_range(self) -> None:
        """Draw the area between the near and the far limit of the sharp range."""
        range_dioptres = sharp_dioptres(self._lens)
        near, far = self._plane_points(range_dioptres), self._plane_points(-range_dioptres)
        for (a, b), (c, d) in zip(pairwise(near), pairwise(far), strict=True):
            self._draw_list.add_quad_filled(a, b, d, c, theme.colors.in_focus_band)
        for limit in (range_dioptres, -range_dioptres):
            self._draw_plane(limit, theme.colors.in_focus, _LINE_EM)

    def _draw_surfaces(self) -> None:
        """Draw a dot for each sampled surface, in another color if it is in focus."""
        half_dot, colors = _DOT_EM * self._em / 2, theme.colors
        focus = 1.0 / self._lens.focus_distance_m + self._plan.nearer
        defocus = np.abs(1.0 / self._plan.points[:, 1] - focus)
        is_sharp = (defocus <= sharp_dioptres(self._lens)).tolist()
        for (side_m, distance_m), in_focus in zip(
            self._plan.points.tolist(), is_sharp, strict=True
        ):
            if distance_m <= self._plan.reach_m:
                point = self._screen_point(side_m, distance_m)
                color = colors.in_focus if in_focus else colors.histogram
                dot_corner = ImVec2(point.x - half_dot, point.y - half_dot)
                self._draw_list.add_rect_filled(
                    dot_corner, ImVec2(point.x + half_dot, point.y + half_dot), color
                )

    def _draw_camera(self) -> None:
        """Draw the camera as a box with a lens, and the limits of what it sees."""
        em, camera = self._em, self._screen_point(0.0, 0.0)
        for end in self._view_line(self._plan.reach_m):
            self._draw_list.add_line(camera, end, theme.colors.text_dim, _LINE_EM * em)
        box_corner = ImVec2(camera.x - 0.45 * em, camera.y + 0.35 * em)
        box_end = ImVec2(camera.x + 0.45 * em, camera.y + 1.5 * em)
        self._draw_list.add_rect_filled(box_corner, box_end, theme.colors.handle, 2.0)
        left, right = (ImVec2(camera.x + side * 0.4 * em, camera.y) for side in (-1, 1))
        middle = ImVec2(camera.x, camera.y + 0.6 * em)
        self._draw_list.add_triangle_filled(left, right, middle, theme.colors.handle)

    def _draw_marks(self) -> None:
        """Draw each mark as a line or a dot with its name, and note where it can be dragged."""
        em = self._em
        for mark in self._plan.marks:
            point, color = self._screen_point(mark.side_m, mark.distance_m), theme.colors.mark
            if mark.is_movable:
                first, point = self._view_line(mark.distance_m)
                self._draw_list.add_line(first, point, color, _LINE_EM * em)
            else:
                self._draw_list.add_circle_filled(point, 0.25 * em, color)
            name = printable(mark.name)
            width = imgui.calc_text_size(name).x + 0.6 * em
            rect = (
                point.x + 0.2 * em,
                point.y - 0.5 * em,
                point.x + 0.2 * em + width,
                point.y + 0.5 * em,
            )
            self._draw_list.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), color, 2.0)
            text_corner = ImVec2(rect[0] + 0.3 * em, rect[1])
            self._draw_list.add_text(text_corner, theme.colors.on_accent, name)
            self._flags.append((mark, rect))
            rects.note_at(f"{mark.name} on the plan", rect)

    def _draw_focus(self) -> None:
        """Draw the plane of focus with its distance."""
        em, (flag_corner, flag_end) = self._em, self._focus_flag
        first, *_, last = self._plane_points(0.0)
        self._draw_plane(0.0, theme.colors.accent, _NEEDLE_EM)
        words = self._focus_words
        self._draw_list.add_rect_filled(flag_corner, flag_end, theme.colors.accent, 3.0)
        text_corner = ImVec2(flag_corner.x + 0.3 * em, flag_corner.y + 0.1 * em)
        self._draw_list.add_text(text_corner, theme.colors.on_accent, words)
        rects.note_at("focus on the plan", (first.x, first.y, last.x, last.y))


def round_steps_m(reach_m: float, unit: str) -> list[float]:
    """Return at most seven evenly spaced round distances, up to a reach."""
    unit_m = FOOT_M if unit == "ft" else 1.0
    min_step = reach_m / unit_m / _MAX_LINES
    power = 10.0 ** math.floor(math.log10(min_step))
    step = next(step * power for step in (1, 2, 5, 10) if step * power >= min_step * (1 - 1e-9))
    count = int(reach_m / unit_m / step * (1 + 1e-9))
    return [unit_m * step * index for index in range(1, count + 1)]
