"""Test `heatlens camera` and `shot new --camera`: files, messages and exit codes."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Interpolation, Scale
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.media.camera.usd_read import usd_camera
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.live.ring.address import parse_ring_address
from heatlens.media.live.ring.receiver import LensReceiver
from heatlens.media.live.ring.sources import LensSample, RingSources
from heatlens.media.plate.header.camera_header import lens_attributes
from support.cameras import FRAMES, SHOTS, moving_camera
from support.command_line import folder_of
from support.exports import write_shot_file
from support.exr_files import rgb, write_file
from support.patience import PATIENCE_S

LENS = Lens(50.0, 1.3, 2.24, 36.0)
SHOT = replace(
    Shot(LENS, source="plate.####.exr", frames=FrameRange(1001, 1024), frames_per_second=25.0),
    in_out=FrameRange(1003, 1006),
).with_key(1003, LensParameter.FOCUS_DISTANCE, 0.94)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Make a temporary folder with a shot file the current folder. Return it."""
    monkeypatch.chdir(tmp_path)
    write_shot("s.heatlens.json", SHOT.with_key(1006, LensParameter.FOCUS_DISTANCE, 3.83))
    return tmp_path


def run_for_messages(capsys, *words: str) -> str:
    """Run a command that succeeds and prints only its output file. Return its stderr."""
    assert main([*words]) == 0
    captured = capsys.readouterr()
    assert captured.out == f"{words[words.index('-o') + 1]}\n"
    assert all(line.startswith("heatlens: ") for line in captured.err.splitlines())
    return captured.err


