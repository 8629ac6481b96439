"""Exports of shots of 3D scenes: each frame is what the renderer makes of it, camera and all."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import CameraTrack, Framing, PoseKey, looking_at
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.job import DisplayLook, ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import fingerprint_of, frames_of, planned
from heatlens.fronts.commands.main import main
from heatlens.media.color.view_transform import srgb_transform
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.header.placement import from_exr
from heatlens.media.plate.read import read_plate
from heatlens.media.scene.demo import demo_scene, demo_shot
from heatlens.media.scene.scene_bounds import track_of
from heatlens.media.scene.scene_read import open_scene
from heatlens.render.source.named import camera_of_shot
from support.exports import exported, exr, files_in, refused
from support.gltf_files import square_scene

SIZE = (96, 54)
FRAMES = (60, 74, 88)  # while the focus is pulled
DRAFT = DefocusSettings(quality=Quality.DRAFT)
SHOT = replace(demo_shot(), framing=Framing(*SIZE, camera="dolly"), defocus=DRAFT)
SMALL = "--size=96x54"
WORDS = (SMALL, "--quality=draft")
UNBLURRED = ("--f-stop=2", "--focus-distance=2.5", "--size=32x18")
TOLD = (*UNBLURRED, "--quality=draft")


@pytest.fixture
def shot_file(tmp_path) -> Path:
    path = tmp_path / "demo.heatlens.json"
    write_shot(path, SHOT)
    return path


@pytest.fixture
def square(tmp_path) -> Path:
    """Return a scene that stands still, without a camera."""
    path = tmp_path / "square.glb"
    square_scene().write(path)
    return path


def light(path) -> np.ndarray:
    """Return the colours (H, W, 3) of an EXR."""
    channels = exr(path)[1]
    return np.stack([channels[name] for name in "RGB"], axis=-1)


# What is written


def test_frames_are_those_of_the_renderer_and_are_left_when_finished(capsys, renderer, tmp_path):
    out = tmp_path / "out" / "n.####.exr"
    words = ("--frames=60-88x14", "--float", "--with-depth", "--with-coc", *WORDS)
    exported(capsys, "demo", out, *words)
    renderer.load_scene(demo_scene())
    for frame in FRAMES:
        header, channels = exr(tmp_path / "out" / f"n.{frame:04}.exr")
        wanted = renderer.pixels(SHOT, frame)
        plate, lens = renderer.loaded.plate, SHOT.lens_at(frame)
        assert np.array_equal(light(tmp_path / "out" / f"n.{frame:04}.exr"), wanted[..., :3])
        assert np.array_equal(channels["Z"], plate.depth_m)
        assert header["focus"] == np.float32(lens.focus_distance_m)
        placed, is_left_handed = from_exr(header["worldToCamera"], 1.0)
        pose = demo_scene().camera_named("dolly").track.pose_at(frame)
        assert not is_left_handed
        assert np.allclose(placed, pose.world_to_camera, atol=1e-6)
    before = files_in(tmp_path / "out")
    assert "3 were finished before" in exported(capsys, "demo", out, *words)
    assert files_in(tmp_path / "out") == before


def test_a_shot_file_gives_what_the_command_line_gives(capsys, shot_file, tmp_path):
    assert read_shot(shot_file).source == "demo"
    exported(capsys, shot_file, tmp_path / "a.exr", "--frames=74")
    exported(capsys, "demo", tmp_path / "b.exr", "--frames=74", *WORDS)
    assert np.array_equal(light(tmp_path / "a.exr"), light(tmp_path / "b.exr"))


def test_a_pinhole_frame_is_a_plate_of_which_the_lens_makes_the_same(capsys, renderer, tmp_path):
    """A scene's frame and its exported frame are one and the same plate, bit for bit."""
    path = tmp_path / "pin.exr"
    exported(capsys, "demo", path, "--frames=74", "--pinhole", SMALL)
    renderer.load_scene(demo_scene())
    drawn = renderer.look(SHOT, 74).plate.in_memory()
    renderer.load(drawn)
    wanted = renderer.pixels(SHOT, 74)
    assert not np.array_equal(wanted[..., :3], light(path))
    renderer.load(read_plate(path))
    assert np.array_equal(renderer.pixels(SHOT, 74), wanted)


def test_through_many_points_of_the_lens(capsys, renderer, tmp_path):
    many = ("--method=accumulation", "--views=8", "--float")
    exported(capsys, "demo", tmp_path / "n.exr", "--frames=60", *many, SMALL)
    renderer.load_scene(demo_scene())
    truth = replace(DRAFT, method=Method.ACCUMULATION, views=8)
    wanted = renderer.pixels(replace(SHOT, defocus=truth), 60)
    assert np.array_equal(light(tmp_path / "n.exr"), wanted[..., :3])


