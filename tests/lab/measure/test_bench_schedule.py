"""Test the duration estimate of a bench, which follows the measured times, and its progress."""

import io
import os
import pty
import re
import sys
from contextlib import suppress
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.pace import Pace, Step
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.output import progress_line
from heatlens.fronts.commands.output.progress_line import paced_progress
from heatlens.lab.measure.bench.schedule import RequestedBench, plan_steps
from heatlens.lab.measure.bench.timing import LIMIT_S

PLAN = st.lists(st.floats(0.01, 100.0), min_size=1, max_size=20)


class Clock:
    def __init__(self) -> None:
        self.now_s = 3.0

    def __call__(self) -> float:
        return self.now_s


def steps_of(seconds: list[float]) -> list[Step]:
    return [Step(f"part {number}", step_seconds) for number, step_seconds in enumerate(seconds)]


@given(PLAN, st.floats(0.05, 20.0))
def test_pace_estimate_converges_to_speed_of_machine(seconds, slower):
    """Every part takes `slower` times the planned time; the estimate converges to the truth."""
    clock = Clock()
    pace = Pace(steps_of(seconds), clock)
    assert pace.left_s == pytest.approx(sum(seconds)) and pace.number == 0
    errors = []
    for number, step_seconds in enumerate(seconds):
        assert pace.begin_if_step(f"part {number}") and pace.number == number + 1
        true_s = slower * sum(seconds[number:])
        errors.append(abs(pace.left_s - true_s) / true_s)
        clock.now_s += slower * step_seconds
        assert pace.left_s >= 0.0
    # Nothing but the first guess weighs against what was measured, and that ever less.
    assert all(b <= a + 1e-9 for a, b in pairwise(errors))
    clock.now_s += 100.0 * sum(seconds) * slower
    assert pace.left_s == 0.0


@given(st.floats(0.05, 20.0), st.floats(0.01, 100.0))
def test_pace_estimates_kinds_of_steps_separately(slower, other_s):
    clock = Clock()
    shader_steps = [Step(f"part {number}", 1.0, "shaders") for number in range(40)]
    pace = Pace([*shader_steps, Step("other", other_s, "pictures")], clock)
    for step in shader_steps:
        pace.begin_if_step(step.sentence)
        clock.now_s += slower
    pace.begin_if_step("other")
    assert pace.left_s == pytest.approx(other_s)
    assert pace.whole_s == pytest.approx(40 * slower + other_s)


def test_pace_skips_omitted_parts_and_ignores_other_messages():
    clock = Clock()
    pace = Pace(steps_of([10.0, 10.0, 10.0]), clock)
    pace.begin_if_step("part 0")
    clock.now_s += 10.0
    assert not pace.begin_if_step("left out: too large") and pace.number == 1
    assert pace.begin_if_step("part 2") and pace.number == 3
    assert pace.left_s == pytest.approx(10.0)
    assert not pace.begin_if_step("part 1")  # it has gone by


@pytest.mark.parametrize("part", ["frame", "bare", "sweeps", "methods", "levels"])
def test_plan_steps_gives_time_to_steps_of_each_part(part):
    nothing = RequestedBench(size=(640, 360), settings=DefocusSettings(), runs=3, frame=False)
    assert plan_steps(nothing, 1e-6) == ()
    words = {"levels": ("level 1", "level 2")} if part == "levels" else {part: True}
    request = RequestedBench((640, 360), DefocusSettings(), 3, **{"frame": False, **words})
    steps = plan_steps(request, 1e-6)
    assert steps and all(step.seconds > 0.0 for step in steps)
    slower_steps = plan_steps(request, 2e-6)
    assert [step.sentence for step in slower_steps] == [step.sentence for step in steps]
    assert all(b.seconds >= a.seconds for a, b in zip(steps, slower_steps, strict=True))


def test_plan_steps_caps_method_cells_at_time_limit():
    request = RequestedBench((640, 360), DefocusSettings(), 3, frame=False, methods=True)
    assert max(step.seconds for step in plan_steps(request, 10.0)) == LIMIT_S


WORDS = ("--size", "64x48", "--runs", "1", "--quality", "draft")
ALL = ("--bare", "--sweep-coc", "--methods", "--truth-views", "80", "--truth-size", "48x32")


def test_bench_progress_counts_every_planned_part(capsys, monkeypatch):
    """With all options, the numbers of the printed parts run from 1 to their count."""
    bench = "heatlens.lab.measure.bench"
    for name in ("measure", "schedule"):
        monkeypatch.setattr(f"{bench}.{name}.SWEEP_COC_PX", (2.0, 9.0))
        monkeypatch.setattr(f"{bench}.{name}.SWEEP_SIZES", ((32, 24),))
    for name in ("methods", "schedule"):
        monkeypatch.setattr(f"{bench}.{name}.METHOD_COC_PX", (5.0,))
    monkeypatch.setattr(progress_line, "shows_progress", lambda _: True)
    assert main(["bench", *WORDS, *ALL, "--json"]) == 0
    lines = [line for line in re.split(r"\r|\n", capsys.readouterr().err) if " of " in line]
    numbers = [line.partition(" (")[2].split(" of ") for line in lines if " left)" in line]
    counts = {int(rest.split(",")[0]) for _, rest in numbers}
    assert len(counts) == 1 and [int(n) for n, _ in numbers] == list(range(1, counts.pop() + 1))


def test_paced_progress_without_terminal_prints_only_lasting_lines(capsys):
    clock = Clock()
    with paced_progress(steps_of([60.0, 60.0]), clock) as report:
        report("part 0")
        clock.now_s += 120.0
        report("left out: something")
        report("part 1")  # the first estimate still has a weight
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.splitlines() == [
        "heatlens: this takes about 2 min; Ctrl-C ends it",
        "heatlens: left out: something",
        "heatlens: this takes longer here, about 4 min in all",
    ]


def test_paced_progress_on_terminal_rewrites_and_clears_line(monkeypatch):
    own_end, process_end = pty.openpty()
    with os.fdopen(process_end, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        with paced_progress(steps_of([1.0, 1.0]), Clock()) as report:
            report("part 0")
            report("part 1")
        monkeypatch.setattr(sys, "stderr", io.StringIO())
    os.set_blocking(own_end, False)
    terminal_text = ""
    with suppress(OSError):  # where all is read, there is nobody on the other side any more
        while part := os.read(own_end, 10_000):
            terminal_text += part.decode()
    os.close(own_end)
    assert terminal_text.count("\n") == 1  # how long it takes, and nothing else, stays
    assert "heatlens: part 0 (1 of 2" in terminal_text and terminal_text.endswith("\r\x1b[K")


def test_bench_first_reports_that_it_estimates_duration(capsys, monkeypatch):
    """The message comes before any rendering that could take long."""

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("heatlens.lab.commands.bench.probe_seconds_per_px", interrupt)
    with pytest.raises(KeyboardInterrupt):
        from heatlens.fronts.commands.command_parser import build_parser
        from heatlens.lab.commands import bench

        bench.run(build_parser().parse_args(["bench", *WORDS]))
    assert "finding out how long this takes" in capsys.readouterr().err
