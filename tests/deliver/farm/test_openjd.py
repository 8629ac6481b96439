"""Test `heatlens export --submit openjd`: the template is valid and can be run."""

import math
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
from heatlens.deliver.farm.job import (
    FRAMES,
    FarmJob,
    MeasuredCost,
    Needs,
    Place,
    Step,
    cost_of_run,
    group_frames,
)
from heatlens.deliver.farm.openjd import _yaml_lines, job_template
from heatlens.fronts.commands.main import main
from heatlens.media.sequence.names import parse_frames
from heatlens.version import __version__
from support.cube_config import cube_config
from support.exports import export_shot, files_in, refused_export_message, write_shot_file
from support.exr_files import write_file
from support.patience import PATIENCE_S

BIN = Path(sys.executable).parent  # where the commands of this environment are


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Write a shot into a temporary folder and make that the current folder."""
    write_shot_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def submit_openjd(capsys, *words: str) -> tuple[str, str]:
    """Submit an export without measuring it. Return the template and the messages on stderr."""
    chunk_options = [] if "--chunk" in words else ["--chunk", "10"]
    assert main(["export", *words, *chunk_options, "--memory", "1", "--submit", "openjd"]) == 0
    captured = capsys.readouterr()
    return captured.out, captured.err


def openjd(*words: object) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    command = [BIN / "openjd", *map(str, words)]
    return subprocess.run(
        command, capture_output=True, text=True, env=environment, timeout=PATIENCE_S
    )


def arguments(template: str) -> list[str]:
    return yaml.safe_load(template)["steps"][0]["script"]["actions"]["onRun"]["args"]


@pytest.mark.parametrize(
    ("frame_ends_s", "start_s", "frame_s"),
    [
        ((4.5, 5.9, 5.95), 1.7, 1.4),  # two frames before the first report, then one more
        ((3.0, 3.1), 0.0, 1.55),  # nothing tells the start from the frames
        ((2.0,), 0.0, 2.0),
    ],
)
def test_cost_of_run_takes_frame_between_first_two_reports(frame_ends_s, start_s, frame_s):
    events = [(at_s, {"event": "frame"}) for at_s in frame_ends_s]
    cost = cost_of_run([*events, (9.0, {"event": "end"})], 7)
    assert cost.memory_bytes == 7
    assert (cost.start_s, cost.frame_s) == pytest.approx((start_s, frame_s))


def test_openjd_template_runs_and_gives_files_of_export(capsys, folder):
    words = ("s.heatlens.json", "-o", "out/n.####.exr", "--bokeh", "gaussian", "--chunk", "4")
    template, message = submit_openjd(capsys, *words)
    assert "6 frames in 2 tasks" in message and not (folder / "out").exists()
    (folder / "job.yaml").write_text(template)
    run = openjd("run", "job.yaml")
    assert run.returncode == 0, run.stdout
    assert "Chunks run: 2" in run.stdout or "Tasks run: 2" in run.stdout
    assert "openjd_progress: 100.0" in run.stdout
    export_shot(capsys, "s.heatlens.json", "whole/n.####.exr", "--bokeh", "gaussian")
    assert files_in(folder / "out") == files_in(folder / "whole")
    assert "6 were finished before" in export_shot(
        capsys, "s.heatlens.json", "out/n.####.exr", "--bokeh", "gaussian"
    )


def test_failing_openjd_task_reports_reason(capsys, folder):
    template, _ = submit_openjd(capsys, "s.heatlens.json", "-o", "out/n.####.exr")
    (folder / "job.yaml").write_text(template)
    (folder / "plates" / "plate.1002.exr").write_bytes(b"")
    run = openjd("run", "job.yaml")
    assert run.returncode != 0
    assert "openjd_fail" in run.stdout and "plate.1002.exr is empty" in run.stdout
    assert not (folder / "out").exists() or not files_in(folder / "out")  # it was seen at once


def test_openjd_template_has_path_parameters_and_typed_options(capsys, folder, session_context):
    config = cube_config(folder).source
    words = ("-o", "out/n.####.png", "--frames", "1001-1006x2", "--exposure=-0.5", "--burn-in")
    look_options = ("--quality", "preview", "--ocio", config, "--missing", "hold")
    template, message = submit_openjd(capsys, "s.heatlens.json", *words, *look_options)
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
    assert message.count("\n") == 1
    (folder / "job.yaml").write_text(template)
    assert openjd("check", "job.yaml").returncode == 0


def test_submit_of_plates_keeps_lens_options(capsys, folder):
    words = ("plates/plate.####.exr", "-o", "n.####.exr", "--focus-distance", "6'3\"")
    template, _ = submit_openjd(capsys, *words, "--f-stop", "2.8")
    args = arguments(template)
    assert args[:2] == ["export", "{{Param.Plates}}/plate.####.exr"]
    assert "--focus-distance=6'3\"" in args and "--f-stop=2.8" in args


def test_openjd_paths_outside_folder_are_given_at_submission(capsys, folder, tmp_path, monkeypatch):
    """A template may hold no absolute path and no path above its own folder."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    template, message = submit_openjd(capsys, str(folder / "s.heatlens.json"), "-o", "n.####.exr")
    definitions = {p["name"]: p for p in yaml.safe_load(template)["parameterDefinitions"]}
    assert "default" not in definitions["Shot"] and definitions["Out"]["default"] == "."
    assert f"-p Shot={folder / 's.heatlens.json'}" in message
    assert f"-p Plates={folder / 'plates'}" in message and "-p Out" not in message
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
def test_submit_rejects_impossible_options(capsys, folder, words, expected):
    _, out, *options = words
    submit_options = ("--memory", "1", *(() if "--chunk" in options else ("--chunk", "2")))
    assert expected in refused_export_message(
        capsys, "s.heatlens.json", out, *options, *submit_options, "--submit", "openjd"
    )


