"""Test that a camera's placement is the same in the convention of every program."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.camera.placement import camera_to_world, check_rigid, euler_deg, matrix_of
from heatlens.media.plate.header.placement import convert_from_exr
from support.cameras import EYE, TARGET, exr_attribute, world_to_camera

# A camera at (10, 1, 0) that looks along -x: right is -z, up is y. Rows, looking along +z.
ALONG_X = np.array([[0, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, -1, 10, 1]], np.float32)
ANGLES = st.floats(-179, 179)


def axis_rotation(axis: int, angle_deg: float) -> np.ndarray:
    """Return a right-handed rotation about an axis."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[[i, j, i, j], [i, j, j, i]] = cosine, cosine, -sine, sine
    return matrix


def test_convert_from_exr_gives_camera_computed_by_hand():
    to_camera, is_left_handed = convert_from_exr(ALONG_X, 1.0)
    assert not is_left_handed
    assert to_camera @ (4, 1, 0, 1) == pytest.approx((0, 0, -6, 1))  # six metres in front
    assert to_camera @ (10, 3, 0, 1) == pytest.approx((0, 2, 0, 1))  # above
    assert to_camera @ (10, 1, -5, 1) == pytest.approx((5, 0, 0, 1))  # to the right


def test_convert_from_exr_of_attribute_is_world_to_camera():
    to_camera, _ = convert_from_exr(exr_attribute(EYE, TARGET), 1.0)
    assert to_camera == pytest.approx(np.array(world_to_camera(EYE, TARGET)), abs=1e-6)


def test_convert_from_exr_changes_centimeters_to_meters():
    centimetres = exr_attribute(np.multiply(EYE, 100), np.multiply(TARGET, 100))
    to_camera, _ = convert_from_exr(centimetres, 0.01)
    assert to_camera == pytest.approx(np.array(world_to_camera(EYE, TARGET)), abs=1e-6)


def test_convert_from_exr_mirrors_z_of_left_handed_world():
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    to_camera, is_left_handed = convert_from_exr(mirror @ ALONG_X, 1.0)
    assert is_left_handed
    assert to_camera == pytest.approx(convert_from_exr(ALONG_X, 1.0)[0])


@given(st.lists(st.floats(-5, 5), min_size=3, max_size=3))
def test_convert_from_exr_keeps_camera_coordinates_of_points(point):
    """x and y are the same; the depth is forward in one convention and backward in the other."""
    attribute = exr_attribute(EYE, TARGET).astype(np.float64)
    x, y, z, _ = np.array([*point, 1.0]) @ attribute
    assert convert_from_exr(attribute, 1.0)[0] @ [*point, 1.0] == pytest.approx(
        (x, y, -z, 1.0), abs=1e-9
    )


def test_camera_to_world_converts_between_y_up_and_z_up():
    matrices = [matrix_of(convert_from_exr(ALONG_X, 1.0)[0])]
    for up, other_up in ("yz", "zy"):
        assert camera_to_world(matrices, up, up) == pytest.approx(np.linalg.inv(matrices))
        assert camera_to_world(matrices, up, other_up)[0, :3, 3] == pytest.approx(
            (10, 0, 1) if up == "y" else (10, 0, -1)
        )


@given(ANGLES, st.floats(-89, 89), ANGLES)
def test_euler_deg_recovers_angles_of_rotation(first, second, third):
    for order in ("XYZ", "ZXY"):
        a, b, c = ("XYZ".index(letter) for letter in order)
        rotation = axis_rotation(c, third) @ axis_rotation(b, second) @ axis_rotation(a, first)
        angles = euler_deg(rotation[None], order)[0]
        assert angles[[a, b, c]] == pytest.approx((first, second, third), abs=1e-6)


@pytest.mark.parametrize("order", ["XYZ", "ZXY"])
@pytest.mark.parametrize("locked", [90.0, -90.0])
def test_euler_deg_reproduces_rotation_at_gimbal_lock(order, locked):
    a, b, c = ("XYZ".index(letter) for letter in order)
    rotation = axis_rotation(c, 20) @ axis_rotation(b, locked) @ axis_rotation(a, 35)
    angles = euler_deg(rotation[None], order)[0]
    rebuilt = (
        axis_rotation(c, angles[c]) @ axis_rotation(b, angles[b]) @ axis_rotation(a, angles[a])
    )
    assert rebuilt == pytest.approx(rotation, abs=1e-9)


def test_euler_deg_is_continuous_from_frame_to_frame():
    """The camera turns around twice."""
    rotations = np.array([axis_rotation(1, angle) for angle in range(0, 720, 45)])
    assert euler_deg(rotations, "ZXY")[:, 1] == pytest.approx(np.arange(0, 720, 45), abs=1e-9)


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
def test_check_rigid_rejects_impossible_placement_with_its_frame(broken):
    good = matrix_of(np.eye(4))
    with pytest.raises(InputError, match=r"Frame 8: the matrix that places the camera"):
        check_rigid([good, matrix_of(broken)], [7, 8])
    with pytest.raises(InputError, match="four rows of four numbers"):
        matrix_of(np.eye(3))