def run_refused(capsys, folder, *words: str) -> str:
    """Run a command that fails with code 2 and changes no file. Return its one line on stderr."""
    files_before = folder_of(folder / "any")
    assert main([*words]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    assert folder_of(folder / "any") == files_before
    return captured.err


@pytest.mark.parametrize("suffix", [".usda", ".usd", ".usdc", ".nk", ".json", ".csv", ".py"])
def test_camera_command_writes_played_range_in_every_format(capsys, folder, suffix):
    words = run_for_messages(capsys, "camera", "s.heatlens.json", "-o", f"cam{suffix}")
    assert f"the plate has no files: No file is called {folder / 'plate.####.exr'}" in words
    assert "sensor height 24" in words
    assert (folder / f"cam{suffix}").stat().st_size > 100
    if suffix in (".json", ".csv"):
        camera = read_camera(f"cam{suffix}")
        assert (camera.frames, camera.frames_per_second) == ((1003, 1004, 1005, 1006), 25.0)
        assert (camera.focus_distance_m[0], camera.focus_distance_m[-1]) == (0.94, 3.83)


def test_camera_command_converts_f_stop_to_renderer_discs(capsys):
    message = run_for_messages(capsys, "camera", "s.heatlens.json", "-o", "c.json")
    assert "f/1.231 to f/1.283" in message
    camera = read_camera("c.json")
    assert camera.f_stop[0] == pytest.approx(1.3 * (1 - 0.05 / 0.94))
    assert camera.nominal_f_stop == (1.3,) * 4
    assert run_for_messages(capsys, "camera", "c.json", "-o", "n.json", "--f-stop", "nominal") == ""
    nominal = read_camera("n.json")
    assert (nominal.f_stop, nominal.nominal_f_stop) == ((1.3,) * 4, None)


def receive_samples(monkeypatch, *words: str, count: int = 4) -> list[LensSample]:
    """Run `heatlens camera --send`. Return the samples that a receiver gets."""
    received: list[LensSample] = []
    monkeypatch.setattr(RingSources, "add_sample", lambda self, sample: received.append(sample))
    with LensReceiver(parse_ring_address("opentrackio://:0")) as receiver:
        assert main(["camera", *words, "--send", str(receiver.address)]) == 0
        end = time.monotonic() + PATIENCE_S
        while len(received) < count and time.monotonic() < end:
            time.sleep(0.01)
    return received


@pytest.mark.parametrize("encoding", ["json", "cbor"])
def test_camera_send_sends_lens_of_each_frame_as_opentrackio(capsys, monkeypatch, encoding):
    """Each frame is sent with its timecode and the nominal f-stop."""
    samples = receive_samples(monkeypatch, "s.heatlens.json", "--encoding", encoding)
    assert "sending 4 frames at 25/s to opentrackio://127.0.0.1:" in capsys.readouterr().err
    assert [sample.focus_distance_m for sample in samples][::3] == [0.94, 3.83]
    assert {sample.f_stop for sample in samples} == {1.3}
    assert [sample.timecode for sample in samples] == [
        Timecode(hours=0, minutes=0, seconds=40, frames=frame) for frame in (3, 4, 5, 6)
    ]
    assert {sample.frames_per_second for sample in samples} == {25.0}


def test_camera_send_uses_timecode_of_shot(monkeypatch):
    write_shot("s.heatlens.json", SHOT.with_start_timecode("10:00:00:00"))
    samples = receive_samples(monkeypatch, "s.heatlens.json")
    assert [str(sample.timecode) for sample in samples] == [
        f"10:00:00:{frame:02}" for frame in (2, 3, 4, 5)
    ]


def test_camera_send_uses_timecode_of_plates_if_shot_has_none(monkeypatch):
    for frame in (1001, 1003):
        write_file(f"plate.{frame}.exr", rgb(4, 4), timecode=f"09:59:59:{frame - 1000:02}")
    samples = receive_samples(monkeypatch, "s.heatlens.json")
    assert [str(sample.timecode) for sample in samples] == [
        f"09:59:59:{frame:02}" for frame in (3, 4, 5, 6)
    ]


def test_camera_send_uses_drop_frame_timecode(monkeypatch):
    shot = replace(SHOT, frames_per_second=30000 / 1001, in_out=None)
    write_shot("s.heatlens.json", shot.with_start_timecode("00:00:59;28"))
    samples = receive_samples(monkeypatch, "s.heatlens.json", "--frames", "1001-1003", count=3)
    assert [str(it.timecode) for it in samples] == ["00:00:59;28", "00:00:59;29", "00:01:00;02"]


def test_camera_command_applies_frames_sensor_height_and_up_axis(capsys):
    words = ("--frames", "1001-1002", "--sensor-height", "20.25", "--up-axis", "z")
    message = run_for_messages(capsys, "camera", "s.heatlens.json", "-o", "c.json", *words)
    assert "sensor height 20.25" in message
    camera = read_camera("c.json")
    assert (camera.frames, camera.up_axis, camera.name) == ((1001, 1002), "z", "s")
    assert camera.sensor_height_mm == (20.25, 20.25)


@pytest.mark.parametrize(("unit", "unit_m"), [("cm", 0.01), ("ft", 0.3048), ("0.1", 0.1)])
def test_camera_command_writes_requested_scene_unit(capsys, unit, unit_m):
    run_for_messages(capsys, "camera", "s.heatlens.json", "-o", "c.usda", "--meters-per-unit", unit)
    camera = usd_camera("c.usda")
    assert camera.focus_distance_m[0] == pytest.approx(0.94)
    with open("c.usda", encoding="utf-8") as file:
        assert f"metersPerUnit = {unit_m:g}" in file.read()


def test_camera_command_converts_camera_file(capsys):
    camera = moving_camera()
    write_camera("a.usda", camera, 1.0)
    assert "a.usda: the camera is /hero_cam." in run_for_messages(
        capsys, "camera", "a.usda", "-o", "b.json"
    )
    camera_copy = read_camera("b.json")
    assert camera_copy.frames == camera.frames
    assert camera_copy.focus_distance_m == pytest.approx(camera.focus_distance_m, rel=1e-6)
    assert len(camera_copy.world_to_camera) == 8


def test_camera_command_reads_camera_from_exr_header(capsys):
    """The matrix of the header is converted from its unit and up axis."""
    matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 200, 1]]
    write_file(
        "p.exr",
        rgb(9, 16),
        **lens_attributes(50, 2, 3, 36),
        worldToCamera=np.array(matrix, np.float32),
    )
    run_for_messages(
        capsys, "camera", "p.exr", "-o", "c.json", "--scene-unit", "cm", "--up-axis", "z"
    )
    camera = read_camera("c.json")
    assert (camera.up_axis, camera.world_to_camera[0][2]) == ("z", (0.0, 0.0, 1.0, -2.0))


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("s.heatlens.json",), "Give a file to write with -o, or an address to send to"),
        (("s.heatlens.json", "--send", "udp://x"), "'udp://x' is not an address for a lens"),
        (("s.heatlens.json", "-o", "c.nk", "--repeat"), "--encoding need --send"),
        (
            ("s.heatlens.json", "--send", "opentrackio", "--f-stop", "nominal"),
            "need a file to write, given with -o",
        ),
        (("s.heatlens.json", "-o", "c.fbx"), "the name of a camera must end in .usda"),
        (("s.heatlens.json", "-o", "t.heatlens.json"), "the name of a camera must end in"),
        (("s.heatlens.json", "-o", "none/c.nk"), "the folder"),
        (("s.heatlens.json", "-o", "c.csv", "--meters-per-unit", "cm"), "always in metres"),
        (("s.heatlens.json", "-o", "c.nk", "--meters-per-unit", "ell"), "'ell' is not a scene"),
        (("s.heatlens.json", "-o", "c.nk", "--frames", "9-1"), "run backwards"),
        (
            ("s.heatlens.json", "-o", "c.nk", "--sensor-height", "-1"),
            "sensor height of a camera must",
        ),
        (("none.heatlens.json", "-o", "c.nk"), "is not there"),
        (("still.heatlens.json", "-o", "c.nk"), "Give them with --frames"),
        (("c.csv", "-o", "c.csv"), "is the input camera: give another name"),
        (
            ("c.csv", "-o", "d.nk", "--frames", "1-2"),
            "--frames 1-2 is for shots",
        ),
        (("c.csv", "-o", "d.nk", "--sensor-height", "9"), "--sensor-height is for shots"),
        (("none.usda", "-o", "c.nk"), "none.usda is not there"),
    ],
)
def test_camera_command_rejects_wrong_options(capsys, folder, words, sentence):
    write_shot("still.heatlens.json", Shot(LENS))
    write_camera("c.csv", moving_camera())
    assert sentence in run_refused(capsys, folder, "camera", *words)


