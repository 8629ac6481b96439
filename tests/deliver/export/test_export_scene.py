"""Test exports of 3D scenes: each frame and its camera equal those of the renderer."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.job import DisplaySettings, ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import fingerprint_of, frames_of, plan_export
from heatlens.fronts.commands.main import main
from heatlens.media.color.view_transform import srgb_transform
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.header.placement import convert_from_exr
from heatlens.media.plate.read import read_plate
from heatlens.media.scene.demo import demo_scene, demo_shot
from heatlens.media.scene.scene_bounds import track_of
from heatlens.media.scene.scene_read import open_scene
from heatlens.render.source.named import camera_of_shot
from support.exports import export_shot, exr, files_in, refused_export_message
from support.gltf_files import square_scene

SIZE = (96, 54)
FRAMES = (60, 74, 88)  # while the focus is pulled
DRAFT = DefocusSettings(quality=Quality.DRAFT)
SHOT = replace(demo_shot(), framing=Framing(*SIZE, camera="dolly"), defocus=DRAFT)
SMALL = "--size=96x54"
WORDS = (SMALL, "--quality=draft")
UNBLURRED = ("--f-stop=2", "--focus-distance=2.5", "--size=32x18")
UNBLURRED_DRAFT = (*UNBLURRED, "--quality=draft")


@pytest.fixture
def shot_file(tmp_path) -> Path:
    path = tmp_path / "demo.heatlens.json"
    write_shot(path, SHOT)
    return path


@pytest.fixture
def square_scene_path(tmp_path) -> Path:
    """Return a scene that stands still, without a camera."""
    path = tmp_path / "square.glb"
    square_scene().write(path)
    return path


def exr_colors(path) -> np.ndarray:
    """Return the colours (H, W, 3) of an EXR."""
    channels = exr(path)[1]
    return np.stack([channels[name] for name in "RGB"], axis=-1)


# Exported files


def test_exported_scene_frames_equal_renderer_and_are_kept(capsys, renderer, tmp_path):
    out = tmp_path / "out" / "n.####.exr"
    words = ("--frames=60-88x14", "--float", "--with-depth", "--with-coc", *WORDS)
    messages = export_shot(capsys, "demo", out, *words)
    assert "lens at frame 60: " in messages
    renderer.load_scene(demo_scene())
    for frame in FRAMES:
        header, channels = exr(tmp_path / "out" / f"n.{frame:04}.exr")
        expected = renderer.pixels(SHOT, frame)
        plate, lens = renderer.loaded.plate, SHOT.lens_at(frame)
        assert np.array_equal(exr_colors(tmp_path / "out" / f"n.{frame:04}.exr"), expected[..., :3])
        assert np.array_equal(channels["Z"], plate.depth_m)
        assert header["focus"] == np.float32(lens.focus_distance_m)
        world_to_camera, is_left_handed = convert_from_exr(header["worldToCamera"], 1.0)
        pose = demo_scene().camera_named("dolly").track.pose_at(frame)
        assert not is_left_handed
        assert np.allclose(world_to_camera, pose.world_to_camera, atol=1e-6)
    files_before = files_in(tmp_path / "out")
    assert "3 were finished before" in export_shot(capsys, "demo", out, *words)
    assert files_in(tmp_path / "out") == files_before


def test_shot_file_of_demo_exports_same_pixels_as_options(capsys, shot_file, tmp_path):
    assert read_shot(shot_file).source == "demo"
    export_shot(capsys, shot_file, tmp_path / "a.exr", "--frames=74")
    export_shot(capsys, "demo", tmp_path / "b.exr", "--frames=74", *WORDS)
    assert np.array_equal(exr_colors(tmp_path / "a.exr"), exr_colors(tmp_path / "b.exr"))


def test_exported_pinhole_frame_equals_plate_of_scene(capsys, renderer, tmp_path):
    """The drawn frame of a scene and its exported frame are the same plate, bit for bit."""
    path = tmp_path / "pin.exr"
    export_shot(capsys, "demo", path, "--frames=74", "--pinhole", SMALL)
    renderer.load_scene(demo_scene())
    pinhole_plate = renderer.load_pinhole(SHOT, 74).plate.in_memory()
    renderer.load(pinhole_plate)
    expected = renderer.pixels(SHOT, 74)
    assert not np.array_equal(expected[..., :3], exr_colors(path))
    renderer.load(read_plate(path))
    assert np.array_equal(renderer.pixels(SHOT, 74), expected)


def test_export_with_accumulation_equals_renderer(capsys, renderer, tmp_path):
    many = ("--method=accumulation", "--views=8", "--float")
    export_shot(capsys, "demo", tmp_path / "n.exr", "--frames=60", *many, SMALL)
    renderer.load_scene(demo_scene())
    blur = replace(DRAFT, method=Method.ACCUMULATION, views=8)
    expected = renderer.pixels(replace(SHOT, defocus=blur), 60)
    assert np.array_equal(exr_colors(tmp_path / "n.exr"), expected[..., :3])


def test_export_of_scene_as_png_applies_view_and_gamma(capsys, tmp_path):
    export_shot(capsys, "demo", tmp_path / "n.exr", "--frames=60", "--float", *WORDS)
    export_shot(
        capsys, "demo", tmp_path / "n.png", "--frames=60", "--gamma=2", "--view=sRGB curve", *WORDS
    )
    expected = srgb_transform().apply_cpu(exr_colors(tmp_path / "n.exr"), 0.0, 2.0)
    with Image.open(tmp_path / "n.png") as image:
        codes = np.asarray(image).astype(float)
    assert np.abs(codes - 255 * np.clip(expected, 0, 1)).max() < 0.55


def test_export_of_scene_writes_movie(capsys, tmp_path):
    export_shot(capsys, "demo", tmp_path / "n.mp4", "--frames=60-62", *WORDS)
    assert (tmp_path / "n.mp4").stat().st_size > 500


def test_input_space_changes_exported_picture(capsys, tmp_path):
    pictures = {}
    for space in ("ACEScg", "Linear Rec.709 (sRGB)"):
        words = ("--frames=60", f"--input-space={space}", *WORDS)
        export_shot(capsys, "demo", tmp_path / "n.png", *words)
        with Image.open(tmp_path / "n.png") as image:
            pictures[space] = np.asarray(image).astype(int)
    a, b = pictures.values()
    assert np.abs(a - b).max() > 2
    assert "nowhere" in refused_export_message(
        capsys, "demo", tmp_path / "n.png", "--input-space=nowhere", "--frames=60"
    )


# Which frames


def test_frames_of_scene_without_range_are_still_or_animation(square_scene_path):
    still = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(square_scene_path))
    assert frames_of(still, None) == (1,)
    assert frames_of(replace(still, frames=FrameRange(5, 7)), None) == (5, 6, 7)
    assert frames_of(still, "9-13x2") == (9, 11, 13)
    moving = replace(still, source="demo")
    assert frames_of(moving, None) == tuple(demo_scene().frames)


# Fingerprints


def test_fingerprint_of_scene_frame_includes_all_that_affects_pixels(square_scene_path, tmp_path):
    job = ExportJob(
        shot=replace(SHOT, source=str(square_scene_path)),
        frames=(1,),
        output=parse_output(tmp_path / "n.png"),
    )

    def mark(job: ExportJob) -> str:
        return plan_export(job).frames[0].fingerprint

    def of_shot(**changes) -> str:
        return mark(replace(job, shot=replace(job.shot, **changes)))

    track = CameraTrack((PoseKey(1, pose_looking_at((0, 0, 5), (0, 0, 0))),))
    others = [
        of_shot(framing=Framing(*SIZE, camera="other")),
        of_shot(framing=Framing(*SIZE, camera="dolly", track=track)),
        of_shot(framing=Framing(97, 54, camera="dolly")),
        of_shot(defocus=replace(DRAFT, method=Method.RAYTRACED)),
        of_shot(defocus=replace(DRAFT, views=67)),
        mark(replace(job, pinhole=True)),
        mark(replace(job, display_settings=DisplaySettings(gamma=2.0))),
    ]
    assert len({mark(job), *others}) == len(others) + 1
    origin = plan_export(job).frames[0].origin
    assert mark(job) == fingerprint_of(job, 1, job.shot.lens_at(1), origin)
    assert [file.path for file in origin.files] == [square_scene_path]
    fingerprint_before = mark(job)
    square_scene_path.write_bytes(square_scene_path.read_bytes() + b"\0")
    assert mark(job) != fingerprint_before


def test_changed_scene_file_is_rendered_again(capsys, square_scene_path, tmp_path):
    out = tmp_path / "n.exr"
    export_shot(capsys, square_scene_path, out, *UNBLURRED_DRAFT)
    assert "1 was finished before" in export_shot(capsys, square_scene_path, out, *UNBLURRED_DRAFT)
    scene = square_scene()
    scene.json["nodes"][0]["translation"] = [0.0, 0.0, 0.25]
    scene.write(square_scene_path)
    assert "1 frame written" in export_shot(capsys, square_scene_path, out, *UNBLURRED_DRAFT)


# Refused


@pytest.mark.parametrize("missing", ["stop", "hold", "black"])
def test_export_refuses_missing_scene_file(capsys, tmp_path, missing):
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, replace(SHOT, source=str(tmp_path / "gone.glb")))
    words = ("--frames=1", f"--missing={missing}")
    assert "gone.glb is not there" in refused_export_message(
        capsys, shot, tmp_path / "n.exr", *words
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "--f-stop and --focus-distance"),
        ((*UNBLURRED_DRAFT, "--scene-camera=nobody"), "no camera called 'nobody'"),
        (("--focus-at=3,4",), "--focus-at needs a picture"),
        ((*UNBLURRED, "--pinhole", "--proxy=0.5"), "leave --proxy out"),
    ],
)
def test_export_of_scene_rejects_unsuitable_options(
    capsys, square_scene_path, tmp_path, words, message
):
    assert message in refused_export_message(capsys, square_scene_path, tmp_path / "n.exr", *words)


@pytest.mark.parametrize("word", ["--size=8x8", "--scene-camera=a", "--pinhole"])
def test_export_of_plates_rejects_scene_options(capsys, tmp_path, word):
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, replace(SHOT, source=str(tmp_path / "plate.####.exr")))
    assert "for 3D scenes" in refused_export_message(capsys, shot, tmp_path / "n.exr", word)


# On a farm


@pytest.mark.parametrize("is_file", [False, True])
def test_openjd_job_refers_to_scene_and_its_options(
    capsys, square_scene_path, tmp_path, monkeypatch, is_file
):
    monkeypatch.chdir(tmp_path)
    words = [str(square_scene_path) if is_file else "demo", *UNBLURRED, "--frames=1-3", "--pinhole"]
    assert main(["export", *words, "-o", "out/n.####.exr", "--submit=openjd"]) == 0
    job = yaml.safe_load(capsys.readouterr().out)
    arguments = job["steps"][0]["script"]["actions"]["onRun"]["args"]
    assert arguments[1] == ("{{Param.Plates}}/square.glb" if is_file else "demo")
    assert {"--size=32x18", "--pinhole", "--f-stop=2.0"} <= set(arguments)
    names = [parameter["name"] for parameter in job["parameterDefinitions"]]
    assert names == (["Plates", "Out"] if is_file else ["Out"])


# The shot and its camera


def test_shot_new_of_scene_keeps_keys_and_size(capsys, square_scene_path, tmp_path):
    path = tmp_path / "s.heatlens.json"
    words = ("--f-stop=2", "--key=focus@3=2.5", "--key=focus@9=4", "--size=64x36")
    assert main(["shot", "new", str(square_scene_path), "-o", str(path), *words]) == 0
    shot = read_shot(path)
    assert (shot.source, shot.framing) == (str(square_scene_path), Framing(64, 36))
    assert [key.value for key in shot.curves.of(LensParameter.FOCUS_DISTANCE).keys] == [2.5, 4.0]
    assert frames_of(shot, None) == tuple(range(3, 10))
    assert main(["shot", "show", str(path)]) == 0
    text = capsys.readouterr().out
    assert "square.glb" in text and "64x36" in text


def test_shot_new_of_demo_keeps_focus_pull_unless_focus_is_given(capsys, tmp_path):
    pulled, still = (tmp_path / f"{name}.heatlens.json" for name in ("pulled", "still"))
    assert main(["shot", "new", "demo", "-o", str(pulled), "--f-stop=4"]) == 0
    assert main(["shot", "new", "demo", "-o", str(still), "--focus-distance=2"]) == 0
    capsys.readouterr()
    for frame in FRAMES:
        demo_lens = SHOT.lens_at(frame)
        assert read_shot(pulled).lens_at(frame) == replace(demo_lens, f_stop=4.0)
        assert read_shot(still).lens_at(frame) == replace(demo_lens, focus_distance_m=2.0)


def test_camera_of_demo_shot_has_pose_and_focus_of_scene(capsys, shot_file, tmp_path):
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


def test_exported_camera_is_default_view_if_scene_has_no_camera(square_scene_path):
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(square_scene_path), framing=Framing(32, 32))
    camera = camera_of_shot(shot, "c")
    default = track_of(open_scene(str(square_scene_path)), Framing(32, 32), shot.lens).pose_at(1)
    assert camera.frames == (1,)
    assert np.allclose(camera.world_to_camera[0], default.world_to_camera)


# Overscan and deep plates


def test_exported_plate_with_overscan_and_deep_equals_rendered_one(capsys, tmp_path):
    words = (SMALL, "--pinhole", "--overscan=4", "--f-stop=2", "--focus-distance=3")
    for deep in ((), ("--deep",)):
        single, pattern = tmp_path / f"one{len(deep)}.exr", tmp_path / f"many{len(deep)}.####.exr"
        assert (
            main(["render", "demo", "-o", str(single), "--frame=74", "--quiet", *words, *deep]) == 0
        )
        capsys.readouterr()
        export_shot(capsys, "demo", pattern, "--frames=74", *words, *deep)
        exported_path = tmp_path / f"many{len(deep)}.0074.exr"
        rendered, plate = read_plate(single), read_plate(exported_path)
        assert plate.data_window == rendered.data_window != plate.display_window
        assert np.array_equal(plate.color, rendered.color)
        assert np.array_equal(plate.depth_m, rendered.depth_m)
        assert (plate.fragments is None) == (not deep)
        assert "1 was finished before" in export_shot(
            capsys, "demo", pattern, "--frames=74", *words, *deep
        )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--deep",), "Give --pinhole too"),
        (("--pinhole", "--overscan=auto"), "Give --f-stop and --focus-distance"),
        (("--pinhole", "--deep", "--compression=piz"), "always compressed as zips"),
    ],
)
def test_export_rejects_impossible_pinhole_plate_options(capsys, tmp_path, words, message):
    assert main(["export", "demo", "-o", str(tmp_path / "n.exr"), "--frames=74", *words]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
