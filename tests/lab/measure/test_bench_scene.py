"""`heatlens bench --methods SCENE`: the row of README's table, frame by frame as study has it."""

import json
from pathlib import Path
from statistics import fmean

import numpy as np
import pytest

from heatlens.fronts.commands.main import main
from heatlens.lab.measure.metrics import score
from support.exports import exr

README = Path(__file__).resolve().parents[3] / "README.md"
SMALL = ("--size", "32x18", "--quality", "draft")
QUICK = ("bench", "--methods", *SMALL, "--truth-views", "70")
LENS = ("--f-stop", "1.4", "--focus-distance", "3")
BOARDS = """\
v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4
v 0 -1 -2\nv 3 -1 -2\nv 3 1 -2\nv 0 1 -2\nf 5 6 7 8
"""


pytestmark = pytest.mark.usefixtures("ctx")


def light_of(path: Path) -> np.ndarray:
    """Return the colours (H, W, 3) of an EXR."""
    channels = exr(path)[1]
    return np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float32)


@pytest.fixture
def boards(tmp_path: Path) -> str:
    """Return the file of a scene of two boards, one half behind the other."""
    path = tmp_path / "boards.obj"
    path.write_text(BOARDS)
    return str(path)


def refused(capsys, *words: str) -> str:
    assert main([*map(str, words)]) == 2
    said = capsys.readouterr()
    assert said.out == "" and "Traceback" not in said.err
    return said.err.splitlines()[-1]


def test_the_table_is_laid_out_as_the_readme_has_it(capsys, boards):
    assert main([*QUICK, boards, *LENS]) == 0
    rows = capsys.readouterr().out.splitlines()
    readme = README.read_text().splitlines()
    at = readme.index(rows[0])
    assert readme[at + 1] == rows[1] and len(rows) == 5
    for row, printed in zip(rows[2:], readme[at + 2 :], strict=False):
        assert row.split("|")[1] == printed.split("|")[1] and row.count("|") == rows[0].count("|")


def test_json_has_the_mean_of_every_frame(capsys):
    assert main([*QUICK, "demo", "--frames", "60,150", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == [60, 150] and (told["width"], told["height"]) == (32, 18)
    assert set(told["flip"]["the scene"]) > set(told["flip"]["one flat plate"]) >= {"diffusion"}
    for kind, row in told["flip"].items():
        for name, values in row.items():
            assert len(values) == 2 and min(values) > 0
            assert told["mean"][kind][name] == pytest.approx(fmean(values))
    mean = told["mean"]["the scene"]
    assert mean["accumulation 66"] < mean["accumulation 23"]  # of 70 views


def test_each_value_is_that_of_a_study_of_the_frame(capsys, tmp_path, boards):
    asked = ("bench", "--methods", boards, *SMALL, *LENS, "--truth-views", "264")
    assert main([*asked, "--json"]) == 0
    flip = json.loads(capsys.readouterr().out)["flip"]["the scene"]
    asked = ("study", boards, *SMALL, *LENS, "--views", "264", "--runs", "1")
    assert main([*asked, "--methods", "gather,diffusion", "-o", str(tmp_path / "r")]) == 0
    for row in json.loads((tmp_path / "r" / "study.json").read_text())["methods"]:
        assert flip[row["method"]][0] == pytest.approx(row["flip"], abs=1e-4)


@pytest.mark.parametrize(
    ("kind", "size"), [("one flat plate", (64, 36)), ("a plate twice as large, halved", (128, 72))]
)
def test_a_plate_is_what_render_makes_of_the_written_plate(capsys, tmp_path, boards, kind, size):
    """A user who writes the plate, blurs it and compares it finds the figure of the table."""
    lens = ("--focal-length", "50", "--sensor-width", "36", *LENS)
    asked = ("bench", "--methods", boards, "--size", "64x36", "--quality", "draft", *lens)
    assert main([*asked, "--truth-views", "70", "--json"]) == 0
    flip = json.loads(capsys.readouterr().out)["flip"][kind]["diffusion"][0]
    plate, blurred, truth = (tmp_path / f"{name}.exr" for name in ("plate", "blurred", "truth"))
    whole = ("--size", "x".join(map(str, size)))
    assert main(["render", boards, "--pinhole", "-o", str(plate), *whole, *lens, "--float"]) == 0
    draft = ("--quality", "draft", "--float")
    assert main(["render", str(plate), "-o", str(blurred), *lens, *draft]) == 0
    views = ("--method", "accumulation", "--views", "70", "--size", "64x36", "--float")
    assert main(["render", boards, "-o", str(truth), *lens, *views]) == 0
    times = size[0] // 64
    picture = light_of(blurred).reshape(36, times, 64, times, 3).mean(axis=(1, 3))
    assert score(picture, light_of(truth)).flip == pytest.approx(flip, abs=1e-3)


def test_a_shot_brings_its_lens_and_frames_are_spread_over_it(capsys, tmp_path):
    shot = str(tmp_path / "s.heatlens.json")
    assert main(["shot", "new", "demo", "-o", shot, "--frames", "60-61", "--f-stop", "8"]) == 0
    capsys.readouterr()
    assert main([*QUICK, shot, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == [60, 61]
    assert "cannot be given" in refused(capsys, *QUICK, shot, "--f-stop", "2")


def test_what_means_nothing_is_refused_in_words(capsys):
    assert "--methods" in refused(capsys, "bench", "demo")
    assert "needs a scene" in refused(capsys, "bench", "--methods", "--frames", "1-3")
    assert "is a plate" in refused(capsys, *QUICK, "plate.exr")
    assert "leave --bare out" in refused(capsys, *QUICK, "demo", "--bare")
    assert "999" in refused(capsys, *QUICK, "demo", "--frames", "999")
    assert "--truth-views" in refused(capsys, *QUICK[:-1], "66", "demo")
