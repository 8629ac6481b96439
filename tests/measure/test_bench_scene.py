"""`heatlens bench --methods SCENE`: the row of README's table, frame by frame as study has it."""

import json
from pathlib import Path
from statistics import fmean

import pytest

from heatlens.commands.main import main

README = Path(__file__).resolve().parents[2] / "README.md"
SMALL = ("--size", "32x18", "--quality", "draft")
QUICK = ("bench", "--methods", *SMALL, "--truth-views", "70")
LENS = ("--f-stop", "1.4", "--focus-distance", "3")
BOARDS = """\
v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4
v 0 -1 -2\nv 3 -1 -2\nv 3 1 -2\nv 0 1 -2\nf 5 6 7 8
"""


pytestmark = pytest.mark.usefixtures("ctx")


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


def test_the_table_has_the_columns_of_the_readme(capsys, boards):
    assert main([*QUICK, boards, *LENS]) == 0
    head, line, row = capsys.readouterr().out.splitlines()
    readme = README.read_text().splitlines()
    assert head in readme and readme[readme.index(head) + 1] == line
    assert row.startswith(f"| {boards} | ") and row.count("|") == head.count("|")


def test_json_has_the_mean_of_every_frame(capsys):
    assert main([*QUICK, "demo", "--frames", "60,150", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == [60, 150] and (told["width"], told["height"]) == (32, 18)
    for name, values in told["flip"].items():
        assert len(values) == 2 and min(values) > 0
        assert told["mean"][name] == pytest.approx(fmean(values))
    mean = told["mean"]
    assert mean["accumulation 66"] < mean["accumulation 23"]  # of 70 views


def test_each_value_is_that_of_a_study_of_the_frame(capsys, tmp_path, boards):
    asked = ("bench", "--methods", boards, *SMALL, *LENS, "--truth-views", "264")
    assert main([*asked, "--json"]) == 0
    flip = json.loads(capsys.readouterr().out)["flip"]
    asked = ("study", boards, *SMALL, *LENS, "--views", "264", "--runs", "1")
    assert main([*asked, "--methods", "gather,diffusion", "-o", str(tmp_path / "r")]) == 0
    for row in json.loads((tmp_path / "r" / "study.json").read_text())["methods"]:
        assert flip[row["method"]][0] == pytest.approx(row["flip"], abs=1e-4)


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