def new_shot(capsys, *words: str) -> tuple[Shot, str]:
    message = run_for_messages(
        capsys, "shot", "new", "plate.####.exr", "-o", "t.heatlens.json", "--overwrite", *words
    )
    return read_shot("t.heatlens.json"), message


@pytest.mark.parametrize("suffix", [".usda", ".json", ".csv"])
def test_shot_new_takes_lens_and_frames_from_camera_file(capsys, suffix):
    camera = moving_camera()
    write_camera(f"cam{suffix}", camera)
    shot, message = new_shot(capsys, "--camera", f"cam{suffix}")
    assert (shot.frames, shot.frames_per_second) == (FRAMES, 25.0)
    assert shot.curves.f_stop.keys == () and shot.curves.squeeze.keys == ()
    for index, frame in enumerate(FRAMES):
        lens = shot.lens_at(frame)
        assert lens.focal_length_mm == pytest.approx(camera.focal_length_mm[index], rel=1e-6)
        assert lens.focus_distance_m == pytest.approx(camera.focus_distance_m[index], rel=1e-6)
        assert (lens.f_stop, lens.sensor_width_mm, lens.squeeze) == (1.3, 36.0, 1.8)
    name = {".usda": "hero_cam", ".json": "hero cam", ".csv": "cam"}[suffix]
    assert f"lens of camera {name} in cam{suffix}, frames 1001-1008: focal length 50" in message
    assert "focus distance 0.94" in message and "f-stop 1.3," in message


@given(SHOTS, st.sampled_from(["dioptres", "distance"]))
def test_shot_written_as_camera_and_read_back_keeps_its_lens(shot, scale):
    infinite = any(shot.lens_at(frame).focus_distance_m == float("inf") for frame in FRAMES)
    write_shot("a.heatlens.json", shot)
    assert main(["camera", "a.heatlens.json", "-o", "a.json"]) == 0
    words = ["--camera", "a.json", "--focus-interpolation", "dioptres" if infinite else scale]
    assert main(["shot", "new", "p.exr", "-o", "b.heatlens.json", "--overwrite", *words]) == 0
    read_back = read_shot("b.heatlens.json")
    assert read_back.frames_per_second == shot.frames_per_second
    for frame in FRAMES:
        original_lens, returned_lens = shot.lens_at(frame), read_back.lens_at(frame)
        for name in (*map(str, LensParameter), "sensor_width_mm"):
            assert getattr(returned_lens, name) == pytest.approx(
                getattr(original_lens, name), rel=4e-7
            )


def test_shot_new_takes_lens_model_from_plate_header(capsys):
    """All lens values are given, but the header still decides the lens model."""
    write_file("plate.0001.exr", rgb(), Software="Blender 5.0.1")
    words = (
        "--focal-length",
        "50",
        "--f-stop",
        "2",
        "--focus-distance",
        "3",
        "--sensor-width",
        "36",
    )
    shot, message = new_shot(capsys, *words)
    assert shot.lens == Lens(50, 2, 3, 36, model=LensModel.RENDERER)
    assert "discs of a CG renderer (header, written by Blender)." in message
    shot, _ = new_shot(capsys, *words, "--lens-model", "photographic")
    assert shot.lens.model is LensModel.PHOTOGRAPHIC


