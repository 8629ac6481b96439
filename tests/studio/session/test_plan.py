"""The plan: the scene in front of the camera, seen from above, in meters."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.focus_offset import focus_offset_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.studio.board.plan import PlanDrawer

WIDTH, HEIGHT = 96, 40


def plate_of(depth: np.ndarray, x0: int = 0) -> SimpleNamespace:
    """Return a stand-in for a plate with this depth, whose data begin at column `x0`.

    `asked` records each box whose depth the plan read.
    """
    height, width = depth.shape
    requested_boxes: list[Box] = []

    def depth_in(box: Box) -> np.ndarray:
        requested_boxes.append(box)
        return depth[box.y0 : box.y1, box.x0 : box.x1]

    return SimpleNamespace(
        pixels=SimpleNamespace(depth_in=depth_in),
        data_window=Box(x0, 0, x0 + width, height),
        display_window=Box(0, 0, WIDTH, HEIGHT),
        pixel_aspect_ratio=1.0,
        asked=requested_boxes,
    )


def lens(focal_length_mm: float = 50.0) -> Lens:
    return Lens(focal_length_mm, 2.0, 3.0, sensor_width_mm=36.0)


@given(st.floats(0.5, 80.0), st.floats(14.0, 200.0))
def test_plan_of_a_wall_is_as_wide_as_the_field_of_view(distance_m, focal_length_mm):
    wall = np.full((HEIGHT, WIDTH), distance_m, np.float32)
    plan = PlanDrawer().plan(plate_of(wall), lens(focal_length_mm), (), WIDTH)
    seen_m = 36.0 / focal_length_mm * distance_m
    assert plan.points[:, 1] == pytest.approx(distance_m, rel=1e-6)
    assert np.ptp(plan.points[:, 0]) == pytest.approx(seen_m * (WIDTH - 1) / WIDTH, rel=1e-4)
    assert plan.points[:, 0].mean() == pytest.approx(0.0, abs=1e-4 * seen_m)
    assert plan.reach_m > distance_m


def test_plan_puts_point_mark_on_the_surface_at_its_pixel():
    slope = np.tile(np.linspace(2.0, 5.0, WIDTH, dtype=np.float32), (HEIGHT, 1))
    marks = [(PointMark("A", 60.0, 9.0), float(slope[0, 60])), (DistanceMark("B", 4.0), 4.0)]
    plan = PlanDrawer().plan(plate_of(slope), lens(), marks, WIDTH)
    a, b = plan.marks
    nearest = np.abs(plan.points - np.float32([a.side_m, a.distance_m])).max(axis=1).min()
    assert nearest < 1e-4 and not a.is_movable
    assert (b.side_m, b.distance_m, b.is_movable) == (0.0, 4.0, True)


def test_plan_leaves_out_the_sky_and_reaches_to_a_far_mark():
    depth = np.full((HEIGHT, WIDTH), math.inf, np.float32)
    plan = PlanDrawer().plan(plate_of(depth), lens(), [(DistanceMark("A", 30.0), 30.0)], WIDTH)
    assert len(plan.points) == 0 and plan.reach_m > 30.0
    endless = [(DistanceMark("A", math.inf), math.inf)]
    assert math.isfinite(PlanDrawer().plan(plate_of(depth), lens(), endless, WIDTH).reach_m)


def test_plan_reach_ignores_a_quarter_of_the_picture_far_away():
    street = np.full((HEIGHT, WIDTH), 5.0, np.float32)
    street[: HEIGHT // 4] = 300.0
    assert PlanDrawer().plan(plate_of(street), lens(), (), WIDTH).reach_m < 20.0


def test_plan_places_a_partial_data_window_where_it_lies():
    right = plate_of(np.full((HEIGHT, WIDTH // 2), 2.0, np.float32), WIDTH // 2)
    points = PlanDrawer().plan(right, lens(), (), WIDTH).points
    assert points[:, 0].min() > 0 and points[:, 0].max() < 0.36 * 2.0


def test_plan_reads_the_depth_of_a_plate_once_for_all_lenses():
    drawer, plate = PlanDrawer(), plate_of(np.full((HEIGHT, WIDTH), 2.0, np.float32))
    for focal_length_mm in (24.0, 85.0):
        drawer.plan(plate, lens(focal_length_mm), (), WIDTH)
    assert len(plate.asked) == 1


def test_plan_of_a_tilted_focus_plane_lies_on_the_wall_in_focus():
    """A wall in the plane of focus is sharp in every point, and the plane lies on the wall."""
    tilted_lens = replace(lens(), tilt_deg=1.0, tilt_direction_deg=90.0)
    tilt = focus_offset_of(tilted_lens, (WIDTH, HEIGHT))
    wall_m = 1 / (1 / 3.0 + tilt.dioptres_at(np.arange(WIDTH) + 0.5, 0.0))
    plan = PlanDrawer().plan(plate_of(np.tile(wall_m, (HEIGHT, 1))), tilted_lens, (), WIDTH)
    np.testing.assert_allclose(1 / plan.points[:, 1] - plan.nearer, 1 / 3.0, rtol=1e-5)
    assert np.ptp(plan.points[:, 1]) > 1.0
    columns = np.linspace(0, WIDTH, len(plan.plane))[1:-1]
    wall_dioptres = np.interp(columns, np.arange(WIDTH) + 0.5, 1 / wall_m)
    np.testing.assert_allclose(1 / 3.0 + plan.plane[1:-1], wall_dioptres, rtol=1e-9)
    untilted_plan = PlanDrawer().plan(plate_of(np.tile(wall_m, (HEIGHT, 1))), lens(), (), WIDTH)
    assert not untilted_plan.nearer.any() and not untilted_plan.plane.any()
