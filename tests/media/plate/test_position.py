"""Test depth from positions: in the world with the camera's matrix, in camera space, or refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.position import _is_pinhole_view, depth_of_positions
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, write_file
from support.plates import room

HEIGHT, WIDTH = 54, 96
DEPTH = room(WIDTH, HEIGHT)[1].astype(np.float64)
POSE = pose_looking_at((3.0, 1.5, 6.0), (0.5, 0.2, -2.0))


def camera_points(depth=DEPTH, focal=1.2):
    """Return points (H, W, 3) that a pinhole sees, along -z; 0 where nothing is hit."""
    y, x = np.mgrid[: depth.shape[0], : depth.shape[1]]
    u = (x + 0.5 - depth.shape[1] / 2) / depth.shape[1]
    v = (y + 0.5 - depth.shape[0] / 2) / depth.shape[1]
    finite = np.where(np.isfinite(depth), depth, 0.0)
    return np.stack([u / focal * finite, -v / focal * finite, -finite], axis=-1)


def positions_in_world():
    world = camera_points() @ POSE.turn.T + POSE.position_m
    return np.where(np.isfinite(DEPTH)[..., None], world, 0.0)


def world_to_camera_rows(left_handed=False):
    """Return the worldToCamera matrix for row vectors; RenderMan's camera looks along +z."""
    matrix = POSE.world_to_camera.T.copy()
    if left_handed:
        matrix[:, 2] *= -1
    return matrix.astype(np.float32)


def plate_of(tmp_path, points, names="XYZ", layer="P", options=None, **attributes):
    channels = {
        f"{layer}.{name}": np.ascontiguousarray(points[..., i], dtype=np.float32)
        for i, name in enumerate(names)
    }
    path = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | channels, **attributes)
    return read_plate(path, options)


@pytest.mark.parametrize("names", ["XYZ", "RGB", "xyz"])
@pytest.mark.parametrize("layer", ["P", "Pworld", "ViewLayer.Position"])
@pytest.mark.parametrize(
    "matrix",
    [
        world_to_camera_rows(),
        world_to_camera_rows(left_handed=True),
        np.ascontiguousarray(world_to_camera_rows().T),
    ],
)
def test_depth_of_world_positions_uses_camera_of_header(tmp_path, names, layer, matrix):
    plate = plate_of(tmp_path, positions_in_world(), names, layer, worldToCamera=matrix)
    np.testing.assert_allclose(plate.depth_m, DEPTH, rtol=1e-4)
    assert "worldToCamera" in plate.depth.why and plate.depth.kind == "planar"


def test_depth_of_camera_space_positions_needs_no_matrix(tmp_path):
    for attributes in ({}, {"worldToCamera": world_to_camera_rows()}):  # pbrt writes both
        plate = plate_of(tmp_path, camera_points(), **attributes)
        np.testing.assert_allclose(plate.depth_m, DEPTH, rtol=1e-5)
        assert "camera space" in plate.depth.why


def test_depth_of_positions_applies_scene_unit(tmp_path):
    options = PlateOptions(scene_unit_m=0.01)
    plate = plate_of(tmp_path, camera_points() * 100, options=options)
    np.testing.assert_allclose(plate.depth_m, DEPTH, rtol=1e-5)


@pytest.mark.parametrize("name", [None, "P", "P.Z", "P.B"])
def test_world_positions_without_their_camera_are_rejected(tmp_path, name):
    names = "RGB" if name == "P.B" else "XYZ"
    other_camera = pose_looking_at((9.0, 1.0, 0.0), (0.0, 0.0, 0.0)).world_to_camera.T.astype(
        np.float32
    )
    options = PlateOptions(depth_channel=name)
    with pytest.raises(InputError, match=r"positions in the world, and the header has no world"):
        plate_of(tmp_path, positions_in_world(), names, options=options)
    with pytest.raises(InputError, match=r"its worldToCamera does not belong to them"):
        plate_of(tmp_path, positions_in_world(), names, options=options, worldToCamera=other_camera)


def test_read_plate_prefers_depth_channel_over_positions(tmp_path):
    points = {f"P.{n}": positions_in_world()[..., i].astype("f4") for i, n in enumerate("XYZ")}
    z = {"Z": np.full((HEIGHT, WIDTH), 7.5, np.float32)}
    assert (
        read_plate(write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | points | z)).depth_m[0, 0]
        == 7.5
    )


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(*[st.floats(-20, 20)] * 3), st.tuples(*[st.floats(-1, 1)] * 3), st.floats(0.5, 4.0)
)
def test_depth_of_positions_is_right_for_any_camera(eye, aside, focal):
    target = np.add(eye, aside)
    if np.linalg.norm(aside) < 0.05:
        return
    pose = pose_looking_at(eye, tuple(target))
    points = camera_points(focal=focal) @ pose.turn.T + pose.position_m
    points = np.where(np.isfinite(DEPTH)[..., None], points, 0.0).astype(np.float32)
    header = {"worldToCamera": pose.world_to_camera.T}
    depth, _ = depth_of_positions("p.exr", points, "P", [header])
    np.testing.assert_allclose(depth, DEPTH, rtol=1e-3, atol=1e-3)


def test_is_pinhole_view_needs_32_hits_and_tolerates_one_percent():
    points, hit = camera_points(np.full((4, 8), 3.0)), np.ones((4, 8), bool)
    assert _is_pinhole_view(points, hit) and _is_pinhole_view(-points, hit)
    hit[2, 3] = False
    assert not _is_pinhole_view(points, hit)
    points, hit = camera_points(np.full((10, 20), 3.0)), np.ones((10, 20), bool)
    points[0, :2] *= -1  # behind the camera, and on the same ray
    assert _is_pinhole_view(points, hit)  # 99 of a hundred
    points[0, 2] *= -1
    assert not _is_pinhole_view(points, hit) and not _is_pinhole_view(-points, hit)