def test_pictures_and_gamma(capsys, tmp_path):
    exported(capsys, "demo", tmp_path / "n.exr", "--frames=60", "--float", *WORDS)
    exported(
        capsys, "demo", tmp_path / "n.png", "--frames=60", "--gamma=2", "--view=sRGB curve", *WORDS
    )
    shown = srgb_transform().apply_cpu(light(tmp_path / "n.exr"), 0.0, 2.0)
    with Image.open(tmp_path / "n.png") as image:
        codes = np.asarray(image).astype(float)
    assert np.abs(codes - 255 * np.clip(shown, 0, 1)).max() < 0.55


def test_a_movie(capsys, tmp_path):
    exported(capsys, "demo", tmp_path / "n.mp4", "--frames=60-62", *WORDS)
    assert (tmp_path / "n.mp4").stat().st_size > 500


def test_the_input_space_is_that_of_the_light(capsys, tmp_path):
    shown = {}
    for space in ("ACEScg", "Linear Rec.709 (sRGB)"):
        words = ("--frames=60", f"--input-space={space}", *WORDS)
        exported(capsys, "demo", tmp_path / "n.png", *words)
        with Image.open(tmp_path / "n.png") as image:
            shown[space] = np.asarray(image).astype(int)
    a, b = shown.values()
    assert np.abs(a - b).max() > 2
    assert "nowhere" in refused(
        capsys, "demo", tmp_path / "n.png", "--input-space=nowhere", "--frames=60"
    )


# Which frames


def test_frames_without_a_range(square):
    still = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(square))
    assert frames_of(still, None) == (1,)
    assert frames_of(replace(still, frames=FrameRange(5, 7)), None) == (5, 6, 7)
    assert frames_of(still, "9-13x2") == (9, 11, 13)
    moving = replace(still, source="demo")
    assert frames_of(moving, None) == tuple(demo_scene().frames)


# By what they are known again


def test_what_decides_a_picture_of_a_scene_is_in_the_fingerprint(square, tmp_path):
    job = ExportJob(replace(SHOT, source=str(square)), (1,), parse_output(tmp_path / "n.png"))

    def mark(job: ExportJob) -> str:
        return planned(job).frames[0].fingerprint

    def of_shot(**changes) -> str:
        return mark(replace(job, shot=replace(job.shot, **changes)))

    track = CameraTrack((PoseKey(1, looking_at((0, 0, 5), (0, 0, 0))),))
    others = [
        of_shot(framing=Framing(*SIZE, camera="other")),
        of_shot(framing=Framing(*SIZE, camera="dolly", track=track)),
        of_shot(framing=Framing(97, 54, camera="dolly")),
        of_shot(defocus=replace(DRAFT, method=Method.RAYTRACED)),
        of_shot(defocus=replace(DRAFT, views=67)),
        mark(replace(job, pinhole=True)),
        mark(replace(job, look=DisplayLook(gamma=2.0))),
    ]
    assert len({mark(job), *others}) == len(others) + 1
    origin = planned(job).frames[0].origin
    assert mark(job) == fingerprint_of(job, 1, job.shot.lens_at(1), origin)
    assert [file.path for file in origin.files] == [square]
    before = mark(job)
    square.write_bytes(square.read_bytes() + b"\0")
    assert mark(job) != before


def test_a_scene_that_is_written_again_is_rendered_again(capsys, square, tmp_path):
    out = tmp_path / "n.exr"
    exported(capsys, square, out, *TOLD)
    assert "1 was finished before" in exported(capsys, square, out, *TOLD)
    scene = square_scene()
    scene.json["nodes"][0]["translation"] = [0.0, 0.0, 0.25]
    scene.write(square)
    assert "1 frame written" in exported(capsys, square, out, *TOLD)


# Refused


@pytest.mark.parametrize("missing", ["stop", "hold", "black"])
def test_a_scene_that_is_not_there(capsys, tmp_path, missing):
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, replace(SHOT, source=str(tmp_path / "gone.glb")))
    words = ("--frames=1", f"--missing={missing}")
    assert "gone.glb is not there" in refused(capsys, shot, tmp_path / "n.exr", *words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "--f-stop and --focus-distance"),
        ((*TOLD, "--scene-camera=nobody"), "no camera called 'nobody'"),
        (("--focus-at=3,4",), "--focus-at needs a picture"),
        ((*UNBLURRED, "--pinhole", "--proxy=0.5"), "leave --proxy out"),
    ],
)
def test_options_that_a_scene_cannot_follow(capsys, square, tmp_path, words, said):
    assert said in refused(capsys, square, tmp_path / "n.exr", *words)


@pytest.mark.parametrize("word", ["--size=8x8", "--scene-camera=a", "--pinhole"])
def test_options_that_are_for_scenes(capsys, tmp_path, word):
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, replace(SHOT, source=str(tmp_path / "plate.####.exr")))
    assert "for 3D scenes" in refused(capsys, shot, tmp_path / "n.exr", word)


# On a farm


