"""One scene begins as one shot, whoever opens it: window, render, export and a shot file."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.scene_bounds import corners_m, framed, object_depth_m, track_of
from support.command_line import picture, render
from support.exports import exported
from support.gltf_files import GltfWriter

LENS = ("--f-stop", "2", "--focus-distance", "3")
TINY = ("--size", "24x16")


def write_scene(path, *cameras: tuple[str, float]):
    """Return a square at the origin, and cameras 3 m before it; each with its vertical angle."""
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
def test_a_shot_file_begins_as_the_window_does(request, tmp_path, name):
    scene = request.getfixturevalue(name)
    shot, window = new_shot(tmp_path, scene, *LENS), first_shot(str(scene)).shot
    assert replace(shot, lens=window.lens) == window
    assert replace(shot.lens, focus_distance_m=window.lens.focus_distance_m) == window.lens


@pytest.mark.parametrize("words", [(), ("--scene-camera", "tight"), ("--squeeze", "1.5")])
def test_render_and_export_make_one_picture(capsys, filmed, tmp_path, words):
    given = (*TINY, *LENS, *words, "--quality", "draft", "--float")
    said = render(capsys, filmed, tmp_path / "a.exr", *given)
    assert exported(capsys, filmed, tmp_path / "b.exr", *given).splitlines()[0] in said
    np.testing.assert_array_equal(picture(tmp_path / "a.exr")[1], picture(tmp_path / "b.exr")[1])


def test_the_demo_is_rendered_as_it_is_exported(capsys, tmp_path, small_demo):
    given = ("--size", "24x16", "--quality", "draft", "--float")
    render(capsys, "demo", tmp_path / "a.exr", *given)
    exported(capsys, "demo", tmp_path / "b.exr", *given)
    np.testing.assert_array_equal(picture(tmp_path / "a.exr")[1], picture(tmp_path / "b.exr")[1])


def test_focus_that_nobody_tells_is_the_middle_and_known_as_assumed(filmed):
    first = first_shot(str(filmed))
    pose = track_of(first.scene, first.shot.framing, first.shot.lens).pose_at(1)
    middle_m = object_depth_m(first.scene, "square", pose, 1)
    assert first.shot.lens.focus_distance_m == pytest.approx(middle_m)
    assert first.assumed == {"f_stop", "focus_distance_m"}
    told = first_shot(str(filmed), given={"f_stop": 4.0, "focus_distance_m": 2.0})
    assert told.assumed == frozenset() and told.shot.lens.focus_distance_m == 2.0


def test_every_value_says_where_it_is_from(capsys, bare, filmed, tmp_path):
    """The same sentence of `render` and `export`."""
    for scene, angle in ((bare, "assumed: the scene has no camera"), (filmed, "camera main of")):
        for command in ("render", "export"):
            words = (*TINY, *LENS, "--quality", "draft")
            out = tmp_path / f"{command}.exr"
            assert main([command, str(scene), "-o", str(out), *words]) == 0
            said = capsys.readouterr().err
            assert "lens at frame 1: focal length" in said and f"mm ({angle}" in said
            assert "f/2 (--f-stop), focus 3 m (--focus-distance)" in said
            assert "header" not in said


def test_an_explicit_squeeze_of_one_counts_as_given(filmed):
    assert first_shot(str(filmed), given={"squeeze": 1.0}).sources["squeeze"] == "given"


def test_focus_on_what_is_seen(capsys, bare, filmed, tmp_path):
    out = tmp_path / "o.exr"
    said = render(capsys, filmed, out, *TINY, "--f-stop", "2", "--focus-at", "12,8")
    assert "focus 3 m (--focus-at 12,8)" in said
    assert picture(out)[0]["focus"] == pytest.approx(3.0, abs=1e-4)


def test_a_plate_without_a_lens_asks_for_none(capsys, bare, tmp_path):
    for write, name in ((render, "a.exr"), (exported, "b.exr")):
        said = write(capsys, bare, tmp_path / name, *TINY, "--pinhole", "--float")
        assert "f/2 (assumed: the scene has none)" in said
    np.testing.assert_array_equal(picture(tmp_path / "a.exr")[1], picture(tmp_path / "b.exr")[1])


def street(folder, size_m: float):
    """Return ten squares of 1 m, one behind the other over `size_m`, and a floor."""
    writer = GltfWriter()
    mesh = writer.mesh()
    for number in range(10):
        at = [0.2 * number, 0.0, -size_m * number / 9]
        writer.node(name=f"square {number}", mesh=mesh, translation=at)
    writer.node(name="floor", mesh=mesh, scale=[size_m, 0.001, size_m])
    return writer.write(folder / "street.glb")


def test_a_large_scene_without_a_camera_is_seen_from_where_there_is_blur(tmp_path):
    begun = first_shot(str(street(tmp_path, 15.0)))
    shot, scene = begun.shot, begun.scene
    pose = track_of(scene, shot.framing, shot.lens).pose_at(1)
    near_m, far_m = (object_depth_m(scene, f"square {n}", pose, 1) for n in (0, 9))
    assert shot.lens.focus_distance_m == pytest.approx(near_m)
    line = coc_line(shot.lens, 1000)
    assert abs(line.at_infinity_px + line.per_dioptre_px / far_m) > 6  # seen whole it is 0.3


def test_a_small_scene_without_a_camera_is_seen_whole(tmp_path):
    begun = first_shot(str(street(tmp_path, 3.0)))
    pose = track_of(begun.scene, begun.shot.framing, begun.shot.lens).pose_at(1)
    whole = framed(corners_m(begun.scene, 1), begun.shot.lens, 1280 / 720)
    assert pose == whole
