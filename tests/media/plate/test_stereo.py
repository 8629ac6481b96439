"""Test stereo files and radial depth by name, from the file to messages and output."""

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.media.plate.depth_read import planar_depth_m
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.read import read_plate
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file, write_parts

HEIGHT, WIDTH = 16, 24
LEFT = np.full((HEIGHT, WIDTH), 3.0, np.float32) + np.arange(WIDTH, dtype=np.float32)
EYES = {"left": LEFT, "right": 2 * LEFT}


def eye_parts():
    for view, depth in reversed(EYES.items()):
        color = {name: values + depth for name, values in rgb(HEIGHT, WIDTH, np.float32).items()}
        yield {"name": f"rgba_{view}", "view": view}, color
    for view, depth in EYES.items():
        yield {"name": f"depth_{view}", "view": view}, {"Z": depth}


@pytest.fixture
def stereo(tmp_path):
    return write_parts(tmp_path / "stereo.exr", *eye_parts())


@pytest.mark.parametrize("view", list(EYES))
def test_read_plate_of_each_eye_has_its_own_depth(stereo, view):
    plate = read_plate(stereo, PlateOptions(eye=view))
    np.testing.assert_array_equal(plate.depth_m, EYES[view])
    np.testing.assert_array_equal(
        plate.color[..., 0], rgb(HEIGHT, WIDTH, np.float32)["R"] + EYES[view]
    )
    assert plate.views == ("left", "right") and plate.attributes["view"] == view


def test_render_takes_chosen_eye_and_writes_its_name(stereo, tmp_path, capsys):
    out = tmp_path / "out.exr"
    words = ["render", stereo, "-o", out, "--f-stop", 8, "--focus-distance", 6]
    words += ["--focal-length", 50, "--method", "pyramid"]
    assert "left is taken; --eye right takes the other" in stderr_of_run(capsys, 0, *words)
    stderr = stderr_of_run(capsys, 0, *words, "--eye", "right")
    assert "is taken" not in stderr and "depth: depth_right.Z, metres" in stderr
    assert read_parts(out)[0][0]["view"] == "right"
    assert "no view 'top'" in stderr_of_run(capsys, 2, *words, "--eye", "top")


def test_info_lists_views_of_stereo_file(stereo, capsys):
    assert main(["info", str(stereo), "--eye", "right"]) == 0
    stdout = capsys.readouterr().out
    assert "views           left, right" in stdout
    assert "rgba_right of the view right" in stdout and "depth_right.Z" in stdout


def test_read_plate_converts_mitsuba_ray_distances(tmp_path):
    mitsuba = {"generatedBy": "Mitsuba version 3.9.1", **lens_attributes(36, 2, 5, 36, 24)}
    path = write_file(tmp_path / "m.exr", rgb(HEIGHT, WIDTH) | {"dd.T": LEFT}, **mitsuba)
    box = Box(0, 0, WIDTH, HEIGHT)
    plate = read_plate(path)
    assert plate.depth.kind == "radial" and any("--depth-kind planar" in n for n in plate.notes)
    np.testing.assert_allclose(plate.depth_m, planar_depth_m(LEFT, box, box, 1.0, 36, 36))
    planar = read_plate(path, PlateOptions(depth_kind="planar"))
    np.testing.assert_array_equal(planar.depth_m, LEFT)
