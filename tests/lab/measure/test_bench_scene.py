"""Test `heatlens bench --methods SCENE`, which makes the table of the README frame by frame."""

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
    """Write a scene of two boards, one half hidden by the other. Return its path."""
    path = tmp_path / "boards.obj"
    path.write_text(BOARDS)
    return str(path)


def message_of_refusal(capsys, *words: str) -> str:
    assert main([*map(str, words)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and "Traceback" not in captured.err
    return captured.err.splitlines()[-1]


def test_bench_scene_table_has_layout_of_readme(capsys, boards):
    assert main([*QUICK, boards, *LENS]) == 0
    rows = capsys.readouterr().out.splitlines()
    readme = README.read_text().splitlines()
    start = readme.index(rows[0])
    assert readme[start + 1] == rows[1] and len(rows) == 5
    for row, readme_row in zip(rows[2:], readme[start + 2 :], strict=False):
        assert row.split("|")[1] == readme_row.split("|")[1] and row.count("|") == rows[0].count(
            "|"
        )


def test_bench_scene_json_has_frames_and_their_mean(capsys):
    assert main([*QUICK, "demo", "--frames", "60,150", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["frames"] == [60, 150] and (report["width"], report["height"]) == (32, 18)
    assert set(report["flip"]["the scene"]) > set(report["flip"]["one flat plate"]) >= {"diffusion"}
    for kind, row in report["flip"].items():
        for name, values in row.items():
            assert len(values) == 2 and min(values) > 0
            assert report["mean"][kind][name] == pytest.approx(fmean(values))
    mean = report["mean"]["the scene"]
    assert mean["accumulation 66"] < mean["accumulation 23"]  # of 70 views


def test_bench_scene_flip_equals_flip_of_study(capsys, tmp_path, boards):
    words = ("bench", "--methods", boards, *SMALL, *LENS, "--truth-views", "264")
    assert main([*words, "--json"]) == 0
    flip = json.loads(capsys.readouterr().out)["flip"]["the scene"]
    words = ("study", boards, *SMALL, *LENS, "--views", "264", "--runs", "1")
    assert main([*words, "--methods", "gather,diffusion", "-o", str(tmp_path / "r")]) == 0
    for row in json.loads((tmp_path / "r" / "study.json").read_text())["methods"]:
        assert flip[row["method"]][0] == pytest.approx(row["flip"], abs=1e-4)


@pytest.mark.parametrize(
    ("kind", "size"), [("one flat plate", (64, 36)), ("a plate twice as large, halved", (128, 72))]
)
def test_bench_scene_plate_flip_equals_render_of_written_plate(
    capsys, tmp_path, boards, kind, size
):
    """A user who writes the plate, blurs it and compares it finds the figure of the table."""
    lens = ("--focal-length", "50", "--sensor-width", "36", *LENS)
    words = ("bench", "--methods", boards, "--size", "64x36", "--quality", "draft", *lens)
    assert main([*words, "--truth-views", "70", "--json"]) == 0
    flip = json.loads(capsys.readouterr().out)["flip"][kind]["diffusion"][0]
    plate, blurred, truth = (tmp_path / f"{name}.exr" for name in ("plate", "blurred", "truth"))
    size_option = ("--size", "x".join(map(str, size)))
    assert (
        main(["render", boards, "--pinhole", "-o", str(plate), *size_option, *lens, "--float"]) == 0
    )
    draft = ("--quality", "draft", "--float")
    assert main(["render", str(plate), "-o", str(blurred), *lens, *draft]) == 0
    views = ("--method", "accumulation", "--views", "70", "--size", "64x36", "--float")
    assert main(["render", boards, "-o", str(truth), *lens, *views]) == 0
    times = size[0] // 64
    picture = light_of(blurred).reshape(36, times, 64, times, 3).mean(axis=(1, 3))
    assert score(picture, light_of(truth)).flip == pytest.approx(flip, abs=1e-3)


def test_bench_scene_of_shot_uses_its_lens_and_frames(capsys, tmp_path, small_demo):
    shot = str(tmp_path / "s.heatlens.json")
    assert main(["shot", "new", "demo", "-o", shot, "--frames", "60-61", "--f-stop", "8"]) == 0
    capsys.readouterr()
    assert main([*QUICK, shot, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == [60, 61]
    assert "cannot be given" in message_of_refusal(capsys, *QUICK, shot, "--f-stop", "2")


def test_bench_scene_rejects_meaningless_options(capsys):
    assert "--methods" in message_of_refusal(capsys, "bench", "demo")
    assert "needs a scene" in message_of_refusal(capsys, "bench", "--methods", "--frames", "1-3")
    assert "is a plate" in message_of_refusal(capsys, *QUICK, "plate.exr")
    assert "leave --bare out" in message_of_refusal(capsys, *QUICK, "demo", "--bare")
    assert "999" in message_of_refusal(capsys, *QUICK, "demo", "--frames", "999")
    assert "--truth-views" in message_of_refusal(capsys, *QUICK[:-1], "66", "demo")
