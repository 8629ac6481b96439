"""`heatlens export --submit openjd`: a template that is valid, and that a farm can run."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.deliver.farm.job import FRAMES, FarmJob, Measured, Needs, Place, Step, parts_of
from heatlens.deliver.farm.openjd import _yaml, job_template
from heatlens.fronts.commands.main import main
from heatlens.media.sequence.names import parse_frames
from heatlens.version import __version__
from support.cube_config import cube_config
from support.exports import exported, files_in, refused, write_shot_file
from support.exr_files import write_file

BIN = Path(sys.executable).parent  # where the commands of this environment are


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return a shot, in the working folder."""
    write_shot_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def submitted(capsys, *words: str) -> tuple[str, str]:
    """Return the template, and what is said beside it; nothing is measured."""
    more = [] if "--chunk" in words else ["--chunk", "10"]
    assert main(["export", *words, *more, "--memory", "1", "--submit", "openjd"]) == 0
    said = capsys.readouterr()
    return said.out, said.err


def openjd(*words: object) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    command = [BIN / "openjd", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60)


def arguments(template: str) -> list[str]:
    return yaml.safe_load(template)["steps"][0]["script"]["actions"]["onRun"]["args"]


def test_the_template_runs_here_from_end_to_end_and_twice_the_same(capsys, folder):
    words = ("s.heatlens.json", "-o", "out/n.####.exr", "--bokeh", "gaussian", "--chunk", "4")
    template, said = submitted(capsys, *words)
    assert "6 frames in 2 tasks" in said and not (folder / "out").exists()
    (folder / "job.yaml").write_text(template)
    run = openjd("run", "job.yaml")
    assert run.returncode == 0, run.stdout
    assert "Chunks run: 2" in run.stdout or "Tasks run: 2" in run.stdout
    assert "openjd_progress: 100.0" in run.stdout
    exported(capsys, "s.heatlens.json", "whole/n.####.exr", "--bokeh", "gaussian")
    assert files_in(folder / "out") == files_in(folder / "whole")
    assert "6 were finished before" in exported(
        capsys, "s.heatlens.json", "out/n.####.exr", "--bokeh", "gaussian"
    )


def test_a_task_that_fails_says_why(capsys, folder):
    template, _ = submitted(capsys, "s.heatlens.json", "-o", "out/n.####.exr")
    (folder / "job.yaml").write_text(template)
    (folder / "plates" / "plate.1002.exr").write_bytes(b"")
    run = openjd("run", "job.yaml")
    assert run.returncode != 0
    assert "openjd_fail" in run.stdout and "plate.1002.exr is empty" in run.stdout
    assert not (folder / "out").exists() or not files_in(folder / "out")  # it was seen at once


def test_paths_are_parameters_and_options_are_as_they_were_typed(capsys, folder, session_context):
    config = cube_config(folder).source
    words = ("-o", "out/n.####.png", "--frames", "1001-1006x2", "--exposure=-0.5", "--burn-in")
    more = ("--quality", "preview", "--ocio", config, "--missing", "hold")
    template, said = submitted(capsys, "s.heatlens.json", *words, *more)
    job = yaml.safe_load(template)
    assert job["specificationVersion"] == "jobtemplate-2023-09"
    assert {
        p["name"]: (p["type"], p["dataFlow"], p["default"]) for p in job["parameterDefinitions"]
    } == {
        "Shot": ("PATH", "IN", "s.heatlens.json"),
        "Plates": ("PATH", "IN", "plates"),
        "Out": ("PATH", "OUT", "out"),
        "Config": ("PATH", "IN", "studio.ocio"),
    }
    first = ["export", "{{Param.Shot}}", "--plate={{Param.Plates}}/plate.####.exr"]
    assert arguments(template)[:4] == [*first, "--output={{Param.Out}}/n.####.png"]
    assert set(arguments(template)[4:]) == {
        "--missing=hold",
        "--exposure=-0.5",
        "--burn-in",
        "--quality=preview",
        "--ocio={{Param.Config}}",
        "--frames=1001-1005x2",
        "--part={{Task.Param.Frames}}",
        f"--expect={__version__}/{session_context.name}",
        "--progress=openjd",
    }
    assert said.count("\n") == 1
    (folder / "job.yaml").write_text(template)
    assert openjd("check", "job.yaml").returncode == 0


def test_plates_with_a_lens_of_their_own_are_submitted_too(capsys, folder):
    words = ("plates/plate.####.exr", "-o", "n.####.exr", "--focus-distance", "6'3\"")
    template, _ = submitted(capsys, *words, "--f-stop", "2.8")
    args = arguments(template)
    assert args[:2] == ["export", "{{Param.Plates}}/plate.####.exr"]
    assert "--focus-distance=6'3\"" in args and "--f-stop=2.8" in args


