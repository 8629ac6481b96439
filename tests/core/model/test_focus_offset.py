"""Compare the tilted focus plane with rays through an exact tilted thin lens to the sensor."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import coc_line, coc_px, focus_offset_coc_px
from heatlens.core.model.focus.focus_offset import LEVEL, focus_offset_of
from heatlens.core.model.lens.lens import Lens, LensModel

SIZE = (1920, 1080)
LENSES = st.builds(
    Lens,
    st.floats(17, 135),
    st.floats(1.4, 16),
    st.floats(0.8, 50),
    st.just(36.0),
    tilt_deg=st.floats(-12, 12),
    tilt_direction_deg=st.floats(-360, 360),
)
POSITIONS = st.tuples(st.floats(0, SIZE[0]), st.floats(0, SIZE[1]))


def axis_of(lens: Lens) -> np.ndarray:
    """Return the axis of the tilted lens: x to the right, y up, z in front."""
    angle, turn = math.radians(lens.tilt_deg), math.radians(lens.tilt_direction_deg - 90.0)
    sine = math.sin(angle)
    return np.array([sine * math.cos(turn), sine * math.sin(turn), math.cos(angle)])


def tangents_of(lens: Lens, position_px: tuple[float, float]) -> np.ndarray:
    focal_px = SIZE[0] * lens.focal_length_mm / lens.sensor_width_mm
    return np.array([position_px[0] - SIZE[0] / 2, SIZE[1] / 2 - position_px[1]]) / focal_px


def image_of(lens: Lens, point_m: np.ndarray) -> np.ndarray:
    """Return the image point of `point_m` by an ideal tilted lens centered at the origin."""
    along = axis_of(lens) @ point_m
    return point_m / (1 - along / (1e-3 * lens.focal_length_mm))


@given(LENSES, POSITIONS)
def test_points_on_tilted_focus_plane_are_sharp_on_sensor(lens, position_px):
    tangents, focus_offset = tangents_of(lens, position_px), focus_offset_of(lens, SIZE)
    dioptres = 1 / lens.focus_distance_m + float(focus_offset.dioptres_at(*position_px))
    # The sensor is where the middle of the picture is sharp. A plane behind the camera counts too.
    sensor_m = image_of(lens, np.array([0, 0, lens.focus_distance_m]))[2]
    if abs(dioptres) > 1e-3:
        focused = image_of(lens, np.array([*tangents, 1.0]) / dioptres)
        assert focused[2] == pytest.approx(sensor_m, rel=1e-6)


def test_tilted_focus_planes_meet_hinge_line_below_lens():
    """For 50 mm and 5 degrees the hinge line is 57.4 cm below the lens, at any focus distance."""
    for focus_m in (1.0, 3.0, 40.0):
        lens = Lens(50.0, 4.0, focus_m, 36.0, tilt_deg=5.0)
        focus_offset = focus_offset_of(lens, SIZE)
        column = np.array([[*tangents_of(lens, (960, y)), 1.0] for y in (540.0, 800.0)])
        dioptres = 1 / focus_m + focus_offset.dioptres_at(960, np.array([540.0, 800.0]))
        first, second = column / dioptres[:, None]
        below_m = first[1] - first[2] * (second[1] - first[1]) / (second[2] - first[2])
        assert below_m == pytest.approx(-0.05 / math.sin(math.radians(5)), rel=1e-9)


@given(LENSES, POSITIONS, st.floats(0.5, 30))
def test_disc_diameter_matches_rays_through_tilted_lens(lens, position_px, depth_m):
    """Compare the disc's width along the tilt axis, which the tilt does not foreshorten."""
    lens = replace(lens, model=LensModel.PHOTOGRAPHIC)
    line = replace(coc_line(lens, SIZE[0]), focus_offset=focus_offset_of(lens, SIZE))
    tilt_px = line.focus_offset.dioptres_at(*position_px) * -line.per_dioptre_px
    expected = float(coc_px(depth_m, line)) + float(tilt_px)
    point = np.array([*tangents_of(lens, position_px), 1.0]) * depth_m
    sensor_m = image_of(lens, np.array([0, 0, lens.focus_distance_m]))[2]
    image = image_of(lens, point)
    turn = math.radians(lens.tilt_direction_deg)
    lens_edge = 0.5e-3 * lens.aperture_diameter_mm * np.array([math.cos(turn), math.sin(turn), 0.0])
    hits = [start + (image - start) * sensor_m / image[2] for start in (lens_edge, -lens_edge)]
    across_m = float(
        (hits[1] - hits[0]) @ lens_edge / np.linalg.norm(lens_edge)
    )  # the image is inverted
    across_px = across_m * 1e3 / lens.sensor_width_mm * SIZE[0]
    # The image distance differs by the cosine of the tilt: by 2.2 % at 12 degrees, times that over
    # the focal length of a close focus.
    assert across_px == pytest.approx(expected, rel=0.05, abs=1e-6 * abs(line.per_dioptre_px))