@given(st.sets(st.integers(-50, 3000), min_size=1, max_size=200), st.integers(1, 250))
def test_task_parts_split_frames_into_ordered_chunks(frames, chunk):
    ordered = sorted(frames)
    texts = group_frames(ordered, chunk)
    groups = [parse_frames(text) for text in texts]
    assert [frame for group in groups for frame in group] == ordered
    assert all(len(group) == chunk for group in groups[:-1]) and len(groups[-1]) <= chunk


@given(st.floats(0.1, 30.0), st.floats(0.001, 1000.0), st.integers(1, 1 << 36))
def test_group_frames_of_measured_job_gives_parts_of_a_minute_with_spare_memory(
    start_s, frame_s, memory
):
    cost = MeasuredCost(start_s, frame_s, memory)
    more_than_a_part = range(1, 2 * math.ceil(60 / frame_s) + 10)
    (first, *_) = group_frames(more_than_a_part, None, cost)
    took_s = start_s + len(parse_frames(first)) * frame_s
    assert took_s <= 60.001 + 2 * frame_s and (took_s > 60 - frame_s or frame_s <= 0.001)
    assert memory * 1.25 <= cost.memory_gib << 30 < memory * 1.25 + (1 << 30)


def job_of(parts: int, joins: bool = False, name: str = "n") -> FarmJob:
    place = Place("Out", Path("/x/out"), "DIRECTORY", "OUT")
    texts = tuple(map(str, range(1, parts + 1)))
    words = (("export",), ("--output=", place, "/n.exr"), ("--part=", FRAMES))
    join_step = Step("Join", words[:-1]) if joins else None
    return FarmJob(
        name,
        places=(place,),
        steps=(Step("Export", words, texts),),
        last=join_step,
        needs=Needs(memory_gib=2, processors=2, gpus=1),
        inputs=(),
    )


def test_job_template_splits_more_than_1024_tasks_into_steps():
    """The limit of the schema is 1,024; the last step waits for each."""
    template = job_template(job_of(2500, joins=True), Path("/x"))
    *export_steps, join_step = yaml.safe_load(template)["steps"]
    ranges = [
        step["parameterSpace"]["taskParameterDefinitions"][0]["range"] for step in export_steps
    ]
    assert [len(texts) for texts in ranges] == [1024, 1024, 452]
    assert [text for texts in ranges for text in texts] == [str(n) for n in range(1, 2501)]
    assert [it["dependsOn"] for it in join_step["dependencies"]] == [
        step["name"] for step in export_steps
    ]
    assert "parameterSpace" not in join_step
    with pytest.raises(InputError, match="larger --chunk"):
        job_template(job_of(102_401), Path("/x"))


def test_job_template_requests_cpus_memory_and_gpu():
    (step,) = yaml.safe_load(job_template(job_of(1), Path("/x")))["steps"]
    amounts = {it["name"]: it["min"] for it in step["hostRequirements"]["amounts"]}
    assert amounts == {
        "amount.worker.vcpu": 2,
        "amount.worker.memory": 2048,
        "amount.worker.gpu": 1,
    }


def test_job_template_of_10_000_frames_is_below_1_mb():
    parts = group_frames(range(1001, 11_001), 1)
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
def test_yaml_writer_output_parses_to_same_value(value):
    assert yaml.safe_load("\n".join(_yaml_lines(value))) == value


def test_job_template_truncates_name_to_128_characters():
    template = yaml.safe_load(job_template(job_of(1, name="n" * 300), Path("/x")))
    assert len(template["name"]) == 128


def test_submit_measures_memory_of_task_and_leaves_no_files(capsys, folder):
    files_before = sorted(folder.iterdir())
    assert main(["export", "s.heatlens.json", "-o", "m.mov", "--submit", "openjd"]) == 0
    captured = capsys.readouterr()
    export, join = yaml.safe_load(captured.out)["steps"]
    amounts = {it["name"]: it["min"] for it in export["hostRequirements"]["amounts"]}
    assert amounts["amount.worker.memory"] >= 1024 and amounts["amount.worker.vcpu"] == 2
    assert (
        "a frame takes" in captured.err and join["hostRequirements"] == export["hostRequirements"]
    )
    assert sorted(folder.iterdir()) == files_before


def test_submit_reports_failing_first_frame(capsys, folder):
    for path in (folder / "plates").iterdir():
        write_file(path, {name: np.ones((18, 32), np.float16) for name in "RGB"})
    message = refused_export_message(capsys, "s.heatlens.json", "n.####.exr", "--submit", "openjd")
    assert (
        "first frame" in message and "plate.1001.exr" in message and not (folder / "out").exists()
    )
