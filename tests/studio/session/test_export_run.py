"""An export is stopped in bounded time, whatever its process does with signals."""

import signal
import subprocess
import sys
import time

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.farm import export_process
from heatlens.deliver.farm.export_process import ExportRun, ExportState
from support.patience import PATIENCE_S

# Prints a first line, ignores every polite signal, and would go on for a minute.
SIGNAL_IGNORING_PROGRAM = (
    "import signal, sys, time\n"
    "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
    "print('{}', flush=True); time.sleep(60)"
)

# Prints the names of the stop signals that it does not ignore.
SIGNAL_LISTING_PROGRAM = (
    "import signal, sys\n"
    "heard = [n.name for n in (signal.SIGINT, signal.SIGTERM) "
    "if signal.getsignal(n) is not signal.SIG_IGN]\n"
    "print(*heard, file=sys.stderr); sys.exit(1)"
)


def test_export_process_hears_signals_that_its_parent_ignores(monkeypatch, tmp_path):
    real_popen = subprocess.Popen

    def start_program(_line, **options):
        return real_popen([sys.executable, "-c", SIGNAL_LISTING_PROGRAM], **options)

    monkeypatch.setattr(export_process.subprocess, "Popen", start_program)
    run = ExportRun(lambda: None)
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, signal.SIG_IGN) for number in numbers]
    try:
        run.export(Shot(Lens(50.0, 2.0, 3.0, 36.0)), str(tmp_path / "a.####.exr"))
        after = [signal.getsignal(number) for number in numbers]
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
    assert run._follower is not None
    run._follower.join(PATIENCE_S)
    assert run.state is not None and run.state.last_sentence == "SIGINT SIGTERM"
    assert after == [signal.SIG_IGN] * 2


# Prints what a broken pipe or another program's message may look like, between true events.
NOISY_PROGRAM = """
print('{"event": "begin", "frames": 3}')
print('{"done": 1, "frames": 3}{"done": 2, "frames": 3}')
print('{a brace}')
print('[1]')
print('{"event": "frame", "done": 3, "frames": 3}')
"""


def run_in_place_of_export(monkeypatch, tmp_path, program, wake):
    """Run `program` in the place of an export to its end, and return the state of the export."""
    real_popen = subprocess.Popen

    def start_program(_line, **options):
        return real_popen([sys.executable, "-c", program], **options)

    monkeypatch.setattr(export_process.subprocess, "Popen", start_program)
    run = ExportRun(wake)
    run.export(Shot(Lens(50.0, 2.0, 3.0, 36.0)), str(tmp_path / "a.####.exr"))
    assert run._follower is not None
    run._follower.join(PATIENCE_S)
    return run.state


def test_export_run_skips_output_lines_that_are_no_events(monkeypatch, tmp_path):
    state = run_in_place_of_export(monkeypatch, tmp_path, NOISY_PROGRAM, lambda: None)
    assert (state.done_frames, state.frames, state.code) == (3, 3, 0)


def test_fault_in_export_follower_ends_export_with_a_message(monkeypatch, tmp_path, expects_faults):
    calls = []

    def wake():
        calls.append(1)
        if len(calls) == 1:
            raise ZeroDivisionError

    state = run_in_place_of_export(monkeypatch, tmp_path, NOISY_PROGRAM, wake)
    assert state.code == 70 and "is a fault of heatlens (ZeroDivisionError)" in state.last_sentence
    assert len(calls) == 2  # the window is told


def test_cancel_kills_export_process_that_ignores_signals(monkeypatch, tmp_path):
    monkeypatch.setattr("heatlens.deliver.farm.processes.PATIENCE_S", 0.2)
    real_popen = subprocess.Popen

    def start_program(_line, **options):
        return real_popen([sys.executable, "-c", SIGNAL_IGNORING_PROGRAM], **options)

    monkeypatch.setattr(export_process.subprocess, "Popen", start_program)
    wake_times_s: list[float] = []
    run = ExportRun(lambda: wake_times_s.append(time.monotonic()))
    run.export(Shot(Lens(50.0, 2.0, 3.0, 36.0)), str(tmp_path / "a.####.exr"))
    end = time.monotonic() + 60
    while not wake_times_s:  # it has begun, and is deaf
        assert time.monotonic() < end
        time.sleep(0.01)
    run.cancel()
    process = run._process
    assert process is not None and process.wait(PATIENCE_S) < 0
    run.close()
    assert run.state is not None and run.state.is_stopped and "Stopped" in run.state.last_sentence


@pytest.mark.parametrize("part", ["Popen", "Thread"])
def test_failed_start_of_export_raises_and_next_export_runs(monkeypatch, tmp_path, part):
    def fails(*_words, **_options):
        raise OSError(24, "Too many open files")

    real_popen, temp_folder = subprocess.Popen, tmp_path / "left"
    temp_folder.mkdir()
    monkeypatch.setattr(export_process.tempfile, "tempdir", str(temp_folder))
    monkeypatch.setattr(
        export_process.subprocess,
        "Popen",
        lambda _line, **of: real_popen([sys.executable, "-c", ""], **of),
    )
    run, shot = ExportRun(lambda: None), Shot(Lens(50.0, 2.0, 3.0, 36.0))
    with monkeypatch.context() as failing_patch:
        owner = export_process.subprocess if part == "Popen" else export_process
        failing_patch.setattr(owner, part, fails)
        with pytest.raises(InputError, match=r"The export to .* could not start: Too many open"):
            run.export(shot, str(tmp_path / "a.####.exr"))
    assert not run.is_busy and run.state is None and not list(temp_folder.iterdir())
    run.export(shot, str(tmp_path / "a.####.exr"))
    assert run.state is not None and run._follower is not None
    run._follower.join(PATIENCE_S)
    assert run.state.code == 0


def test_stopped_export_reports_frames_kept_and_movie_deleted():
    frames, movie = (ExportState("t", output=name) for name in ("o.####.exr", "o.MOV"))
    assert "kept" in frames.when_stopped and "deleted" in movie.when_stopped
