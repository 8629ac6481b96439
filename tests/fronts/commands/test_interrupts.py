"""Ctrl-C and SIGTERM: answered at once, nothing left behind, nothing said that is not true."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fuzz.interrupts import COMMANDS, STILL, Bench
from heatlens.core.base import stopping
from heatlens.fronts.commands import launch
from support.command_line import ENVIRONMENT
from support.x_server import Screen, Window

PATIENT_S = 20.0  # no test of how fast, only of whether: `python tests/fuzz/interrupts.py` measures


@pytest.fixture(autouse=True)
def hung_up_by_the_terminal():
    """Processes inherit that SIGHUP is ignored, and these tests too may run under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Bench:
    return Bench(tmp_path_factory.mktemp("interrupts"))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", ["render", "export", "export-movie", "accumulation", "compare"])
def test_a_command_that_is_stopped_ends_in_order(bench, name, number):
    assert name in COMMANDS
    rng = random.Random(name)
    for to_group in (False, True):
        outcome = bench.interrupted(name, rng.uniform(0.1, 1.0), number, to_group)
        assert not outcome.faults(number, PATIENT_S), outcome


def test_files_that_nobody_finishes_are_removed_and_others_stay(tmp_path):
    record = stopping.begin_record()
    try:
        half, folder, made = tmp_path / "half", tmp_path / "report", tmp_path / "made"
        done, kept = tmp_path / "done", tmp_path / "kept"
        for path in (made, kept):
            stopping.folder_made(path)
            path.mkdir()
        folder.mkdir()
        (kept / "n.exr").write_bytes(b"whole")
        (folder / "page.html").write_text("half")
        half.write_bytes(b"ha")
        blocks = [stopping.unfinished(path) for path in (half, folder)]
        for block in blocks:  # entered, and never left
            block.__enter__()
        with stopping.unfinished(done):
            done.write_bytes(b"whole")
        left = stopping.read_record(record)
        stopping.remove_left(left)
    finally:
        os.close(record)
        stopping._record = None
    assert blocks and left.unfinished == (half, folder) and not left.hears
    assert sorted(os.listdir(tmp_path)) == ["done", "kept"]


def test_a_crash_of_a_library_is_said_in_a_sentence():
    code = (
        "import os, signal, sys, heatlens.fronts.commands.launch as launch\n"
        "launch._work = lambda: os.kill(os.getpid(), signal.SIGSEGV) or 0\n"
        "sys.exit(launch.main())"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True
    )
    assert run.returncode == launch.FAULT_CODE
    assert "SIGSEGV" in run.stderr and len(run.stderr.splitlines()) == 1


def test_a_stop_is_said_once_though_the_work_ends_too_slowly():
    """On a busy machine: it has said so, and is killed before it has ended."""
    code = (
        "import os, signal, sys, time\n"
        "import heatlens.fronts.commands.launch as launch\n"
        "from heatlens.core.base import stopping\n"
        "from heatlens.fronts.commands import main\n"
        "launch._PATIENCE_S = 0.3\n"
        "def work():\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "    with stopping.hearing():\n"
        "        main.with_command = lambda *_: (print('here', flush=True), time.sleep(60))\n"
        "        main.main([])\n"
        "    time.sleep(60)\n"
        "launch._work = work\n"
        "sys.exit(launch.main())"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None and process.stdout.readline() == "here\n"
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (130, "heatlens: stopped\n")


def test_what_is_started_in_the_background_ignores_ctrl_c(bench, tmp_path):
    """Shells start it so; the signal is for what is in front."""
    out = tmp_path / "out"
    out.mkdir()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process = bench.start("render", out)
    finally:
        signal.signal(signal.SIGINT, before)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode == 0 and (out / "o.exr").is_file()


ENDS = [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]


@pytest.mark.parametrize(("number", "code"), ENDS)
def test_an_idle_window_is_closed_by_a_signal(tmp_path: Path, number, code):
    """SIGHUP comes where the terminal is closed from which the window was started."""
    screen = Screen()
    try:
        window = Window(screen, tmp_path, "--demo" if code == 130 else STILL)
        time.sleep(2.0)
        window.process.send_signal(number)
        said = window.process.communicate(timeout=60)
    finally:
        screen.close()
    assert (window.process.returncode, *said) == (code, "", "heatlens: stopped\n")
    assert (tmp_path / "config" / "preferences.json").is_file()
    assert not list((tmp_path / "run").iterdir())  # the window's port is not published any more


@pytest.mark.parametrize("ignored", ["", "signal.signal(signal.SIGHUP, signal.SIG_IGN); "])
def test_a_window_that_was_started_to_outlive_its_terminal_does_so(ignored):
    code = (
        f"import os, signal; {ignored}from heatlens.core.base.stopping import StopSignals\n"
        "with StopSignals(lambda: None) as stops: os.kill(os.getpid(), signal.SIGHUP)\n"
        "print(stops.number)"
    )
    said = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True)
    assert said.stdout.decode().strip() == ("None" if ignored else str(int(signal.SIGHUP)))
