"""`heatlens camera` and `shot new --camera` as they are called: files, words and exit codes."""

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

LENS = Lens(50.0, 1.3, 2.24, 36.0)
SHOT = replace(
    Shot(LENS, source="plate.####.exr", frames=FrameRange(1001, 1024), frames_per_second=25.0),
    in_out=FrameRange(1003, 1006),
).with_key(1003, LensParameter.FOCUS_DISTANCE, 0.94)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Return names on the command line are of this folder, and there is a shot in it."""
    monkeypatch.chdir(tmp_path)
    write_shot("s.heatlens.json", SHOT.with_key(1006, LensParameter.FOCUS_DISTANCE, 3.83))
    return tmp_path


def said(capsys, *words: str) -> str:
    """Return what is said on stderr; stdout names the file that was written alone."""
    assert main([*words]) == 0
    found = capsys.readouterr()
    assert found.out == f"{words[words.index('-o') + 1]}\n"
    assert all(line.startswith("heatlens: ") for line in found.err.splitlines())
    return found.err


def refused(capsys, folder, *words: str) -> str:
    """Return what is said on stderr: code 2, a line, and the folder as it was."""
    before = folder_of(folder / "any")
    assert main([*words]) == 2
    found = capsys.readouterr()
    assert found.out == "" and len(found.err.splitlines()) == 1
    assert folder_of(folder / "any") == before
    return found.err


@pytest.mark.parametrize("suffix", [".usda", ".usd", ".usdc", ".nk", ".json", ".csv", ".py"])
def test_the_part_that_is_played_is_written_in_every_format(capsys, folder, suffix):
    words = said(capsys, "camera", "s.heatlens.json", "-o", f"cam{suffix}")
    assert f"the plate has no files: No file is called {folder / 'plate.####.exr'}" in words
    assert "sensor height 24" in words
    assert (folder / f"cam{suffix}").stat().st_size > 100
    if suffix in (".json", ".csv"):
        found = read_camera(f"cam{suffix}")
        assert (found.frames, found.frames_per_second) == ((1003, 1004, 1005, 1006), 25.0)
        assert (found.focus_distance_m[0], found.focus_distance_m[-1]) == (0.94, 3.83)


def test_a_renderer_is_told_the_f_stop_of_the_same_discs(capsys):
    told = said(capsys, "camera", "s.heatlens.json", "-o", "c.json")
    assert "f/1.231 to f/1.283" in told
    found = read_camera("c.json")
    assert found.f_stop[0] == pytest.approx(1.3 * (1 - 0.05 / 0.94))
    assert found.nominal_f_stop == (1.3,) * 4
    assert said(capsys, "camera", "c.json", "-o", "n.json", "--f-stop", "nominal") == ""
    nominal = read_camera("n.json")
    assert (nominal.f_stop, nominal.nominal_f_stop) == ((1.3,) * 4, None)


def heard_of(monkeypatch, *words: str, count: int = 4) -> list[LensSample]:
    """Return the samples that whoever listens hears while the lens is sent."""
    heard: list[LensSample] = []
    monkeypatch.setattr(RingSources, "keep", lambda self, sample: heard.append(sample))
    with LensReceiver(parse_ring_address("opentrackio://:0")) as receiver:
        assert main(["camera", *words, "--send", str(receiver.address)]) == 0
        end = time.monotonic() + 30.0
        while len(heard) < count and time.monotonic() < end:
            time.sleep(0.01)
    return heard


@pytest.mark.parametrize("encoding", ["json", "cbor"])
def test_the_lens_is_sent_as_a_camera_would(capsys, monkeypatch, encoding):
    """The f-stop on the ring, each frame with its time; whoever listens follows."""
    heard = heard_of(monkeypatch, "s.heatlens.json", "--encoding", encoding)
    assert "sending 4 frames at 25/s to opentrackio://127.0.0.1:" in capsys.readouterr().err
    assert [sample.focus_distance_m for sample in heard][::3] == [0.94, 3.83]
    assert {sample.f_stop for sample in heard} == {1.3}
    assert [sample.timecode for sample in heard] == [
        Timecode(0, 0, 40, frame) for frame in (3, 4, 5, 6)
    ]
    assert {sample.frames_per_second for sample in heard} == {25.0}


def test_the_lens_is_sent_with_the_timecode_of_the_shot(monkeypatch):
    write_shot("s.heatlens.json", SHOT.started_at("10:00:00:00"))
    heard = heard_of(monkeypatch, "s.heatlens.json")
    assert [str(sample.timecode) for sample in heard] == [
        f"10:00:00:{frame:02}" for frame in (2, 3, 4, 5)
    ]


def test_the_lens_is_sent_with_the_timecode_of_the_plates_where_the_shot_has_none(monkeypatch):
    for frame in (1001, 1003):
        write_file(f"plate.{frame}.exr", rgb(4, 4), timecode=f"09:59:59:{frame - 1000:02}")
    heard = heard_of(monkeypatch, "s.heatlens.json")
    assert [str(sample.timecode) for sample in heard] == [
        f"09:59:59:{frame:02}" for frame in (3, 4, 5, 6)
    ]


def test_a_shot_that_drops_frames_is_sent_so(monkeypatch):
    shot = replace(SHOT, frames_per_second=30000 / 1001, in_out=None)
    write_shot("s.heatlens.json", shot.started_at("00:00:59;28"))
    heard = heard_of(monkeypatch, "s.heatlens.json", "--frames", "1001-1003", count=3)
    assert [str(it.timecode) for it in heard] == ["00:00:59;28", "00:00:59;29", "00:01:00;02"]


def test_the_options_of_the_shot_are_heard(capsys):
    words = ("--frames", "1001-1002", "--sensor-height", "20.25", "--up-axis", "z")
    told = said(capsys, "camera", "s.heatlens.json", "-o", "c.json", *words)
    assert "sensor height 20.25" in told
    found = read_camera("c.json")
    assert (found.frames, found.up_axis, found.name) == ((1001, 1002), "z", "s")
    assert found.sensor_height_mm == (20.25, 20.25)


@pytest.mark.parametrize(("unit", "unit_m"), [("cm", 0.01), ("ft", 0.3048), ("0.1", 0.1)])
def test_the_unit_of_the_scene_is_heard(capsys, unit, unit_m):
    said(capsys, "camera", "s.heatlens.json", "-o", "c.usda", "--meters-per-unit", unit)
    found = usd_camera("c.usda")
    assert found.focus_distance_m[0] == pytest.approx(0.94)
    with open("c.usda", encoding="utf-8") as file:
        assert f"metersPerUnit = {unit_m:g}" in file.read()


def test_a_camera_can_stand_in_the_place_of_a_shot(capsys):
    camera = moving_camera()
    write_camera("a.usda", camera, 1.0)
    assert "a.usda: the camera is /hero_cam." in said(capsys, "camera", "a.usda", "-o", "b.json")
    found = read_camera("b.json")
    assert found.frames == camera.frames
    assert found.focus_distance_m == pytest.approx(camera.focus_distance_m, rel=1e-6)
    assert len(found.world_to_camera) == 8


def test_headers_can_stand_in_the_place_of_a_shot(capsys):
    """In their own unit, with what is up in their world."""
    placed = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 200, 1]]
    write_file(
        "p.exr",
        rgb(9, 16),
        **lens_attributes(50, 2, 3, 36),
        worldToCamera=np.array(placed, np.float32),
    )
    said(capsys, "camera", "p.exr", "-o", "c.json", "--scene-unit", "cm", "--up-axis", "z")
    found = read_camera("c.json")
    assert (found.up_axis, found.world_to_camera[0][2]) == ("z", (0.0, 0.0, 1.0, -2.0))


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
            "sensor height of a camera cannot",
        ),
        (("none.heatlens.json", "-o", "c.nk"), "is not there"),
        (("still.heatlens.json", "-o", "c.nk"), "Give them with --frames"),
        (("c.csv", "-o", "c.csv"), "is the input camera: give another name"),
        (("c.csv", "-o", "d.nk", "--frames", "1-2"), "is for shots; c.csv is already a camera"),
        (("c.csv", "-o", "d.nk", "--sensor-height", "9"), "--sensor-height is for shots"),
        (("none.usda", "-o", "c.nk"), "none.usda is not there"),
    ],
)
def test_mistakes_are_answered_in_a_sentence(capsys, folder, words, sentence):
    write_shot("still.heatlens.json", Shot(LENS))
    write_camera("c.csv", moving_camera())
    assert sentence in refused(capsys, folder, "camera", *words)


def new_shot(capsys, *words: str) -> tuple[Shot, str]:
    told = said(
        capsys, "shot", "new", "plate.####.exr", "-o", "t.heatlens.json", "--overwrite", *words
    )
    return read_shot("t.heatlens.json"), told


@pytest.mark.parametrize("suffix", [".usda", ".json", ".csv"])
def test_a_shot_starts_from_a_camera(capsys, suffix):
    camera = moving_camera()
    write_camera(f"cam{suffix}", camera)
    shot, told = new_shot(capsys, "--camera", f"cam{suffix}")
    assert (shot.frames, shot.frames_per_second) == (FRAMES, 25.0)
    assert shot.curves.f_stop.keys == () and shot.curves.squeeze.keys == ()
    for index, frame in enumerate(FRAMES):
        lens = shot.lens_at(frame)
        assert lens.focal_length_mm == pytest.approx(camera.focal_length_mm[index], rel=1e-6)
        assert lens.focus_distance_m == pytest.approx(camera.focus_distance_m[index], rel=1e-6)
        assert (lens.f_stop, lens.sensor_width_mm, lens.squeeze) == (1.3, 36.0, 1.8)
    name = {".usda": "hero_cam", ".json": "hero cam", ".csv": "cam"}[suffix]
    assert f"lens of camera {name} in cam{suffix}, frames 1001-1008: focal length 50" in told
    assert "focus distance 0.94" in told and "f-stop 1.3," in told


@given(SHOTS, st.sampled_from(["dioptres", "distance"]))
def test_a_shot_handed_on_and_taken_back_has_its_lens(shot, scale):
    infinite = any(shot.lens_at(frame).focus_distance_m == float("inf") for frame in FRAMES)
    write_shot("a.heatlens.json", shot)
    assert main(["camera", "a.heatlens.json", "-o", "a.json"]) == 0
    words = ["--camera", "a.json", "--focus-interpolation", "dioptres" if infinite else scale]
    assert main(["shot", "new", "p.exr", "-o", "b.heatlens.json", "--overwrite", *words]) == 0
    back = read_shot("b.heatlens.json")
    assert back.frames_per_second == shot.frames_per_second
    for frame in FRAMES:
        before, after = shot.lens_at(frame), back.lens_at(frame)
        for name in (*map(str, LensParameter), "sensor_width_mm"):
            assert getattr(after, name) == pytest.approx(getattr(before, name), rel=4e-7)


def test_a_shot_before_plates_of_a_renderer_has_its_discs(capsys):
    """Though every value of the lens is given, the header decides whose discs they are."""
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
    shot, told = new_shot(capsys, *words)
    assert shot.lens == Lens(50, 2, 3, 36, model=LensModel.RENDERER)
    assert "discs of a CG renderer (header, written by Blender)." in told
    shot, _ = new_shot(capsys, *words, "--lens-model", "photographic")
    assert shot.lens.model is LensModel.PHOTOGRAPHIC


def test_options_and_keys_win_over_the_camera(capsys):
    write_camera("cam.json", moving_camera())
    words = ("--f-stop", "4", "--filmback", "Super 35", "--fps", "30", "--frames", "1-9")
    keyed = ("--key", "focus@1=2", "--key", "focus@9=4")
    shot, told = new_shot(capsys, "--camera", "cam.json", *words, *keyed)
    assert (shot.lens.f_stop, shot.lens.sensor_width_mm) == (4.0, 24.89)
    assert (shot.frames, shot.frames_per_second) == (FrameRange(1, 9), 30.0)
    assert shot.curves.focus_distance_m.keys == (Key(1, 2.0), Key(9, 4.0))
    assert shot.curves.focal_length_mm.keys and "is not used" not in told
    assert "f-stop" not in told and "focus distance" not in told


def test_the_plates_frames_win_over_the_cameras(capsys):
    for frame in (5, 6):
        write_file(f"plate.{frame:04d}.exr", rgb())
    write_camera("cam.json", moving_camera())
    assert new_shot(capsys, "--camera", "cam.json")[0].frames == FrameRange(5, 6)


def test_metres_are_linear_between_the_keys_of_a_camera(capsys):
    focus = tuple(2.0 + n for n in range(8))
    write_camera("cam.json", moving_camera(focus_distance_m=focus))
    shot, _ = new_shot(capsys, "--camera", "cam.json", "--focus-interpolation", "distance")
    curve = shot.curves.focus_distance_m
    assert curve.scale is Scale.LINEAR
    ends = [(key.frame, key.value, key.interpolation) for key in curve.keys]
    assert ends == [(1001, 2.0, Interpolation.LINEAR), (1008, 9.0, Interpolation.LINEAR)]


def test_what_the_camera_does_not_tell_is_asked_for(capsys, folder):
    write_camera("cam.json", moving_camera(f_stop=None, focus_distance_m=None))
    words = ("shot", "new", "plate.####.exr", "-o", "t.heatlens.json", "--camera", "cam.json")
    assert "needs --focal-length, --f-stop" in refused(capsys, folder, *words)
    shot, _ = new_shot(capsys, "--camera", "cam.json", "--f-stop", "2", "--focus-distance", "6'")
    assert (shot.lens.f_stop, shot.lens.focal_length_mm) == (2.0, 50.0)
    assert shot.lens.focus_distance_m == pytest.approx(1.8288)


def test_the_headers_of_a_sequence_are_a_camera(capsys):
    for index, frame in enumerate((1001, 1002, 1003)):
        write_file(f"plate.{frame}.exr", rgb(), **lens_attributes(50, 2, 2.0 + index, 36))
    shot, told = new_shot(capsys, "--camera", "plate.####.exr")
    focus = [shot.lens_at(frame).focus_distance_m for frame in (1001, 1002, 1003)]
    assert focus == pytest.approx([2, 3, 4])
    assert "plate.####.exr, frames 1001-1003" in told


def test_a_camera_that_stands_still_sets_no_frames(capsys):
    with open("cam.csv", "w", encoding="utf-8") as file:
        file.write("frame,focal_length_mm,f_stop,focus_distance_m,sensor_width_mm\n1,35,2,3,24\n")
    shot, told = new_shot(capsys, "--camera", "cam.csv")
    assert (shot.frames, shot.lens, shot.key_frames) == (None, Lens(35, 2, 3, 24), ())
    assert "cam.csv: focal length 35" in told


def test_the_camera_file_is_the_one_that_was_asked_for(capsys, folder):
    for name, sentence in (("cam.abc", "is not there"), ("c.nk", "not read")):
        words = ("shot", "new", "p.exr", "-o", "t.heatlens.json", "--camera", name)
        assert sentence in refused(capsys, folder, *words)


def test_json_of_another_kind_is_no_camera(capsys, folder):
    words = ("shot", "new", "p.exr", "-o", "t.heatlens.json", "--camera", "s.heatlens.json")
    assert "this is no camera of heatlens" in refused(capsys, folder, *words)
    with open("x.json", "w", encoding="utf-8") as file:
        json.dump([1], file)
    assert "no camera of heatlens" in refused(capsys, folder, *words[:-1], "x.json")


def test_a_camera_is_silent_on_overscan_which_only_a_blur_needs(capsys, tmp_path):
    shot = write_shot_file(tmp_path)
    assert main(["camera", str(shot), "-o", str(tmp_path / "c.usda")]) == 0
    assert "verscan" not in capsys.readouterr().err
