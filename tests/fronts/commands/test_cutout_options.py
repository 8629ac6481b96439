"""Test `--never-blur` and `--only-blur` in pictures, shots, exports and Python."""

import numpy as np
import pytest

import heatlens
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.exr.exr_read import read_parts
from support.exports import CAMERA
from support.exr_files import write_file
from support.plates import room

SIZE = 32, 18
CARD = np.s_[6:12, 20:27]  # on the ball and before the ground, both out of focus
NEAREST = ("--flat-depth", "nearest:objectId:7")
LENS = ("--focus-distance", "0.9", "--f-stop", "1.4", "--bokeh", "heat")
NEVER = ("--never-blur", "objectId:7", *NEAREST)


@pytest.fixture
def plate(tmp_path):
    color, depth = room(*SIZE)
    ids = np.zeros(depth.shape, "u4")
    ids[CARD] = 7
    planes = {n: np.ascontiguousarray(color[..., i], "f4") for i, n in enumerate("RGB")}
    return write_file(tmp_path / "p.1001.exr", planes | {"Z": depth, "objectId": ids}, **CAMERA)


def pixels(path):
    (_, planes), *_ = read_parts(path)
    return np.stack([planes[name] for name in "RGB"], axis=-1)


def run(*words):
    assert main([str(word) for word in words]) == 0


def test_never_blur_is_same_in_render_shot_export_and_python(plate, tmp_path):
    run("render", plate, "-o", tmp_path / "r.exr", *LENS, *NEVER)
    run("render", plate, "-o", tmp_path / "all.exr", *LENS, *NEAREST)
    sharp, plate_pixels = pixels(tmp_path / "r.exr"), pixels(plate)
    np.testing.assert_array_equal(sharp[CARD], plate_pixels[CARD].astype(np.float16))
    assert np.abs(pixels(tmp_path / "all.exr")[CARD] - plate_pixels[CARD]).max() > 0.02
    shot = tmp_path / "s.heatlens.json"
    run("shot", "new", plate, "-o", shot, *LENS, *NEVER)
    assert read_shot(shot).plate_options.never_blur == "objectId:7"
    run("export", shot, "-o", tmp_path / "e.####.exr")
    np.testing.assert_array_equal(pixels(tmp_path / "e.1001.exr"), sharp)
    with heatlens.open(plate, never_blur="objectId:7", flat_depth="nearest:objectId:7") as source:
        rendered = source.render(focus_distance_m=0.9, f_stop=1.4, bokeh="heat")
    np.testing.assert_array_equal(np.float16(rendered[..., :3]), sharp)


def test_export_renders_again_after_change_of_cutout_options(plate, tmp_path, capsys):
    shot, pictures = tmp_path / "s.heatlens.json", []
    for words in (NEVER, ("--only-blur", "objectId:7"), ()):
        run("shot", "new", plate, "-o", shot, "--overwrite", *LENS, *words)
        run("export", shot, "-o", tmp_path / "e.####.exr")
        write_time = (tmp_path / "e.1001.exr").stat().st_mtime_ns
        run("export", shot, "-o", tmp_path / "e.####.exr")
        assert (tmp_path / "e.1001.exr").stat().st_mtime_ns == write_time
        if words:
            capsys.readouterr()
            run("shot", "show", shot)
            assert words[0][2:].replace("-", " ") in capsys.readouterr().out
        pictures.append(pixels(tmp_path / "e.1001.exr"))
    assert (
        min(np.abs(pictures[0] - pictures[1]).max(), np.abs(pictures[2] - pictures[1]).max()) > 0.02
    )
