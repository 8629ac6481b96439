"""The plan: what lies in front of the camera, from above, in metres."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import lean_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.studio.session.marks.plan import PlanDrawer

WIDTH, HEIGHT = 96, 40


def plate_of(depth: np.ndarray, x0: int = 0) -> SimpleNamespace:
    """Return what the plan asks of a plate whose data begin at column `x0` of the picture."""
    height, width = depth.shape
    asked: list[Box] = []

    def depth_in(box: Box) -> np.ndarray:
        asked.append(box)
        return depth[box.y0 : box.y1, box.x0 : box.x1]

    return SimpleNamespace(
        pixels=SimpleNamespace(depth_in=depth_in),
        data_window=Box(x0, 0, x0 + width, height),
        display_window=Box(0, 0, WIDTH, HEIGHT),
        pixel_aspect_ratio=1.0,
        asked=asked,
    )


def lens(focal_length_mm: float = 50.0) -> Lens:
    return Lens(focal_length_mm, 2.0, 3.0, sensor_width_mm=36.0)


@given(st.floats(0.5, 80.0), st.floats(14.0, 200.0))
def test_a_wall_is_as_wide_as_the_lens_sees_at_its_distance(distance_m, focal_length_mm):
    wall = np.full((HEIGHT, WIDTH), distance_m, np.float32)
    plan = PlanDrawer().plan(plate_of(wall), lens(focal_length_mm), (), WIDTH)
    seen_m = 36.0 / focal_length_mm * distance_m
    assert plan.points[:, 1] == pytest.approx(distance_m, rel=1e-6)
    assert np.ptp(plan.points[:, 0]) == pytest.approx(seen_m * (WIDTH - 1) / WIDTH, rel=1e-4)
    assert plan.points[:, 0].mean() == pytest.approx(0.0, abs=1e-4 * seen_m)
    assert plan.reach_m > distance_m


def test_a_mark_lies_on_the_surface_that_is_seen_at_its_point():
    slope = np.tile(np.linspace(2.0, 5.0, WIDTH, dtype=np.float32), (HEIGHT, 1))
    marks = [(PointMark("A", 60.0, 9.0), float(slope[0, 60])), (DistanceMark("B", 4.0), 4.0)]
    plan = PlanDrawer().plan(plate_of(slope), lens(), marks, WIDTH)
    a, b = plan.marks
    nearest = np.abs(plan.points - np.float32([a.side_m, a.distance_m])).max(axis=1).min()
    assert nearest < 1e-4 and not a.is_movable
    assert (b.side_m, b.distance_m, b.is_movable) == (0.0, 4.0, True)


def test_the_sky_is_no_surface_and_a_far_mark_makes_room():
    depth = np.full((HEIGHT, WIDTH), math.inf, np.float32)
    plan = PlanDrawer().plan(plate_of(depth), lens(), [(DistanceMark("A", 30.0), 30.0)], WIDTH)
    assert len(plan.points) == 0 and plan.reach_m > 30.0
    endless = [(DistanceMark("A", math.inf), math.inf)]
    assert math.isfinite(PlanDrawer().plan(plate_of(depth), lens(), endless, WIDTH).reach_m)


def test_the_end_of_a_long_street_leaves_the_actors_their_room():
    street = np.full((HEIGHT, WIDTH), 5.0, np.float32)
    street[: HEIGHT // 4] = 300.0
    assert PlanDrawer().plan(plate_of(street), lens(), (), WIDTH).reach_m < 20.0


def test_data_that_do_not_fill_the_picture_lie_where_they_are_seen():
    right = plate_of(np.full((HEIGHT, WIDTH // 2), 2.0, np.float32), WIDTH // 2)
    points = PlanDrawer().plan(right, lens(), (), WIDTH).points
    assert points[:, 0].min() > 0 and points[:, 0].max() < 0.36 * 2.0


def test_a_plate_is_looked_at_once_whatever_the_lens():
    drawer, plate = PlanDrawer(), plate_of(np.full((HEIGHT, WIDTH), 2.0, np.float32))
    for focal_length_mm in (24.0, 85.0):
        drawer.plan(plate, lens(focal_length_mm), (), WIDTH)
    assert len(plate.asked) == 1


def test_a_swung_plane_of_focus_leans_on_the_plan_and_lights_what_lies_in_it():
    """A wall in the plane of focus is sharp in every point, and the plane lies on the wall."""
    leaning = replace(lens(), tilt_deg=1.0, tilt_direction_deg=90.0)
    lean = lean_of(leaning, (WIDTH, HEIGHT))
    wall_m = 1 / (1 / 3.0 + lean.dioptres_at(np.arange(WIDTH) + 0.5, 0.0))
    plan = PlanDrawer().plan(plate_of(np.tile(wall_m, (HEIGHT, 1))), leaning, (), WIDTH)
    np.testing.assert_allclose(1 / plan.points[:, 1] - plan.nearer, 1 / 3.0, rtol=1e-5)
    assert np.ptp(plan.points[:, 1]) > 1.0
    columns = np.linspace(0, WIDTH, len(plan.plane))[1:-1]
    seen = np.interp(columns, np.arange(WIDTH) + 0.5, 1 / wall_m)
    np.testing.assert_allclose(1 / 3.0 + plan.plane[1:-1], seen, rtol=1e-9)
    level = PlanDrawer().plan(plate_of(np.tile(wall_m, (HEIGHT, 1))), lens(), (), WIDTH)
    assert not level.nearer.any() and not level.plane.any()
