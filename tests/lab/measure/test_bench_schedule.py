"""How long a bench will take: the estimate follows what was measured, and progress is told."""

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
from heatlens.lab.measure.bench.schedule import Asked, planned
from heatlens.lab.measure.bench.timing import LIMIT_S

PLAN = st.lists(st.floats(0.01, 100.0), min_size=1, max_size=20)


class Clock:
    def __init__(self) -> None:
        self.now_s = 3.0

    def __call__(self) -> float:
        return self.now_s


def steps_of(seconds: list[float]) -> list[Step]:
    return [Step(f"part {number}", it) for number, it in enumerate(seconds)]


@given(PLAN, st.floats(0.05, 20.0))
def test_a_machine_so_many_times_as_slow_is_found_out(seconds, slower):
    """Every part takes `slower` times what was planned: the estimate comes to that, and to 0."""
    clock = Clock()
    pace = Pace(steps_of(seconds), clock)
    assert pace.left_s == pytest.approx(sum(seconds)) and pace.number == 0
    errors = []
    for number, it in enumerate(seconds):
        assert pace.begin(f"part {number}") and pace.number == number + 1
        true_s = slower * sum(seconds[number:])
        errors.append(abs(pace.left_s - true_s) / true_s)
        clock.now_s += slower * it
        assert pace.left_s >= 0.0
    # Nothing but the first guess weighs against what was measured, and that ever less.
    assert all(b <= a + 1e-9 for a, b in pairwise(errors))
    clock.now_s += 100.0 * sum(seconds) * slower
    assert pace.left_s == 0.0


@given(st.floats(0.05, 20.0), st.floats(0.01, 100.0))
def test_how_slow_one_kind_is_says_nothing_of_another(slower, other_s):
    clock = Clock()
    of_one = [Step(f"part {number}", 1.0, "shaders") for number in range(40)]
    pace = Pace([*of_one, Step("other", other_s, "pictures")], clock)
    for step in of_one:
        pace.begin(step.sentence)
        clock.now_s += slower
    pace.begin("other")
    assert pace.left_s == pytest.approx(other_s)
    assert pace.whole_s == pytest.approx(40 * slower + other_s)


def test_parts_that_are_left_out_and_sentences_that_are_no_part():
    clock = Clock()
    pace = Pace(steps_of([10.0, 10.0, 10.0]), clock)
    pace.begin("part 0")
    clock.now_s += 10.0
    assert not pace.begin("left out: too large") and pace.number == 1
    assert pace.begin("part 2") and pace.number == 3
    assert pace.left_s == pytest.approx(10.0)
    assert not pace.begin("part 1")  # it has gone by


@pytest.mark.parametrize("part", ["frame", "bare", "sweeps", "methods", "levels"])
def test_every_part_that_is_asked_for_takes_time(part):
    nothing = Asked((640, 360), DefocusSettings(), 3, frame=False)
    assert planned(nothing, 1e-6) == ()
    words = {"levels": ("level 1", "level 2")} if part == "levels" else {part: True}
    asked = Asked((640, 360), DefocusSettings(), 3, **{"frame": False, **words})
    found = planned(asked, 1e-6)
    assert found and all(step.seconds > 0.0 for step in found)
    slower = planned(asked, 2e-6)
    assert [step.sentence for step in slower] == [step.sentence for step in found]
    assert all(b.seconds >= a.seconds for a, b in zip(found, slower, strict=True))


def test_a_cell_of_methods_takes_no_longer_than_it_may():
    asked = Asked((640, 360), DefocusSettings(), 3, frame=False, methods=True)
    assert max(step.seconds for step in planned(asked, 10.0)) == LIMIT_S


WORDS = ("--size", "64x48", "--runs", "1", "--quality", "draft")
ALL = ("--bare", "--sweep-coc", "--methods", "--truth-views", "80", "--truth-size", "48x32")


def test_what_is_planned_is_what_is_said(capsys, monkeypatch):
    """With everything asked for, each part is told as a part, and the last one is the last."""
    bench = "heatlens.lab.measure.bench"
    for name in ("measure", "schedule"):
        monkeypatch.setattr(f"{bench}.{name}.SWEEP_COC_PX", (2.0, 9.0))
        monkeypatch.setattr(f"{bench}.{name}.SWEEP_SIZES", ((32, 24),))
    for name in ("methods", "schedule"):
        monkeypatch.setattr(f"{bench}.{name}.METHOD_COC_PX", (5.0,))
    monkeypatch.setattr(progress_line, "shows_progress", lambda _: True)
    assert main(["bench", *WORDS, *ALL, "--json"]) == 0
    told = [line for line in re.split(r"\r|\n", capsys.readouterr().err) if " of " in line]
    numbers = [line.partition(" (")[2].split(" of ") for line in told if " left)" in line]
    counts = {int(rest.split(",")[0]) for _, rest in numbers}
    assert len(counts) == 1 and [int(n) for n, _ in numbers] == list(range(1, counts.pop() + 1))


def test_without_a_terminal_what_stays_is_told_alone(capsys):
    clock = Clock()
    with paced_progress(steps_of([60.0, 60.0]), clock) as tell:
        tell("part 0")
        clock.now_s += 120.0
        tell("left out: something")
        tell("part 1")  # the first estimate still has a weight
    said = capsys.readouterr()
    assert said.out == "" and said.err.splitlines() == [
        "heatlens: this takes about 2 min; Ctrl-C ends it",
        "heatlens: left out: something",
        "heatlens: this takes longer here, about 4 min in all",
    ]


def test_on_a_terminal_one_line_is_rewritten_and_wiped(monkeypatch):
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        with paced_progress(steps_of([1.0, 1.0]), Clock()) as tell:
            tell("part 0")
            tell("part 1")
        monkeypatch.setattr(sys, "stderr", io.StringIO())
    os.set_blocking(ours, False)
    said = ""
    with suppress(OSError):  # where all is read, there is nobody on the other side any more
        while part := os.read(ours, 10_000):
            said += part.decode()
    os.close(ours)
    assert said.count("\n") == 1  # how long it takes, and nothing else, stays
    assert "heatlens: part 0 (1 of 2" in said and said.endswith("\r\x1b[K")


def test_it_says_at_once_that_it_finds_out(capsys, monkeypatch):
    """Before anything is rendered that could take long."""
    monkeypatch.setattr(
        "heatlens.lab.commands.bench.probe_seconds_per_px",
        lambda *_: (_ for _ in ()).throw(KeyboardInterrupt),
    )
    with pytest.raises(KeyboardInterrupt):
        from heatlens.fronts.commands.command_parser import build_parser
        from heatlens.lab.commands import bench

        bench.run(build_parser().parse_args(["bench", *WORDS]))
    assert "finding out how long this takes" in capsys.readouterr().err