@pytest.mark.parametrize("is_file", [False, True])
def test_a_submitted_export_names_the_scene(capsys, square, tmp_path, monkeypatch, is_file):
    monkeypatch.chdir(tmp_path)
    words = [str(square) if is_file else "demo", *UNBLURRED, "--frames=1-3", "--pinhole"]
    assert main(["export", *words, "-o", "out/n.####.exr", "--submit=openjd"]) == 0
    job = yaml.safe_load(capsys.readouterr().out)
    arguments = job["steps"][0]["script"]["actions"]["onRun"]["args"]
    assert arguments[1] == ("{{Param.Plates}}/square.glb" if is_file else "demo")
    assert {"--size=32x18", "--pinhole", "--f-stop=2.0"} <= set(arguments)
    names = [parameter["name"] for parameter in job["parameterDefinitions"]]
    assert names == (["Plates", "Out"] if is_file else ["Out"])


# The shot and its camera


def test_a_new_shot_of_a_scene(capsys, square, tmp_path):
    path = tmp_path / "s.heatlens.json"
    words = ("--f-stop=2", "--key=focus@3=2.5", "--key=focus@9=4", "--size=64x36")
    assert main(["shot", "new", str(square), "-o", str(path), *words]) == 0
    shot = read_shot(path)
    assert (shot.source, shot.framing) == (str(square), Framing(64, 36))
    assert [key.value for key in shot.curves.of(LensParameter.FOCUS_DISTANCE).keys] == [2.5, 4.0]
    assert frames_of(shot, None) == tuple(range(3, 10))
    assert main(["shot", "show", str(path)]) == 0
    said = capsys.readouterr().out
    assert "square.glb" in said and "64x36" in said


def test_the_demo_keeps_its_pull_unless_a_focus_is_given(capsys, tmp_path):
    pulled, still = (tmp_path / f"{name}.heatlens.json" for name in ("pulled", "still"))
    assert main(["shot", "new", "demo", "-o", str(pulled), "--f-stop=4"]) == 0
    assert main(["shot", "new", "demo", "-o", str(still), "--focus-distance=2"]) == 0
    capsys.readouterr()
    for frame in FRAMES:
        own = SHOT.lens_at(frame)
        assert read_shot(pulled).lens_at(frame) == replace(own, f_stop=4.0)
        assert read_shot(still).lens_at(frame) == replace(own, focus_distance_m=2.0)


def test_a_camera_stands_where_the_scene_has_it(capsys, shot_file, tmp_path):
    track = demo_scene().camera_named("dolly").track
    camera = camera_of_shot(SHOT, "demo", FrameRange(60, 88))
    assert camera.world_to_camera is not None and camera.focus_distance_m is not None
    for i, frame in enumerate(camera.frames):
        position = np.linalg.inv(camera.world_to_camera[i])[:3, 3]
        assert np.allclose(position, track.pose_at(frame).position_m, atol=1e-12)
        assert camera.focus_distance_m[i] == SHOT.lens_at(frame).focus_distance_m
    assert camera.sensor_height_mm == (36.0 * 54 / 96,) * 29
    out = tmp_path / "cam.json"
    assert main(["camera", str(shot_file), "-o", str(out), "--frames=60-88"]) == 0
    capsys.readouterr()
    samples = json.loads(out.read_text())["samples"]
    assert [s["world_to_camera"][0][3] for s in samples] == pytest.approx(
        [matrix[0][3] for matrix in camera.world_to_camera]
    )


def test_the_camera_of_a_scene_without_one_sees_all_of_it(square):
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(square), framing=Framing(32, 32))
    camera = camera_of_shot(shot, "c")
    pose = track_of(open_scene(str(square)), Framing(32, 32), shot.lens).pose_at(1)
    assert camera.frames == (1,)
    assert np.allclose(camera.world_to_camera[0], pose.world_to_camera)


# What lies around and behind


def test_an_exported_plate_is_the_rendered_one_with_overscan_and_what_lies_behind(capsys, tmp_path):
    words = (SMALL, "--pinhole", "--overscan=4", "--f-stop=2", "--focus-distance=3")
    for deep in ((), ("--deep",)):
        one, many = tmp_path / f"one{len(deep)}.exr", tmp_path / f"many{len(deep)}.####.exr"
        assert main(["render", "demo", "-o", str(one), "--frame=74", "--quiet", *words, *deep]) == 0
        capsys.readouterr()
        exported(capsys, "demo", many, "--frames=74", *words, *deep)
        written = tmp_path / f"many{len(deep)}.0074.exr"
        rendered, plate = read_plate(one), read_plate(written)
        assert plate.data_window == rendered.data_window != plate.display_window
        assert np.array_equal(plate.color, rendered.color)
        assert np.array_equal(plate.depth_m, rendered.depth_m)
        assert (plate.fragments is None) == (not deep)
        assert "1 was finished before" in exported(
            capsys, "demo", many, "--frames=74", *words, *deep
        )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--deep",), "Give --pinhole too"),
        (("--pinhole", "--overscan=auto"), "Give --f-stop and --focus-distance"),
        (("--pinhole", "--deep", "--compression=piz"), "always compressed as zips"),
    ],
)
def test_plates_that_cannot_be_are_refused(capsys, tmp_path, words, said):
    assert main(["export", "demo", "-o", str(tmp_path / "n.exr"), "--frames=74", *words]) == 2
    assert said in " ".join(capsys.readouterr().err.split())
