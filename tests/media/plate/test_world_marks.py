"""Test marks at a point in the world: they keep their position while the camera moves."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import PointMark, WorldMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.mark_distance import make_world_mark, mark_on_plate_m
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, write_file
from support.plates import plate_of

LENS = Lens(focal_length_mm=50, f_stop=2, focus_distance_m=3, sensor_width_mm=36)
SIZE = 36, 64


def camera_at(x, y, z, turn=0.0):
    """Return world to camera of a camera that looks along -z, turned around its y axis."""
    c, s = np.cos(turn), np.sin(turn)
    matrix = np.array([[c, 0, -s, 0], [0, 1, 0, 0], [s, 0, c, 0], [0, 0, 0, 1.0]])
    matrix[:3, 3] = -matrix[:3, :3] @ (x, y, z)
    return matrix


def pixel_of(matrix, point):
    x, y, z = matrix[:3, :3] @ point + matrix[:3, 3]
    focal_px = 50 / 36 * SIZE[1]
    return SIZE[1] / 2 + focal_px * x / -z - 0.5, SIZE[0] / 2 - focal_px * y / -z - 0.5, -z


def plate_from(matrix, depth_m):
    height, width = SIZE
    plate = plate_of(np.ones((height, width, 3), np.float32), np.full(SIZE, depth_m, np.float32))
    return replace(plate, world_to_camera=matrix, display_window=Box(0, 0, width, height))


@pytest.mark.parametrize("point", [(0.2, 0.1, -5.0), (-0.4, 0.2, -3.0)])
def test_world_mark_has_right_distance_from_every_camera(point):
    first_camera, later_camera = camera_at(0.3, 0.1, 0.0, 0.05), camera_at(-0.5, 0.0, 1.0, -0.1)
    x, y, depth_m = pixel_of(first_camera, np.array(point))
    mark = make_world_mark(plate_from(first_camera, depth_m), PointMark("A", x, y), LENS)
    assert (mark.x_m, mark.y_m, mark.z_m) == pytest.approx(point, abs=1e-5)
    for matrix in (first_camera, later_camera):
        assert mark_on_plate_m(plate_from(matrix, 9.0), mark) == pytest.approx(
            pixel_of(matrix, np.array(point))[2], rel=1e-6
        )
    plate_behind = plate_from(camera_at(0, 0, -20.0), 9.0)
    assert mark_on_plate_m(plate_behind, mark) is None


def test_world_mark_rejects_plate_without_camera_and_sky():
    still = plate_of(np.ones((*SIZE, 3), np.float32), np.full(SIZE, 2.0, np.float32))
    with pytest.raises(InputError, match="worldToCamera"):
        mark_on_plate_m(still, WorldMark("A", 0, 0, 0))
    with pytest.raises(InputError, match="worldToCamera"):
        make_world_mark(still, PointMark("A", 3, 3), LENS)
    with pytest.raises(InputError, match="sky"):
        make_world_mark(plate_from(camera_at(0, 0, 0), np.inf), PointMark("A", 3, 3), LENS)


def test_world_mark_distance_uses_scene_unit_of_header_camera(tmp_path):
    # OpenEXR: points are rows, the camera looks along +z
    world_to_camera = (np.diag([1, 1, -1, 1]) @ camera_at(100.0, 0, 400.0)).T
    world_to_camera = np.ascontiguousarray(world_to_camera, "f4")
    depth = {"Z": np.full(SIZE, 800, "f4")}
    path = write_file(tmp_path / "p.exr", rgb(*SIZE) | depth, worldToCamera=world_to_camera)
    plate = read_plate(path, PlateOptions(scene_unit_m=0.01))
    assert mark_on_plate_m(plate, WorldMark("A", 1.0, 0.0, -1.0)) == pytest.approx(5.0)
