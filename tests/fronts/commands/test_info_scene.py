"""`heatlens info` and `heatlens camera` of a 3D scene."""

import csv
import json

import numpy as np
import pytest

from heatlens.fronts.commands.main import main
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.scene_bounds import track_of
from support.gltf_files import GltfWriter


@pytest.fixture
def scene(tmp_path):
    """Write a static scene of two squares and a camera. Return its path."""
    writer = GltfWriter()
    mesh = writer.mesh()
    writer.node(name="near", mesh=mesh, translation=[-1.0, 0.0, 0.0])
    writer.node(name="far", mesh=mesh, translation=[0.0, 0.0, -4.0])
    perspective = {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}
    camera = writer.add("cameras", type="perspective", perspective=perspective, name="main")
    writer.node(name="main", camera=camera, translation=[0.0, 0.5, 3.0])
    return writer.write(tmp_path / "scene.glb")


def run_info(capsys, *words: object) -> str:
    assert main(["info", *map(str, words)]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def refused(capsys, *words: object) -> str:
    assert main([*map(str, words)]) == 2
    return capsys.readouterr().err


def test_info_lists_objects_triangles_and_cameras_of_scene(capsys, scene):
    facts = json.loads(run_info(capsys, scene, "--json"))
    opened = first_shot(str(scene)).scene
    assert facts["objects"] == ["near", "far"]
    assert facts["triangles"] == opened.triangle_count == 4
    assert [camera["name"] for camera in facts["cameras"]] == ["main"]
    assert facts["frames"] is None and facts["path"] == str(scene)
    assert facts["size_m"][2] == pytest.approx(4.0)
    text = run_info(capsys, scene)
    assert "nothing moves" in text and "2: near, far" in text and "main, focal length" in text


def test_info_of_demo_gives_frames_and_camera(capsys):
    facts = json.loads(run_info(capsys, "demo", "--json"))
    assert facts["frames"] == {"first": 1, "last": 240} and facts["frames_per_second"] == 24
    assert facts["cameras"][0] == {
        "name": "dolly",
        "focal_length_mm": 50.0,
        "sensor_width_mm": 36.0,
        "sensor_width_assumed": False,
        "moves": True,
    }
    text = run_info(capsys, "demo")
    assert "1 to 240, 24 per second" in text and "lamps" in text and "more" in text


def test_info_of_scene_rejects_depth_options(capsys, scene):
    assert "--depth-convention" in refused(capsys, "info", scene, "--depth-convention", "auto")
    assert "--focal-length" in refused(capsys, "info", scene, "--focal-length", "50")


def test_camera_command_writes_lens_and_pose_of_first_shot_of_scene(capsys, scene, tmp_path):
    out = tmp_path / "c.csv"
    assert main(["camera", str(scene), "-o", str(out)]) == 0
    message = capsys.readouterr().err
    assert (
        "f/2 (assumed: the scene has none)" in message and "assumed: the scene has none" in message
    )
    row = next(csv.DictReader(line for line in out.read_text().splitlines() if line[0] != "#"))
    opened = first_shot(str(scene))
    assert float(row["focal_length_mm"]) == pytest.approx(opened.shot.lens.focal_length_mm)
    assert float(row["focus_distance_m"]) == pytest.approx(opened.shot.lens.focus_distance_m)
    pose = track_of(opened.scene, opened.shot.framing, opened.shot.lens).pose_at(1)
    assert np.allclose(pose.position_m, (0.0, 0.5, 3.0), atol=1e-6)


def test_camera_of_demo_has_changing_focus(tmp_path):
    out = tmp_path / "c.json"
    assert main(["camera", "demo", "-o", str(out), "--frames", "70-90"]) == 0
    samples = json.loads(out.read_text())["samples"]
    assert len(samples) == 21
    assert len({sample["focus_distance_m"] for sample in samples}) > 10


@pytest.mark.parametrize("words", [("--scene-unit", "cm"), ("--up-axis", "y")])
def test_camera_command_for_scene_rejects_unit_and_up_axis(capsys, scene, tmp_path, words):
    message = refused(capsys, "camera", scene, "-o", tmp_path / "c.nk", *words)
    assert "in metres and y up" in message and f"leave {words[0]} out" in message
    assert not (tmp_path / "c.nk").exists()
