"""Fixtures: a shot whose second half is in another unit, and a scheduler without workers."""

import numpy as np
import pytest

from heatlens.media.documents.shot_file import write_shot
from support.dask_cluster import dask_cluster
from support.exports import CAMERA, FRAMES, shot_of
from support.exr_files import write_file
from support.plates import room


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """Start a scheduler of Dask without workers, for the tests of a file."""
    with dask_cluster(tmp_path_factory.mktemp("scheduler"), workers=0) as cluster:
        yield cluster


@pytest.fixture
def mixed_plates(tmp_path):
    (tmp_path / "mixed").mkdir()
    color, depth_m = room(32, 18)
    for frame in FRAMES:
        channels = {name: np.ascontiguousarray(color[..., i]) for i, name in enumerate("RGB")}
        unit = 100.0 if frame > 1003 else 1.0
        path = tmp_path / "mixed" / f"plate.{frame}.exr"
        write_file(path, channels | {"Z": np.float32(unit) * depth_m}, **CAMERA)
    shot = tmp_path / "mixed.heatlens.json"
    write_shot(shot, shot_of(str(tmp_path / "mixed" / "plate.####.exr")))
    return shot
