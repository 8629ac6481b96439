"""Draw the plan: the camera, what is sharp, surfaces and marks from above, to scale."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.lens.lens import Lens, measured_text
from heatlens.core.model.units import FOOT_M
from heatlens.studio.session.marks.plan import Plan, PlanMark
from heatlens.studio.ui import probe, theme, widgets
from heatlens.studio.ui.panels.depth_scale import tick_text

_EDGE_EM, _CAMERA_EM, _LEAST_EM = 1.0, 1.0, 8.0
_DOT_EM, _LINE_EM, _NEEDLE_EM = 0.12, 0.067, 0.17
_ZOOM, _ZOOM_LEAST, _ZOOM_MOST = 1.25, 0.1, 50.0  # zoom factor of one wheel notch; its limits
_LINES_MOST = 7  # largest number of distance lines


@dataclass(frozen=True)
class PlanMoves:
    """What the user moved: the focus or a mark, to a distance in m; None and "" for nothing."""

    focus_m: float | None = None
    mark: str = ""
    mark_m: float = 0.0


class PlanPanel:
    """Draws the plan into the current window; a drag moves the focus or a mark, the wheel zooms."""

    def __init__(self) -> None:
        self._held = ""  # the name of the mark that is dragged
        self._zoom = 1.0
        self._reach_m = 1.0  # stays during a drag, so that the mark stays under the pointer

    def draw(self, plan: Plan, lens: Lens, unit: str) -> PlanMoves:
        """Draw the plan into the room that is left; return what the user moved."""
        em, room = imgui.get_font_size(), imgui.get_content_region_avail()
        corner, size = imgui.get_cursor_screen_pos(), ImVec2(room.x, max(room.y, _LEAST_EM * em))
        widgets.area("plan", corner, size)
        zoom = self._zoom * _ZOOM ** widgets.wheel_over_last()
        self._zoom = min(max(zoom, _ZOOM_LEAST), _ZOOM_MOST)
        if not imgui.is_item_active():
            self._reach_m = plan.reach_m / self._zoom
        plan = replace(plan, reach_m=self._reach_m)
        drawing = _Drawing(plan, lens, unit, corner, size)
        drawing.draw()
        if imgui.is_item_activated():
            self._held = drawing.mark_under_pointer()
        if not imgui.is_item_active():
            return PlanMoves()
        at_m = drawing.distance_at(imgui.get_mouse_pos().y)
        is_moved = imgui.is_mouse_dragging(imgui.MouseButton_.left, 1.0)
        if self._held:
            return PlanMoves(None, self._held, at_m) if is_moved else PlanMoves()
        return PlanMoves(at_m) if is_moved or imgui.is_item_activated() else PlanMoves()


class _Drawing:
    """Maps metres to the screen, and draws."""

    def __init__(self, plan: Plan, lens: Lens, unit: str, corner: ImVec2, size: ImVec2) -> None:
        self._plan, self._lens, self._unit = plan, lens, unit
        self._corner, self._size = corner, size
        self._em, self._list = imgui.get_font_size(), imgui.get_window_draw_list()
        edge = _EDGE_EM * self._em
        room = size.x - 2 * edge, size.y - edge - 2 * _CAMERA_EM * self._em
        width = 2.0 * plan.half_tangent * plan.reach_m
        self._per_m = max(min(room[0] / width, room[1] / plan.reach_m), 1e-6)
        self._x0 = corner.x + size.x / 2
        self._y0 = corner.y + size.y - 2 * _CAMERA_EM * self._em  # the y of the camera
        self._flags: list[tuple[PlanMark, tuple[float, float, float, float]]] = []

    def _at(self, side_m: float, distance_m: float) -> ImVec2:
        far = min(distance_m, self._plan.reach_m)
        return ImVec2(self._x0 + side_m * self._per_m, self._y0 - far * self._per_m)

    def distance_at(self, y: float) -> float:
        """Return the distance in m at a screen position, within the plan."""
        least_m = 1.02e-3 * self._lens.focal_length_mm
        return min(max((self._y0 - y) / self._per_m, least_m), self._plan.reach_m)

    def mark_under_pointer(self) -> str:
        """Return the name of the mark under the pointer that can be moved; "" for none."""
        for mark, (x0, y0, x1, y1) in self._flags:
            if mark.is_movable and imgui.is_mouse_hovering_rect(ImVec2(x0, y0), ImVec2(x1, y1)):
                return mark.name
        return ""

    def draw(self) -> None:
        """Draw everything, the nearest to the user last."""
        end = ImVec2(self._corner.x + self._size.x, self._corner.y + self._size.y)
        self._list.push_clip_rect(self._corner, end, True)
        self._list.add_rect_filled(self._corner, end, theme.colors.groove, 2.0)
        self._draw_distances()
        self._draw_sharp()
        self._draw_surfaces()
        self._draw_camera()
        self._draw_marks()
        self._draw_focus()
        self._list.pop_clip_rect()

    def _across(self, distance_m: float) -> tuple[ImVec2, ImVec2]:
        """Return the ends of a line across what the camera sees at a distance."""
        half_m = self._plan.half_tangent * min(distance_m, self._plan.reach_m)
        return self._at(-half_m, distance_m), self._at(half_m, distance_m)

    def _draw_distances(self) -> None:
        for distance_m in round_steps_m(self._plan.reach_m, self._unit):
            y = self._at(0.0, distance_m).y
            first, last = ImVec2(self._corner.x, y), ImVec2(self._corner.x + self._size.x, y)
            self._list.add_line(first, last, theme.colors.played, _LINE_EM * self._em)
            at = ImVec2(self._corner.x + 0.3 * self._em, y - self._em)
            self._list.add_text(at, theme.colors.text_dim, tick_text(distance_m, self._unit))

    def _plane(self, dioptres: float) -> list[ImVec2]:
        """Return points from left to right of what is `dioptres` nearer than the focus."""
        sides = np.linspace(-1.0, 1.0, len(self._plan.plane)).tolist()
        sharp_dioptres = 1.0 / self._lens.focus_distance_m + self._plan.plane + dioptres
        reach_m, half = self._plan.reach_m, self._plan.half_tangent
        far_m = [min(1.0 / it, reach_m) if it > 0 else reach_m for it in sharp_dioptres.tolist()]
        return [self._at(side * half * at_m, at_m) for side, at_m in zip(sides, far_m, strict=True)]

    def _draw_plane(self, dioptres: float, color: int, width_em: float) -> None:
        for first, last in pairwise(self._plane(dioptres)):
            self._list.add_line(first, last, color, width_em * self._em)

    def _draw_sharp(self) -> None:
        sharp = sharp_dioptres(self._lens)
        near, far = self._plane(sharp), self._plane(-sharp)
        for (a, b), (c, d) in zip(pairwise(near), pairwise(far), strict=True):
            self._list.add_quad_filled(a, b, d, c, theme.colors.in_focus_band)
        for end in (sharp, -sharp):
            self._draw_plane(end, theme.colors.in_focus, _LINE_EM)

    def _draw_surfaces(self) -> None:
        reach, colors = _DOT_EM * self._em / 2, theme.colors
        focus = 1.0 / self._lens.focus_distance_m + self._plan.nearer
        off = np.abs(1.0 / self._plan.points[:, 1] - focus)
        is_sharp = (off <= sharp_dioptres(self._lens)).tolist()
        for (side_m, distance_m), sharp in zip(self._plan.points.tolist(), is_sharp, strict=True):
            if distance_m <= self._plan.reach_m:
                at = self._at(side_m, distance_m)
                color = colors.in_focus if sharp else colors.histogram
                low = ImVec2(at.x - reach, at.y - reach)
                self._list.add_rect_filled(low, ImVec2(at.x + reach, at.y + reach), color)

    def _draw_camera(self) -> None:
        """Draw the camera as a box with a lens, and the limits of what it sees."""
        em, camera = self._em, self._at(0.0, 0.0)
        for end in self._across(self._plan.reach_m):
            self._list.add_line(camera, end, theme.colors.text_dim, _LINE_EM * em)
        low = ImVec2(camera.x - 0.45 * em, camera.y + 0.35 * em)
        high = ImVec2(camera.x + 0.45 * em, camera.y + 1.5 * em)
        self._list.add_rect_filled(low, high, theme.colors.handle, 2.0)
        left, right = (ImVec2(camera.x + side * 0.4 * em, camera.y) for side in (-1, 1))
        middle = ImVec2(camera.x, camera.y + 0.6 * em)
        self._list.add_triangle_filled(left, right, middle, theme.colors.handle)

    def _draw_marks(self) -> None:
        em = self._em
        for mark in self._plan.marks:
            at, line = self._at(mark.side_m, mark.distance_m), theme.colors.mark
            if mark.is_movable:
                first, at = self._across(mark.distance_m)
                self._list.add_line(first, at, line, _LINE_EM * em)
            else:
                self._list.add_circle_filled(at, 0.25 * em, line)
            name = printable(mark.name)
            width = imgui.calc_text_size(name).x + 0.6 * em
            rect = at.x + 0.2 * em, at.y - 0.5 * em, at.x + 0.2 * em + width, at.y + 0.5 * em
            self._list.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), line, 2.0)
            place = ImVec2(rect[0] + 0.3 * em, rect[1])
            self._list.add_text(place, theme.colors.on_accent, name)
            self._flags.append((mark, rect))
            probe.note_at(f"{mark.name} on the plan", rect)

    def _draw_focus(self) -> None:
        em, distance_m = self._em, self._lens.focus_distance_m
        first, *_, last = self._plane(0.0)
        self._draw_plane(0.0, theme.colors.accent, _NEEDLE_EM)
        words = measured_text(self._lens, distance_m, self._unit)
        width = imgui.calc_text_size(words).x + 0.6 * em
        low = ImVec2(max(first.x - width, self._corner.x), first.y - 0.6 * em)
        high = ImVec2(low.x + width, low.y + 1.2 * em)
        self._list.add_rect_filled(low, high, theme.colors.accent, 3.0)
        at = ImVec2(low.x + 0.3 * em, low.y + 0.1 * em)
        self._list.add_text(at, theme.colors.on_accent, words)
        probe.note_at("focus on the plan", (first.x, first.y, last.x, last.y))


def round_steps_m(reach_m: float, unit: str) -> list[float]:
    """Return round distances that are evenly apart, up to a reach: at most seven."""
    unit_m = FOOT_M if unit == "ft" else 1.0
    least = reach_m / unit_m / _LINES_MOST
    power = 10.0 ** math.floor(math.log10(least))
    step = next(step * power for step in (1, 2, 5, 10) if step * power >= least * (1 - 1e-9))
    count = int(reach_m / unit_m / step * (1 + 1e-9))
    return [unit_m * step * i for i in range(1, count + 1)]
