"""Where a camera stands is the same in every program's way of saying it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.camera.placement import camera_to_world, check_rigid, euler_deg, matrix_of
from heatlens.media.plate.header.placement import from_exr
from support.cameras import EYE, TARGET, exr_attribute, world_to_camera

# A camera at (10, 1, 0) that looks along -x: right is -z, up is y. Rows, looking along +z.
ALONG_X = np.array([[0, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, -1, 10, 1]], np.float32)
ANGLES = st.floats(-179, 179)


def turn(axis: int, angle_deg: float) -> np.ndarray:
    """Return a right-handed turn about an axis."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[[i, j, i, j], [i, j, j, i]] = cosine, cosine, -sine, sine
    return matrix


def test_a_camera_worked_out_by_hand():
    seen, is_left_handed = from_exr(ALONG_X, 1.0)
    assert not is_left_handed
    assert seen @ (4, 1, 0, 1) == pytest.approx((0, 0, -6, 1))  # six metres in front
    assert seen @ (10, 3, 0, 1) == pytest.approx((0, 2, 0, 1))  # above
    assert seen @ (10, 1, -5, 1) == pytest.approx((5, 0, 0, 1))  # to the right


def test_the_attribute_is_the_camera_of_its_axes():
    seen, _ = from_exr(exr_attribute(EYE, TARGET), 1.0)
    assert seen == pytest.approx(np.array(world_to_camera(EYE, TARGET)), abs=1e-6)


def test_a_world_in_centimetres_comes_out_in_metres():
    centimetres = exr_attribute(np.multiply(EYE, 100), np.multiply(TARGET, 100))
    seen, _ = from_exr(centimetres, 0.01)
    assert seen == pytest.approx(np.array(world_to_camera(EYE, TARGET)), abs=1e-6)


def test_a_left_handed_world_is_seen_with_its_z_turned_round():
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    seen, is_left_handed = from_exr(mirror @ ALONG_X, 1.0)
    assert is_left_handed
    assert seen == pytest.approx(from_exr(ALONG_X, 1.0)[0])


@given(st.lists(st.floats(-5, 5), min_size=3, max_size=3))
def test_a_point_is_seen_at_the_same_place(point):
    """x and y alike, the depth forward in one and backward in the other."""
    attribute = exr_attribute(EYE, TARGET).astype(np.float64)
    x, y, z, _ = np.array([*point, 1.0]) @ attribute
    assert from_exr(attribute, 1.0)[0] @ [*point, 1.0] == pytest.approx((x, y, -z, 1.0), abs=1e-9)


def test_the_world_is_turned_so_that_another_axis_is_up():
    matrices = [matrix_of(from_exr(ALONG_X, 1.0)[0])]
    for up, other in ("yz", "zy"):
        assert camera_to_world(matrices, up, up) == pytest.approx(np.linalg.inv(matrices))
        assert camera_to_world(matrices, up, other)[0, :3, 3] == pytest.approx(
            (10, 0, 1) if up == "y" else (10, 0, -1)
        )


@given(ANGLES, st.floats(-89, 89), ANGLES)
def test_angles_are_those_that_make_the_turn(first, second, third):
    for order in ("XYZ", "ZXY"):
        a, b, c = ("XYZ".index(letter) for letter in order)
        made = turn(c, third) @ turn(b, second) @ turn(a, first)
        found = euler_deg(made[None], order)[0]
        assert found[[a, b, c]] == pytest.approx((first, second, third), abs=1e-6)


@pytest.mark.parametrize("order", ["XYZ", "ZXY"])
@pytest.mark.parametrize("locked", [90.0, -90.0])
def test_angles_make_the_turn_where_two_axes_are_one(order, locked):
    a, b, c = ("XYZ".index(letter) for letter in order)
    made = turn(c, 20) @ turn(b, locked) @ turn(a, 35)
    found = euler_deg(made[None], order)[0]
    again = turn(c, found[c]) @ turn(b, found[b]) @ turn(a, found[a])
    assert again == pytest.approx(made, abs=1e-9)


def test_angles_do_not_jump_from_frame_to_frame():
    """A camera that turns round twice."""
    turns = np.array([turn(1, angle) for angle in range(0, 720, 45)])
    assert euler_deg(turns, "ZXY")[:, 1] == pytest.approx(np.arange(0, 720, 45), abs=1e-9)


@pytest.mark.parametrize(
    "broken",
    [
        2 * np.eye(4),
        np.diag([1.0, 1.0, -1.0, 1.0]),
        np.diag([1.0, 0.0, 1.0, 1.0]),
        np.full((4, 4), np.nan),
        np.eye(4) + 0.1 * np.eye(4, k=1),
        np.eye(4) * 1e200,
    ],
)
def test_what_is_no_place_of_a_camera_is_refused_with_its_frame(broken):
    good = matrix_of(np.eye(4))
    with pytest.raises(InputError, match=r"Frame 8: the placement cannot be a camera's"):
        check_rigid([good, matrix_of(broken)], [7, 8])
    with pytest.raises(InputError, match="four rows of four numbers"):
        matrix_of(np.eye(3))
