"""Test Ctrl-C and SIGTERM: commands end promptly, leave no files and report truthfully."""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from fuzz.interrupts import COMMANDS, STILL, Bench
from heatlens.core.base import stopping
from heatlens.core.base.errors import FAULT_CODE
from heatlens.render.gpu.opengl import gl_device
from support.command_line import ENVIRONMENT
from support.patience import PATIENCE_S
from support.x_server import Screen, Window


@pytest.fixture(autouse=True)
def default_sighup():
    """Restore the default SIGHUP handler, as these tests may run under nohup, which ignores it."""
    handler_before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, handler_before)


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Bench:
    return Bench(tmp_path_factory.mktemp("interrupts"))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", ["render", "export", "export-movie", "accumulation", "compare"])
def test_interrupted_command_ends_cleanly(bench, name, number):
    assert name in COMMANDS
    rng = random.Random(name)
    for to_group in (False, True):
        outcome = bench.interrupted(name, rng.uniform(0.1, 1.0), number, to_group)
        assert not outcome.faults(number, PATIENCE_S), outcome


def test_ctrl_c_while_a_context_is_made_ends_the_command_afterwards(monkeypatch):
    """The library that makes it drops a KeyboardInterrupt: commands went on to their end."""

    def make_and_drop(**_):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(gl_device.moderngl, "create_context", make_and_drop)
    with pytest.raises(KeyboardInterrupt):
        gl_device.headless_device()


def test_remove_leftovers_deletes_only_unfinished_files(tmp_path):
    record = bytearray()
    stopping.begin_record(record.extend)
    try:
        partial_file = tmp_path / "half"
        folder = tmp_path / "report"
        empty_folder = tmp_path / "made"
        finished_file, full_folder = tmp_path / "done", tmp_path / "kept"
        for path in (empty_folder, full_folder):
            stopping.record_new_folder(path)
            path.mkdir()
        folder.mkdir()
        (full_folder / "n.exr").write_bytes(b"whole")
        (folder / "page.html").write_text("half")
        partial_file.write_bytes(b"ha")
        blocks = [stopping.mark_unfinished(path) for path in (partial_file, folder)]
        for block in blocks:  # entered, and never left
            block.__enter__()
        with stopping.mark_unfinished(finished_file):
            finished_file.write_bytes(b"whole")
        leftovers = stopping.read_record(bytes(record))
        stopping.remove_leftovers(leftovers)
    finally:
        stopping.begin_record(None)
    assert (
        blocks and leftovers.unfinished == (partial_file, folder) and not leftovers.handles_signals
    )
    assert sorted(os.listdir(tmp_path)) == ["done", "kept"]


def test_crash_in_library_is_reported_in_one_line():
    code = (
        "import os, signal, sys, heatlens.fronts.commands.launch as launch\n"
        "launch._run_command = lambda: os.kill(os.getpid(), signal.SIGSEGV) or 0\n"
        "sys.exit(launch.main())"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True
    )
    assert run.returncode == FAULT_CODE
    assert "SIGSEGV" in run.stderr and len(run.stderr.splitlines()) == 1


def test_stop_message_is_printed_once_if_work_must_be_killed():
    """On a busy machine the work prints the message, and is killed before it has ended."""
    code = (
        "import os, signal, sys, time\n"
        "from heatlens.fronts.commands import launch, worker_process\n"
        "from heatlens.core.base import stopping\n"
        "from heatlens.fronts.commands import main\n"
        "worker_process._STOP_TIMEOUT_S = 0.3\n"
        "def work():\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "    with stopping.handle_own_signals():\n"
        "        main.put_command_first = lambda *_: (print('here', flush=True), time.sleep(60))\n"
        "        main.main([])\n"
        "    time.sleep(60)\n"
        "launch._run_command = work\n"
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
    _, message = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, message) == (130, "heatlens: stopped\n")


def test_background_command_ignores_sigint(bench, tmp_path):
    """Shells start background commands with SIGINT ignored; the signal is for the foreground."""
    out = tmp_path / "out"
    out.mkdir()
    handler_before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process = bench.start("render", out)
    finally:
        signal.signal(signal.SIGINT, handler_before)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode == 0 and (out / "o.exr").is_file()


EXIT_CODES = [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]


@pytest.mark.parametrize(("number", "code"), EXIT_CODES)
def test_signal_closes_idle_window_and_saves_preferences(tmp_path: Path, number, code):
    """SIGHUP is sent if the terminal is closed from which the window was started."""
    screen = Screen()
    try:
        words = ("--demo",) if code == 130 else (STILL, "--quality", "draft", "--proxy", "0.5")
        window = Window(screen, tmp_path, *words)
        time.sleep(2.0)
        window.process.send_signal(number)
        outputs = window.process.communicate(timeout=PATIENCE_S)
    finally:
        screen.close()
    assert (window.process.returncode, *outputs) == (code, "", "heatlens: stopped\n")
    assert (tmp_path / "config" / "preferences.json").is_file()
    assert not list((tmp_path / "run").iterdir())  # the window's port is not published any more


@pytest.mark.parametrize("ignored", ["", "signal.signal(signal.SIGHUP, signal.SIG_IGN); "])
def test_stop_signals_respect_ignored_sighup(ignored):
    code = (
        f"import os, signal; {ignored}from heatlens.core.base.stopping import StopSignals\n"
        "with StopSignals(lambda: None) as stops: os.kill(os.getpid(), signal.SIGHUP)\n"
        "print(stops.number)"
    )
    process = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True)
    assert process.stdout.decode().strip() == ("None" if ignored else str(int(signal.SIGHUP)))