def test_what_lies_elsewhere_is_given_when_the_job_is_sent(capsys, folder, tmp_path, monkeypatch):
    """A template may hold no absolute path, and none above itself."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    template, said = submitted(capsys, str(folder / "s.heatlens.json"), "-o", "n.####.exr")
    definitions = {p["name"]: p for p in yaml.safe_load(template)["parameterDefinitions"]}
    assert "default" not in definitions["Shot"] and definitions["Out"]["default"] == "."
    assert f"-p Shot={folder / 's.heatlens.json'}" in said
    assert f"-p Plates={folder / 'plates'}" in said and "-p Out" not in said
    (tmp_path / "here" / "job.yaml").write_text(template)
    values = (f"Shot={folder / 's.heatlens.json'}", f"Plates={folder / 'plates'}")
    given_paths = [word for value in values for word in ("-p", value)]
    run = openjd("run", "job.yaml", *given_paths, "--maximum-tasks", "1")
    assert run.returncode == 0, run.stdout
    assert len([name for name in files_in(tmp_path / "here") if name.endswith(".exr")]) == 6


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("-o", "m.mov", "--force"), "--force"),
        (("-o", "m.mov", "--display", "Display P3 - Display"), "Rec.709"),
        (("-o", "n.####.exr", "--chunk", "0"), "--chunk"),
        (("-o", "new\nline.####.exr"), "printable"),
        (("-o", "n.####.exr", "--frames", "1000-1001"), "1000"),
        (("-o", "{{n}}.####.png"), "{{"),
    ],
)
def test_what_cannot_be_submitted(capsys, folder, words, expected):
    _, out, *more = words
    told = ("--memory", "1", *(() if "--chunk" in more else ("--chunk", "2")))
    assert expected in refused(capsys, "s.heatlens.json", out, *more, *told, "--submit", "openjd")


@given(st.sets(st.integers(-50, 3000), min_size=1, max_size=200), st.integers(1, 250))
def test_parts_are_all_the_frames_in_order(frames, chunk):
    ordered = sorted(frames)
    texts = parts_of(ordered, chunk)
    groups = [parse_frames(text) for text in texts]
    assert [frame for group in groups for frame in group] == ordered
    assert all(len(group) == chunk for group in groups[:-1]) and len(groups[-1]) <= chunk


@given(st.floats(0.1, 30.0), st.floats(0.001, 1000.0), st.integers(1, 1 << 36))
def test_a_task_takes_about_a_minute_and_has_memory_to_spare(start_s, frame_s, memory):
    cost = Measured(start_s, frame_s, memory)
    (first, *_) = parts_of(range(1, 100_001), None, cost)
    took_s = start_s + len(parse_frames(first)) * frame_s
    assert took_s <= 60.001 + 2 * frame_s and (took_s > 60 - frame_s or frame_s <= 0.001)
    assert memory * 1.25 <= cost.memory_gib << 30 < memory * 1.25 + (1 << 30)


def job_of(parts: int, joins: bool = False, name: str = "n") -> FarmJob:
    place = Place("Out", Path("/x/out"), "DIRECTORY", "OUT")
    texts = tuple(map(str, range(1, parts + 1)))
    words = (("export",), ("--output=", place, "/n.exr"), ("--part=", FRAMES))
    last = Step("Join", words[:-1]) if joins else None
    return FarmJob(name, (place,), (Step("Export", words, texts),), last, Needs(2, 2, 1), ())


def test_more_tasks_than_a_step_has_are_several_steps():
    """The limit of the schema is 1,024; the last step waits for each."""
    template = job_template(job_of(2500, joins=True), Path("/x"))
    *made, last = yaml.safe_load(template)["steps"]
    ranges = [step["parameterSpace"]["taskParameterDefinitions"][0]["range"] for step in made]
    assert [len(texts) for texts in ranges] == [1024, 1024, 452]
    assert [text for texts in ranges for text in texts] == [str(n) for n in range(1, 2501)]
    assert [it["dependsOn"] for it in last["dependencies"]] == [step["name"] for step in made]
    assert "parameterSpace" not in last
    with pytest.raises(InputError, match="larger --chunk"):
        job_template(job_of(102_401), Path("/x"))


def test_a_task_asks_for_what_it_needs():
    (step,) = yaml.safe_load(job_template(job_of(1), Path("/x")))["steps"]
    told = {it["name"]: it["min"] for it in step["hostRequirements"]["amounts"]}
    assert told == {"amount.worker.vcpu": 2, "amount.worker.memory": 2048, "amount.worker.gpu": 1}


def test_ten_thousand_frames_are_one_short_text():
    parts = parts_of(range(1001, 11_001), 1)
    assert len(parts) == 10_000
    text = job_template(job_of(10_000, joins=True), Path("/x"))
    assert len(text) < 1_000_000


TEXTS = st.text(st.characters(exclude_categories=("C", "Z")) | st.just(" "), max_size=8)
NAMES = st.from_regex(r"[A-Za-z]{1,8}", fullmatch=True).filter(
    lambda name: name.lower() not in ("on", "off", "yes", "no", "true", "false", "null", "y", "n")
)


@given(
    st.recursive(
        TEXTS,
        lambda inner: (
            st.lists(inner, min_size=1, max_size=3)
            | st.dictionaries(NAMES, inner, min_size=1, max_size=3)
        ),
        max_leaves=12,
    )
)
def test_the_yaml_is_what_was_meant(value):
    assert yaml.safe_load("\n".join(_yaml(value))) == value


def test_a_long_name_is_cut_to_what_the_schema_allows():
    template = yaml.safe_load(job_template(job_of(1, name="n" * 300), Path("/x")))
    assert len(template["name"]) == 128


def test_what_a_task_needs_is_measured_and_leaves_nothing(capsys, folder):
    before = sorted(folder.iterdir())
    assert main(["export", "s.heatlens.json", "-o", "m.mov", "--submit", "openjd"]) == 0
    said = capsys.readouterr()
    export, join = yaml.safe_load(said.out)["steps"]
    told = {it["name"]: it["min"] for it in export["hostRequirements"]["amounts"]}
    assert told["amount.worker.memory"] >= 1024 and told["amount.worker.vcpu"] == 2
    assert "a frame takes" in said.err and join["hostRequirements"] == export["hostRequirements"]
    assert sorted(folder.iterdir()) == before


def test_a_first_frame_that_fails_is_told_at_once(capsys, folder):
    for path in (folder / "plates").iterdir():
        write_file(path, {name: np.ones((18, 32), np.float16) for name in "RGB"})
    said = refused(capsys, "s.heatlens.json", "n.####.exr", "--submit", "openjd")
    assert "first frame" in said and "plate.1001.exr" in said and not (folder / "out").exists()
