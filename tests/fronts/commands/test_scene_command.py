"""Test `heatlens render` of 3D scenes."""

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
from support.command_line import OLD_CONTENT, picture, refused_render_message, render
from support.gltf_files import GltfWriter
from support.session_files import room_file

SIZE = (48, 27)
LENS = ("--f-stop", 2, "--focus-distance", 3)
WIDE = ("--f-stop", 0.5, "--focus-distance", 3, "--focal-length", 40)  # exact in a header's float32


def write_scene(path: Path) -> Path:
    """Write a scene of a square at 3 m, another behind it, and two cameras. Return its path."""
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


def render_headless(renderer, scene: Path, out: Path, **settings: object) -> np.ndarray:
    """Render `scene` with the lens in the header of `out`. Return the colors (H, W, 3)."""
    camera = read_scene(scene).cameras[0]
    header, _ = picture(out)
    f_stop = float(header["aperture"])
    model = LensModel(header["heatlens:lensModel"])
    lens = Lens(camera.focal_length_mm, f_stop, 3.0, camera.sensor_width_mm, model=model)
    renderer.load_scene(read_scene(scene))
    return renderer.pixels(shot_of(scene, lens, **settings), 1)[..., :3]


@pytest.mark.parametrize("method", [str(m) for m in Method if m.needs_scene])
def test_render_of_scene_by_reference_method_equals_renderer(
    capsys, scene, renderer, tmp_path, method
):
    out, options = tmp_path / "out.exr", ("--size", "48x27", "--method", method, "--views", 16)
    message = render(capsys, scene, out, *options, *LENS, "--float")
    assert "f/2" in message
    expected = render_headless(renderer, scene, out, method=Method(method), views=16)
    np.testing.assert_array_equal(picture(out)[1], expected)
    assert np.ptp(expected) > 0.1


def test_blurred_pinhole_plate_is_close_to_scene_render(capsys, scene, tmp_path):
    """They differ a little, as the scene also has surfaces outside the frame and hidden ones."""
    pinhole, from_pinhole, live = (
        tmp_path / f"{name}.exr" for name in ("pinhole", "again", "live")
    )
    render(capsys, scene, pinhole, "--size", "48x27", "--pinhole", *WIDE)
    plate = read_plate(pinhole)
    assert (plate.data_window.width, plate.data_window.height) == SIZE
    depth = plate.depth_m
    assert depth is not None and np.isinf(depth).any() and np.isfinite(depth).any()
    render(capsys, pinhole, from_pinhole, *WIDE, "--float")
    render(capsys, scene, live, "--size", "48x27", *WIDE, "--float")
    difference = np.abs(picture(from_pinhole)[1] - picture(live)[1])
    assert difference.mean() < 0.002 and difference.max() < 0.05


def test_render_rejects_unknown_scene_camera_and_lists_others(capsys, scene, tmp_path):
    words = ("--size", "8x8", "--scene-camera", "sied", *LENS)
    message = refused_render_message(capsys, scene, tmp_path / "o.exr", *words)
    assert "scene.glb" in message and "sied" in message and "side" in message and "main" in message


def test_scene_camera_option_changes_picture_and_focal_length(capsys, scene, tmp_path):
    pictures = []
    for name in ("main", "side"):
        out = tmp_path / f"{name}.exr"
        render(capsys, scene, out, "--size", "48x27", "--scene-camera", name, "--pinhole", *LENS)
        pictures.append(picture(out))
    assert np.abs(pictures[0][1] - pictures[1][1]).max() > 0.05
    focal = [header["pinholeFocalLength"] for header, _ in pictures]
    assert focal[1] > focal[0]


@pytest.mark.parametrize("words", [("--size", "8x8"), ("--scene-camera", "main"), ("--frame", 3)])
def test_render_of_plate_rejects_scene_options(capsys, tmp_path, words):
    plate = room_file(tmp_path / "room.exr")
    message = refused_render_message(capsys, plate, tmp_path / "o.exr", *words)
    assert "room.exr" in message and str(words[0]) in message


def test_render_of_plate_rejects_pinhole(capsys, tmp_path):
    assert "--pinhole" in refused_render_message(
        capsys, room_file(tmp_path / "room.exr"), tmp_path / "o.exr", "--pinhole"
    )


@pytest.mark.parametrize("method", [str(m) for m in Method if m.needs_scene])
def test_render_of_plate_rejects_scene_methods(capsys, tmp_path, method):
    plate = room_file(tmp_path / "room.exr")
    message = refused_render_message(capsys, plate, tmp_path / "o.exr", "--method", method, *LENS)
    assert "room.exr" in message and "scene" in message


@pytest.mark.parametrize("size", ["96", "0x9", "9x0", "axb", "99999x99999", "-1x5"])
def test_render_rejects_impossible_size(capsys, scene, tmp_path, size):
    from heatlens.fronts.commands.main import main

    try:
        code = main(["render", str(scene), "-o", str(tmp_path / "o.exr"), f"--size={size}"])
    except SystemExit as end:
        code = end.code
    assert code == 2 and not (tmp_path / "o.exr").exists()
    assert size.split("x")[0] in capsys.readouterr().err


@pytest.mark.parametrize("content", [None, b"", b"glTF", b"\0" * 100, "half"])
def test_render_names_unreadable_scene(capsys, tmp_path, content):
    path = tmp_path / "bad.glb"
    if content == "half":
        write_scene(path)
        content = path.read_bytes()[:-40]
    if content is not None:
        path.write_bytes(content)
    (tmp_path / "o.exr").write_bytes(OLD_CONTENT)
    assert "bad.glb" in refused_render_message(capsys, path, tmp_path / "o.exr", "--size", "8x8")


def test_render_of_demo_scene_writes_depth(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "demo.exr"
    message = render(capsys, "demo", out, "--size", "64x36", "--frame", 120, "--pinhole")
    ((header, out_channels),) = read_parts(out)
    assert "Z" in out_channels and out_channels["Z"].shape == (36, 64)
    assert np.isfinite(out_channels["Z"]).any() and "lens:" in message
    assert header["aperture"] > 0


def test_file_named_demo_takes_precedence_over_demo_scene(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "demo").write_bytes(b"no picture")
    assert "demo" in refused_render_message(capsys, "demo", tmp_path / "o.exr")
