"""Test `Source.export`: it writes the files of the command, reports progress, and can be ended."""

from pathlib import Path

import numpy as np
import pytest

import heatlens
from heatlens.core.base.errors import HeatlensError
from heatlens.fronts.commands.main import main
from support.command_line import picture
from support.exports import FRAMES, files_in, write_plates, write_shot_file

LENS = {"f_stop": 1.4, "focus_distance_m": 3.0, "quality": "draft"}
WORDS = ("--f-stop", "1.4", "--focus-distance", "3", "--quality", "draft")


@pytest.fixture
def plates(tmp_path):
    return write_plates(tmp_path / "plates")


def export_by_command(source, output, *words) -> dict[str, bytes]:
    """Return the files that `heatlens export` writes."""
    assert main(["export", str(source), "-o", str(output), *words]) == 0
    return files_in(output.parent)


def test_export_of_plates_equals_export_command(plates, tmp_path):
    words = (*WORDS, "--frames", "1002-1004", "--with-depth", "--compression", "piz")
    expected = export_by_command(plates, tmp_path / "command" / "n.####.exr", *words)
    paths = heatlens.open(plates).export(
        tmp_path / "python" / "n.####.exr",
        **LENS,
        frames="1002-1004",
        with_depth=True,
        compression="piz",
    )
    assert [path.name for path in paths] == ["n.1002.exr", "n.1003.exr", "n.1004.exr"]
    assert files_in(tmp_path / "python") == expected


def test_export_of_shot_and_movie_equals_export_command(tmp_path):
    shot = write_shot_file(tmp_path)
    expected = export_by_command(shot, tmp_path / "command" / "m.mov", "--burn-in")
    (path,) = heatlens.open(shot).export(tmp_path / "python" / "m.mov", burn_in=True)
    assert path.read_bytes() == expected["m.mov"]


def test_export_of_one_frame_equals_its_render(plates, tmp_path):
    """The name of one frame is that frame alone, and the lens may be a `Lens`."""
    lens = heatlens.Lens(focal_length_mm=50, f_stop=2, focus_distance_m=3, sensor_width_mm=36)
    source = heatlens.open(plates.replace("####", "1003"))
    (path,) = source.export(tmp_path / "one.exr", lens, quality="draft", is_float=True)
    rendered = source.render(lens, quality="draft")
    np.testing.assert_array_equal(picture(path)[1], rendered[..., :3])


def test_export_of_file_whose_name_begins_with_minus(plates, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path(plates.replace("####", "1003")).rename("-x.exr")
    (path,) = heatlens.open("-x.exr").export("out.exr", **LENS)
    assert path.is_file()


def test_shot_file_keeps_its_lens(tmp_path):
    with pytest.raises(HeatlensError, match=r"defines the lens.* f_stop"):
        heatlens.open(write_shot_file(tmp_path)).export(tmp_path / "n.####.exr", f_stop=2)


def test_export_of_scene_takes_size_and_camera_of_open(tmp_path):
    source = heatlens.open("demo", size=(64, 36))
    (path,) = source.export(tmp_path / "s.exr", frames="5", quality="draft", is_float=True)
    rendered = source.render(frame=5, quality="draft")
    np.testing.assert_array_equal(picture(path)[1], rendered[..., :3])


def test_progress_counts_frames_and_cancel_ends_between_them(plates, tmp_path):
    output, reports = tmp_path / "out" / "n.####.exr", []
    source = heatlens.open(plates)
    before = source.render(**LENS)
    paths = source.export(
        output, **LENS, progress=reports.append, is_cancelled=lambda: len(reports) == 2
    )
    assert [(it.number, it.done, it.count, it.was_there) for it in reports] == [
        (1001, 1, 6, False),
        (1002, 2, 6, False),
    ]
    assert [it.path for it in reports] == list(paths) and set(files_in(output.parent)) >= {
        "n.1001.exr",
        "n.1002.exr",
    }
    reports.clear()
    assert len(source.export(output, **LENS, progress=reports.append)) == len(FRAMES)
    assert [it.was_there for it in reports][:2] == [True, True]
    np.testing.assert_array_equal(source.render(**LENS), before)


def test_cancelled_movie_leaves_no_file(plates, tmp_path):
    output = tmp_path / "out" / "m.mov"
    assert heatlens.open(plates).export(output, **LENS, is_cancelled=lambda: True) == ()
    assert [path for path in output.parent.rglob("*.mov")] == []


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"compresion": "zip"}, "Did you mean compression"),
        ({"compression": "lzma"}, "compression is one of none, rle"),
        ({"force": 1}, "force must be True or False"),
        ({"frames": "5-"}, "5-"),
        ({"f_stop": "two"}, "f_stop must be a number"),
    ],
)
def test_export_refuses_options_in_words_of_python(plates, tmp_path, options, words):
    with pytest.raises(HeatlensError, match=words) as refusal:
        heatlens.open(plates).export(tmp_path / "n.####.exr", **options)
    assert "--" not in str(refusal.value)


def test_export_of_arrays_is_refused(tmp_path):
    source = heatlens.open(np.ones((6, 8, 3)), np.ones((6, 8)))
    with pytest.raises(HeatlensError, match="Arrays have no file"):
        source.export(tmp_path / "n.exr", **LENS)
