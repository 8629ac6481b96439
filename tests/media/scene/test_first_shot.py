"""Test that a scene starts as the same shot in window, render, export and shot file."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.scene_bounds import corners_m, frame_points, object_depth_m, track_of
from support.command_line import picture, render
from support.exports import export_shot
from support.gltf_files import GltfWriter

LENS = ("--f-stop", "2", "--focus-distance", "3")
TINY = ("--size", "24x16")


def write_scene(path, *cameras: tuple[str, float]):
    """Write a square at the origin and cameras 3 m before it, each with its vertical angle."""
    writer = GltfWriter()
    writer.node(name="square", mesh=writer.mesh())
    for name, angle in cameras:
        perspective = {"yfov": angle, "znear": 0.1, "aspectRatio": 1.5}
        camera = writer.add("cameras", type="perspective", perspective=perspective, name=name)
        writer.node(name=name, camera=camera, translation=[0.5, 0.5, 3.0])
    return writer.write(path)


@pytest.fixture
def bare(tmp_path):
    return write_scene(tmp_path / "bare.glb")


@pytest.fixture
def filmed(tmp_path):
    return write_scene(tmp_path / "filmed.glb", ("main", 0.7), ("tight", 0.4))


def new_shot(tmp_path, scene, *words: str):
    path = tmp_path / "s.heatlens.json"
    assert main(["shot", "new", str(scene), "-o", str(path), "--overwrite", *words]) == 0
    return read_shot(path)


@pytest.mark.parametrize("name", ["bare", "filmed"])
def test_new_shot_file_equals_first_shot_of_window(request, tmp_path, name):
    scene = request.getfixturevalue(name)
    shot, window = new_shot(tmp_path, scene, *LENS), first_shot(str(scene)).shot
    assert replace(shot, lens=window.lens) == window
    assert replace(shot.lens, focus_distance_m=window.lens.focus_distance_m) == window.lens


@pytest.mark.parametrize("words", [(), ("--scene-camera", "tight"), ("--squeeze", "1.5")])
def test_render_and_export_of_scene_give_same_image(capsys, filmed, tmp_path, words):
    options = (*TINY, *LENS, *words, "--quality", "draft", "--float")
    stderr = render(capsys, filmed, tmp_path / "a.exr", *options)
    assert export_shot(capsys, filmed, tmp_path / "b.exr", *options).splitlines()[0] in stderr
    np.testing.assert_array_equal(picture(tmp_path / "a.exr")[1], picture(tmp_path / "b.exr")[1])


def test_render_and_export_of_demo_give_same_image(capsys, tmp_path, small_demo):
    options = ("--size", "24x16", "--quality", "draft", "--float")
    render(capsys, "demo", tmp_path / "a.exr", *options)
    export_shot(capsys, "demo", tmp_path / "b.exr", *options)
    np.testing.assert_array_equal(picture(tmp_path / "a.exr")[1], picture(tmp_path / "b.exr")[1])


def test_first_shot_without_focus_focuses_on_middle_and_marks_it_assumed(filmed):
    first = first_shot(str(filmed))
    pose = track_of(first.scene, first.shot.framing, first.shot.lens).pose_at(1)
    middle_m = object_depth_m(first.scene, "square", pose, 1)
    assert first.shot.lens.focus_distance_m == pytest.approx(middle_m)
    assert first.assumed == {"f_stop", "focus_distance_m"}
    given_shot = first_shot(str(filmed), given_fields={"f_stop": 4.0, "focus_distance_m": 2.0})
    assert given_shot.assumed == frozenset() and given_shot.shot.lens.focus_distance_m == 2.0


def test_render_and_export_report_source_of_each_lens_value(capsys, bare, filmed, tmp_path):
    """`render` and `export` print the same sentence."""
    for scene, angle in ((bare, "assumed: the scene has no camera"), (filmed, "camera main of")):
        for command in ("render", "export"):
            words = (*TINY, *LENS, "--quality", "draft", "--verbose")
            out = tmp_path / f"{command}.exr"
            assert main([command, str(scene), "-o", str(out), *words]) == 0
            stderr = capsys.readouterr().err
            assert "lens at frame 1: " in stderr and f"mm ({angle}" in stderr
            assert "f/2 (--f-stop), focus 3 m (--focus-distance)" in stderr
            assert "header" not in stderr


def test_first_shot_treats_squeeze_of_one_as_given(filmed):
    assert first_shot(str(filmed), given_fields={"squeeze": 1.0}).sources["squeeze"] == "given"


def test_render_focus_at_pixel_sets_distance_of_visible_surface(capsys, bare, filmed, tmp_path):
    out = tmp_path / "o.exr"
    stderr = render(capsys, filmed, out, *TINY, "--f-stop", "2", "--focus-at", "12,8")
    assert "f/2, focus 3 m, sensor width 36 mm (assumed" in stderr
    assert picture(out)[0]["focus"] == pytest.approx(3.0, abs=1e-4)


def test_pinhole_render_needs_no_lens(capsys, bare, tmp_path):
    for write, name in ((render, "a.exr"), (export_shot, "b.exr")):
        stderr = write(capsys, bare, tmp_path / name, *TINY, "--pinhole", "--float", "-v")
        assert "f/2 (assumed: the scene has none)" in stderr
    np.testing.assert_array_equal(picture(tmp_path / "a.exr")[1], picture(tmp_path / "b.exr")[1])


def write_street(folder, size_m: float):
    """Write ten squares of 1 m, one behind the other over `size_m`, and a floor."""
    writer = GltfWriter()
    mesh = writer.mesh()
    for number in range(10):
        at = [0.2 * number, 0.0, -size_m * number / 9]
        writer.node(name=f"square {number}", mesh=mesh, translation=at)
    writer.node(name="floor", mesh=mesh, scale=[size_m, 0.001, size_m])
    return writer.write(folder / "street.glb")


def test_first_shot_of_large_scene_is_placed_where_blur_is_visible(tmp_path):
    first = first_shot(str(write_street(tmp_path, 15.0)))
    shot, scene = first.shot, first.scene
    pose = track_of(scene, shot.framing, shot.lens).pose_at(1)
    near_m, far_m = (object_depth_m(scene, f"square {n}", pose, 1) for n in (0, 9))
    assert shot.lens.focus_distance_m == pytest.approx(near_m)
    line = coc_line(shot.lens, 1000)
    assert abs(line.at_infinity_px + line.per_dioptre_px / far_m) > 6  # seen whole it is 0.3


def test_first_shot_of_small_scene_shows_all_of_it(tmp_path):
    first = first_shot(str(write_street(tmp_path, 3.0)))
    pose = track_of(first.scene, first.shot.framing, first.shot.lens).pose_at(1)
    expected_pose = frame_points(corners_m(first.scene, 1), first.shot.lens, 1280 / 720)
    assert pose == expected_pose
