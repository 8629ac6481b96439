"""`heatlens render` of a 3D scene as a user meets it."""

from pathlib import Path

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.read import read_plate
from heatlens.media.scene.scene_read import read_scene
from support.command_line import BEFORE, picture, refused, render
from support.gltf_files import GltfWriter
from support.session_files import room_file

SIZE = (48, 27)
LENS = ("--f-stop", 2, "--focus-distance", 3)
WIDE = ("--f-stop", 0.5, "--focus-distance", 3, "--focal-length", 40)  # exact in a header's float32


def write_scene(path: Path) -> Path:
    """Return a square at 3 m and another behind it, between them a camera's axis; two cameras."""
    writer = GltfWriter()
    mesh = writer.mesh()
    writer.node(name="near", mesh=mesh, translation=[-1.0, 0.0, 0.0])
    writer.node(name="far", mesh=mesh, translation=[0.0, 0.0, -4.0], scale=[3, 2, 1])
    for name, x, angle in (("main", 0.0, 0.7), ("side", 1.5, 0.4)):
        perspective = {"yfov": angle, "znear": 0.1, "aspectRatio": 1.5}
        camera = writer.add("cameras", type="perspective", perspective=perspective, name=name)
        writer.node(name=name, camera=camera, translation=[x, 0.5, 3.0])
    return writer.write(path)


@pytest.fixture
def scene(tmp_path):
    return write_scene(tmp_path / "scene.glb")


def shot_of(scene: Path, lens: Lens, **settings: object) -> Shot:
    return Shot(lens, DefocusSettings(**settings), framing=Framing(*SIZE, "main"))


def headless(renderer, scene: Path, out: Path, **settings: object) -> np.ndarray:
    """Return what the renderer makes with the lens that `out` tells of."""
    camera = read_scene(scene).cameras[0]
    header, _ = picture(out)
    f_stop = float(header["aperture"])
    model = LensModel(header["heatlens:lensModel"])
    lens = Lens(camera.focal_length_mm, f_stop, 3.0, camera.sensor_width_mm, model=model)
    renderer.load_scene(read_scene(scene))
    return renderer.pixels(shot_of(scene, lens, **settings), 1)[..., :3]


@pytest.mark.parametrize("method", [str(m) for m in Method if m.needs_scene])
def test_the_truth_is_what_the_renderer_makes(capsys, scene, renderer, tmp_path, method):
    out, options = tmp_path / "out.exr", ("--size", "48x27", "--method", method, "--views", 16)
    said = render(capsys, scene, out, *options, *LENS, "--float")
    assert "f/2" in said
    expected = headless(renderer, scene, out, method=Method(method), views=16)
    np.testing.assert_array_equal(picture(out)[1], expected)
    assert np.ptp(expected) > 0.1


def test_a_pinhole_picture_through_the_lens_is_nearly_the_live_picture(capsys, scene, tmp_path):
    """The scene also knows what lies outside the frame and behind what is seen."""
    pinhole, again, live = (tmp_path / f"{name}.exr" for name in ("pinhole", "again", "live"))
    render(capsys, scene, pinhole, "--size", "48x27", "--pinhole", *WIDE)
    plate = read_plate(pinhole)
    assert (plate.data_window.width, plate.data_window.height) == SIZE
    depth = plate.depth_m
    assert depth is not None and np.isinf(depth).any() and np.isfinite(depth).any()
    render(capsys, pinhole, again, *WIDE, "--float")
    render(capsys, scene, live, "--size", "48x27", *WIDE, "--float")
    difference = np.abs(picture(again)[1] - picture(live)[1])
    assert difference.mean() < 0.002 and difference.max() < 0.05


def test_a_camera_that_is_not_there_is_told_with_those_that_are(capsys, scene, tmp_path):
    words = ("--size", "8x8", "--scene-camera", "sied", *LENS)
    said = refused(capsys, scene, tmp_path / "o.exr", *words)
    assert "scene.glb" in said and "sied" in said and "side" in said and "main" in said


def test_another_camera_sees_another_picture_with_its_own_angle(capsys, scene, tmp_path):
    seen = []
    for name in ("main", "side"):
        out = tmp_path / f"{name}.exr"
        render(capsys, scene, out, "--size", "48x27", "--scene-camera", name, "--pinhole", *LENS)
        seen.append(picture(out))
    assert np.abs(seen[0][1] - seen[1][1]).max() > 0.05
    focal = [header["pinholeFocalLength"] for header, _ in seen]
    assert focal[1] > focal[0]


@pytest.mark.parametrize("words", [("--size", "8x8"), ("--scene-camera", "main"), ("--frame", 3)])
def test_a_plate_is_not_asked_how_it_is_looked_at(capsys, tmp_path, words):
    plate = room_file(tmp_path / "room.exr")
    said = refused(capsys, plate, tmp_path / "o.exr", *words)
    assert "room.exr" in said and str(words[0]) in said


def test_a_plate_is_pinhole_already(capsys, tmp_path):
    assert "--pinhole" in refused(
        capsys, room_file(tmp_path / "room.exr"), tmp_path / "o.exr", "--pinhole"
    )


@pytest.mark.parametrize("method", [str(m) for m in Method if m.needs_scene])
def test_a_plate_has_no_other_points_of_view(capsys, tmp_path, method):
    plate = room_file(tmp_path / "room.exr")
    said = refused(capsys, plate, tmp_path / "o.exr", "--method", method, *LENS)
    assert "room.exr" in said and "scene" in said


@pytest.mark.parametrize("size", ["96", "0x9", "9x0", "axb", "99999x99999", "-1x5"])
def test_a_size_that_is_none_is_refused(capsys, scene, tmp_path, size):
    from heatlens.fronts.commands.main import main

    try:
        code = main(["render", str(scene), "-o", str(tmp_path / "o.exr"), f"--size={size}"])
    except SystemExit as end:
        code = end.code
    assert code == 2 and not (tmp_path / "o.exr").exists()
    assert size.split("x")[0] in capsys.readouterr().err


@pytest.mark.parametrize("content", [None, b"", b"glTF", b"\0" * 100, "half"])
def test_a_scene_that_cannot_be_read_is_told_by_name(capsys, tmp_path, content):
    path = tmp_path / "bad.glb"
    if content == "half":
        write_scene(path)
        content = path.read_bytes()[:-40]
    if content is not None:
        path.write_bytes(content)
    (tmp_path / "o.exr").write_bytes(BEFORE)
    assert "bad.glb" in refused(capsys, path, tmp_path / "o.exr", "--size", "8x8")


def test_the_program_brings_a_scene(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "demo.exr"
    said = render(capsys, "demo", out, "--size", "64x36", "--frame", 120, "--pinhole")
    ((header, found),) = read_parts(out)
    assert "Z" in found and found["Z"].shape == (36, 64)
    assert np.isfinite(found["Z"]).any() and "lens:" in said
    assert header["aperture"] > 0


def test_a_file_of_that_name_goes_before_it(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "demo").write_bytes(b"no picture")
    assert "demo" in refused(capsys, "demo", tmp_path / "o.exr")
