"""Test that cameras in JSON and CSV read back exactly, and that errors name their place."""

import csv
import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.render.source.named import camera_of_shot
from support.cameras import SHOTS, moving_camera

SUFFIXES = (".json", ".csv")
STILL = replace(moving_camera(world_to_camera=None), name="cam")


@pytest.fixture(params=SUFFIXES)
def path(request, tmp_path):
    return tmp_path / f"cam{request.param}"


@given(SHOTS, st.sampled_from(SUFFIXES))
def test_read_camera_returns_written_camera_of_any_shot_exactly(tmp_path_factory, shot, suffix):
    path = tmp_path_factory.mktemp("cam") / f"cam{suffix}"
    camera = camera_of_shot(shot, "cam")
    write_camera(path, camera)
    assert read_camera(str(path)) == camera


def test_read_camera_returns_written_placement_exactly(path):
    camera = replace(moving_camera(up_axis="z"), name="cam")
    write_camera(path, camera)
    assert read_camera(str(path)) == camera


def test_read_camera_keeps_missing_values_missing(path):
    camera = replace(STILL, f_stop=None, sensor_height_mm=None)
    write_camera(path, camera)
    assert read_camera(str(path)) == camera


def test_csv_camera_has_header_with_units(tmp_path):
    write_camera(tmp_path / "cam.csv", moving_camera())
    with open(tmp_path / "cam.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    lens = ("focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm", "sensor_height_mm")
    assert list(rows[0])[:7] == ["frame", *lens, "squeeze"]
    assert [row["frame"] for row in rows] == [str(frame) for frame in range(1001, 1009)]
    assert (rows[0]["focus_distance_m"], rows[-1]["focus_distance_m"]) == ("0.94", "inf")
    assert float(rows[3]["world_to_camera_03"]) == moving_camera().world_to_camera[3][0][3]


def test_json_camera_has_one_object_per_frame(tmp_path):
    write_camera(tmp_path / "cam.json", moving_camera())
    content = json.loads((tmp_path / "cam.json").read_text(), parse_constant=pytest.fail)
    assert (content["heatlens_camera"], content["name"]) == (1, "hero cam")
    assert content["frames_per_second"] == 25
    assert [sample["frame"] for sample in content["samples"]] == list(range(1001, 1009))
    assert content["samples"][7]["focus_distance_m"] == "inf"
    assert content["samples"][2]["world_to_camera"][3] == [0, 0, 0, 1]


def test_read_camera_csv_accepts_any_column_order_spaces_and_bom(tmp_path):
    path = tmp_path / "cam.csv"
    text = "focus_distance_m,frame,f_stop\r\n 2.5,1, 2\r\n\r\ninf,3.0,2\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    camera = read_camera(str(path))
    assert (camera.frames, camera.f_stop) == ((1, 3), (2.0, 2.0))
    assert camera.focus_distance_m == (2.5, float("inf"))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("frame,", "farme,", "unknown column 'farme'; did you mean 'frame'"),
        ("squeeze,", "zzzz,", "unknown column 'zzzz'; known are frame, focal_length_mm"),
        ("squeeze,", "f_stop,", "the column 'f_stop' occurs twice"),
        ("1003,", "1003.5,", "line 4: a frame should be a whole number, got 1003.5"),
        ("1003,", "x,", "line 4: frame should be a number, got 'x'"),
        ("1003,", "nan,", "line 4: frame should be a number, got 'nan'"),
        ("1003,", "inf,", "line 4: a frame should be a whole number, got inf"),
        ("1003,", ",", "Row 3 has no frame"),
        ("1003,", "1002,", "two entries for frame 1002"),
        ("1003,", "1003,5,", "line 4 has more or fewer cells"),
        (",y\n1003,", ",\n1003,", None),
        (",25.0,y", ",0,y", "Frames per second must be above 0"),
        (",25.0,y", ",25.0,up", "points up is y or z, not 'up'"),
        ("1004,51.0,1.3", "1004,51.0,", "Frame 1004 has no f_stop, but other frames do"),
        (
            "1004,51.0,1.3",
            "1004,51.0,-1",
            "Frame 1004: the f-stop of a camera must be above 0 and finite, got -1",
        ),
        ("1004,51.0,1.3", '1004,51.0,"1.3', "is damaged"),
    ],
)
def test_read_camera_csv_error_names_line(tmp_path, old, new, sentence):
    path = tmp_path / "cam.csv"
    write_camera(path, STILL)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    if sentence is None:  # told by the first row alone
        assert read_camera(str(path)) == STILL
        return
    with pytest.raises(InputError, match=sentence) as refusal:
        read_camera(str(path))
    assert str(path) in str(refusal.value)


def test_read_camera_csv_rejects_incomplete_placement(tmp_path):
    path = tmp_path / "cam.csv"
    path.write_text("frame,world_to_camera_00\n1,1\n")
    with pytest.raises(
        InputError, match="line 2: the position of the camera lacks world_to_camera_01"
    ):
        read_camera(str(path))