def test_shot_new_prefers_options_and_keys_to_camera(capsys):
    write_camera("cam.json", moving_camera())
    words = ("--f-stop", "4", "--filmback", "Super 35", "--fps", "30", "--frames", "1-9")
    keyed = ("--key", "focus@1=2", "--key", "focus@9=4")
    shot, message = new_shot(capsys, "--camera", "cam.json", *words, *keyed)
    assert (shot.lens.f_stop, shot.lens.sensor_width_mm) == (4.0, 24.89)
    assert (shot.frames, shot.frames_per_second) == (FrameRange(1, 9), 30.0)
    assert shot.curves.focus_distance_m.keys == (Key(1, 2.0), Key(9, 4.0))
    assert shot.curves.focal_length_mm.keys and "is not used" not in message
    assert "f-stop" not in message and "focus distance" not in message


def test_shot_new_prefers_frames_of_plates_to_camera(capsys):
    for frame in (5, 6):
        write_file(f"plate.{frame:04d}.exr", rgb())
    write_camera("cam.json", moving_camera())
    assert new_shot(capsys, "--camera", "cam.json")[0].frames == FrameRange(5, 6)


def test_shot_new_with_distance_interpolation_has_linear_focus_keys(capsys):
    focus = tuple(2.0 + n for n in range(8))
    write_camera("cam.json", moving_camera(focus_distance_m=focus))
    shot, _ = new_shot(capsys, "--camera", "cam.json", "--focus-interpolation", "distance")
    curve = shot.curves.focus_distance_m
    assert curve.scale is Scale.LINEAR
    ends = [(key.frame, key.value, key.interpolation) for key in curve.keys]
    assert ends == [(1001, 2.0, Interpolation.LINEAR), (1008, 9.0, Interpolation.LINEAR)]


def test_shot_new_asks_for_values_missing_in_camera(capsys, folder):
    write_camera("cam.json", moving_camera(f_stop=None, focus_distance_m=None))
    words = ("shot", "new", "plate.####.exr", "-o", "t.heatlens.json", "--camera", "cam.json")
    assert "needs --focal-length, --f-stop" in run_refused(capsys, folder, *words)
    shot, _ = new_shot(capsys, "--camera", "cam.json", "--f-stop", "2", "--focus-distance", "6'")
    assert (shot.lens.f_stop, shot.lens.focal_length_mm) == (2.0, 50.0)
    assert shot.lens.focus_distance_m == pytest.approx(1.8288)


def test_shot_new_takes_camera_from_headers_of_sequence(capsys):
    for index, frame in enumerate((1001, 1002, 1003)):
        write_file(f"plate.{frame}.exr", rgb(), **lens_attributes(50, 2, 2.0 + index, 36))
    shot, message = new_shot(capsys, "--camera", "plate.####.exr")
    focus = [shot.lens_at(frame).focus_distance_m for frame in (1001, 1002, 1003)]
    assert focus == pytest.approx([2, 3, 4])
    assert "plate.####.exr, frames 1001-1003" in message


def test_shot_new_of_static_camera_has_no_frames(capsys):
    with open("cam.csv", "w", encoding="utf-8") as file:
        file.write("frame,focal_length_mm,f_stop,focus_distance_m,sensor_width_mm\n1,35,2,3,24\n")
    shot, message = new_shot(capsys, "--camera", "cam.csv")
    assert (shot.frames, shot.lens, shot.key_frames) == (None, Lens(35, 2, 3, 24), ())
    assert "cam.csv: focal length 35" in message


def test_shot_new_rejects_missing_or_unreadable_camera_file(capsys, folder):
    for name, sentence in (("cam.abc", "is not there"), ("c.nk", "not read")):
        words = ("shot", "new", "p.exr", "-o", "t.heatlens.json", "--camera", name)
        assert sentence in run_refused(capsys, folder, *words)


def test_shot_new_rejects_json_that_is_no_camera(capsys, folder):
    words = ("shot", "new", "p.exr", "-o", "t.heatlens.json", "--camera", "s.heatlens.json")
    assert "this is a shot of heatlens: give the file of a camera" in run_refused(
        capsys, folder, *words
    )
    with open("x.json", "w", encoding="utf-8") as file:
        json.dump([1], file)
    assert "no camera of heatlens" in run_refused(capsys, folder, *words[:-1], "x.json")


def test_camera_command_gives_no_overscan_warning(capsys, tmp_path):
    shot = write_shot_file(tmp_path)
    assert main(["camera", str(shot), "-o", str(tmp_path / "c.usda")]) == 0
    assert "verscan" not in capsys.readouterr().err