@given(
    LENSES, st.floats(-5, 5), st.floats(0.1, 4), st.tuples(st.integers(0, 99), st.integers(0, 99))
)
def test_focus_tilt_is_unchanged_by_moving_and_scaling_pixels(lens, split, scale, moved):
    lens = replace(lens, split_dioptres=split, split_position=0.3, split_direction_deg=20.0)
    focus_offset, (x, y) = focus_offset_of(lens, SIZE), (300.0, 700.0)
    scaled_tilt = focus_offset.moved(moved).scaled(scale)
    scaled_position = (x + moved[0]) * scale, (y + moved[1]) * scale
    np.testing.assert_allclose(
        scaled_tilt.dioptres_at(*scaled_position), focus_offset.dioptres_at(x, y), atol=1e-9
    )
    least, most = focus_offset.dioptre_limits(Box(0, 0, *SIZE))
    assert least - 1e-9 <= float(focus_offset.dioptres_at(x, y)) <= most + 1e-9


def test_split_focus_has_two_distances_and_soft_edge():
    lens = Lens(50.0, 2.8, 4.0, 36.0, split_dioptres=1.0, split_position=0.5, split_softness=0.1)
    distances_m = 1 / (
        1 / 4.0
        + focus_offset_of(lens, SIZE).dioptres_at(np.array([0, 1343, 1440, 1537, 1920]), 9.0)
    )
    np.testing.assert_allclose(distances_m, [4.0, 4.0, 1 / 0.75, 0.8, 0.8], rtol=1e-3)
    above = replace(lens, split_direction_deg=90.0, split_position=0.0)
    assert float(focus_offset_of(above, SIZE).dioptres_at(5, 0)) == 1.0
    assert float(focus_offset_of(above, SIZE).dioptres_at(5, 1080)) == 0.0


@given(st.floats(-180.0, 180.0), st.floats(-0.9, 0.9))
def test_split_position_is_counted_from_the_middle_towards_the_glass(direction_deg, position):
    """The edge, where half of the split counts, lies on the side of the glass for positions > 0."""
    lens = Lens(50.0, 2.8, 4.0, 36.0, split_dioptres=1.0, split_softness=0.1)
    lens = replace(lens, split_position=position, split_direction_deg=direction_deg)
    angle, reach_px = np.radians(direction_deg), position * SIZE[0] / 2
    edge = SIZE[0] / 2 + reach_px * np.cos(angle), SIZE[1] / 2 - reach_px * np.sin(angle)
    assert float(focus_offset_of(lens, SIZE).dioptres_at(*edge)) == pytest.approx(0.5, abs=1e-6)
    glass = edge[0] + SIZE[0] * np.cos(angle), edge[1] - SIZE[0] * np.sin(angle)
    assert float(focus_offset_of(lens, SIZE).dioptres_at(*glass)) == pytest.approx(1.0)


@pytest.mark.parametrize("split", [1.5, -0.2])
def test_ends_of_split_focus_are_its_two_sides(split):
    lens = Lens(50.0, 2.8, 4.0, 36.0, split_dioptres=split, split_position=0.5, split_softness=0.1)
    focus_offset = focus_offset_of(lens, SIZE)
    sides = sorted(float(focus_offset.dioptres_at(x, 9.0)) for x in (0, SIZE[0]))
    assert focus_offset.dioptre_limits(Box(0, 0, *SIZE)) == pytest.approx(sides)


def test_focus_tilt_accounts_for_pixel_aspect():
    lens = Lens(50.0, 2.8, 4.0, 36.0, tilt_deg=4.0, tilt_direction_deg=33.0)
    square, wide = focus_offset_of(lens, (200, 100)), focus_offset_of(lens, (100, 100), 2.0)
    np.testing.assert_allclose(wide.dioptres_at(30, 20), square.dioptres_at(60, 20), rtol=1e-9)


def test_lens_without_tilt_and_split_has_level_focus():
    lens = Lens(50.0, 2.8, 4.0, 36.0, tilt_direction_deg=90.0, split_position=0.5)
    assert focus_offset_of(lens, SIZE) == LEVEL and LEVEL.is_level and LEVEL.is_plane
    assert focus_offset_coc_px(coc_line(lens, 1920), Box(0, 0, 4, 4)) == 0.0
    assert lens.aperture.is_plain
    assert replace(lens, tilt_deg=3.0, split_dioptres=1.0).aperture.is_plain


def test_split_focus_is_no_plane_and_a_leaning_plane_is_not_level():
    lens = Lens(50.0, 2.8, 4.0, 36.0)
    split = focus_offset_of(replace(lens, split_dioptres=-0.5), SIZE)
    tilted = focus_offset_of(replace(lens, tilt_deg=3.0), SIZE)
    assert (split.is_level, split.is_plane) == (False, False)
    assert (tilted.is_level, tilted.is_plane) == (False, True)