@pytest.mark.parametrize("content", [b"", b"frame,f_stop\n", b"\xff\xfe\x00", b"frame\n1\x00\n"])
def test_read_camera_rejects_file_that_is_no_csv_table(tmp_path, content):
    path = tmp_path / "cam.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=str(path)):
        read_camera(str(path))


@given(
    st.lists(st.sampled_from(["frame", "f_stop", "up_axis"]), min_size=1, max_size=3),
    st.text('019.-+einfyz ,"\n\r\0', max_size=40),
)
def test_read_camera_of_any_csv_returns_frames_or_raises_input_error(tmp_path_factory, head, rows):
    path = tmp_path_factory.mktemp("cam") / "cam.csv"
    path.write_text(f"{','.join(head)}\n{rows}", encoding="utf-8", newline="")
    try:
        assert read_camera(str(path)).frames
    except InputError as refusal:
        assert str(path) in str(refusal)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda top: top.pop("heatlens_camera"), "this is no camera of heatlens"),
        (lambda top: top.update(heatlens_camera=2), "version 2 is not known here, only 1"),
        (lambda top: top.pop("samples"), "the entry 'samples' is missing"),
        (lambda top: top.update(samples=[]), "A camera needs at least one frame"),
        (lambda top: top.update(samples={}), "samples: {} should be a list"),
        (lambda top: top.update(up_axis="x"), 'up_axis: "x" should be one of y, z'),
        (lambda top: top.update(lens=3), "unknown entry 'lens'"),
        (lambda top: top.update(frames_per_second=-1), "Frames per second must be above 0"),
        (lambda top: top["samples"][1].pop("frame"), "Row 2 has no frame"),
        (lambda top: top["samples"][1].update(frame=2.5), r"samples\[1\].frame: 2.5 should be a"),
        (
            lambda top: top["samples"][1].update(fstop=2),
            r"samples\[1\]: unknown entry 'fstop'; did",
        ),
        (lambda top: top["samples"][1].pop("f_stop"), "Frame 1002 has no f_stop"),
        (lambda top: top["samples"][1].update(f_stop="2"), r"samples\[1\].f_stop: \"2\" should be"),
        (
            lambda top: top["samples"][1].update(world_to_camera=[[1, 2], [3, 4]]),
            r"samples\[1\].world_to_camera: The placement of a camera is a matrix",
        ),
        (
            lambda top: top["samples"][1].update(world_to_camera=[[1, 2], [3]]),
            r"samples\[1\].world_to_camera: The placement of a camera is a matrix",
        ),
        (
            lambda top: top["samples"][1].update(world_to_camera=[[2] * 4] * 4),
            "Frame 1002: the matrix that places the camera",
        ),
    ],
)
def test_read_camera_json_error_names_entry(tmp_path, change, sentence):
    path = tmp_path / "cam.json"
    write_camera(path, moving_camera())
    top = json.loads(path.read_text())
    change(top)
    path.write_text(json.dumps(top))
    with pytest.raises(InputError, match=sentence) as refusal:
        read_camera(str(path))
    assert str(path) in str(refusal.value)


def test_read_camera_of_truncated_file_raises_or_has_fewer_frames(path):
    """Only a table cut at the end of a line is accepted."""
    write_camera(path, moving_camera())
    content = path.read_bytes()
    for length in range(0, len(content) - 2, 7):
        path.write_bytes(content[:length])
        try:
            camera = read_camera(str(path))
        except InputError as refusal:
            assert str(path) in str(refusal)
        else:
            assert path.suffix == ".csv" and content[:length].count(b"\n") >= len(camera.frames)


@pytest.mark.parametrize("name", ["cam.fbx", "cam", "s.heatlens.json", "cam.exr"])
def test_write_camera_rejects_unknown_suffix(tmp_path, name):
    with pytest.raises(InputError, match=r"must end in .usda, .usd, .usdc, .nk, .json, .csv, .py"):
        write_camera(tmp_path / name, STILL)
    assert not (tmp_path / name).exists()


def test_write_camera_in_metric_format_rejects_scene_unit(path):
    with pytest.raises(InputError, match="always in metres"):
        write_camera(path, STILL, 0.01)


@pytest.mark.parametrize("unit_m", [1e-9, 1e9])
def test_write_camera_rejects_unit_beyond_float32(tmp_path, unit_m):
    with pytest.raises(InputError, match="metres per unit"):
        write_camera(tmp_path / "cam.nk", STILL, unit_m)


@pytest.mark.parametrize("name", ["cam.nk", "cam.py"])
def test_read_camera_rejects_write_only_formats(name):
    with pytest.raises(InputError, match=r"cannot read them\. Use USD"):
        read_camera(name)


def test_read_camera_reports_missing_file(path):
    with pytest.raises(InputError, match="is not there"):
        read_camera(str(path))
