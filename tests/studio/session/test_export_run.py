"""An export is stopped in bounded time, whatever its process does with signals."""

import signal
import subprocess
import sys
import time

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.exports import export_process
from heatlens.studio.session.exports.export_process import ExportRun, ExportState

# Prints a first line, ignores every polite signal, and would go on for a minute.
DEAF = (
    "import signal, sys, time\n"
    "for number in (signal.SIGINT, signal.SIGTERM): signal.signal(number, signal.SIG_IGN)\n"
    "print('{}', flush=True); time.sleep(60)"
)

# Says what it does with stop signals.
ASKED = (
    "import signal, sys\n"
    "heard = [n.name for n in (signal.SIGINT, signal.SIGTERM) "
    "if signal.getsignal(n) is not signal.SIG_IGN]\n"
    "print(*heard, file=sys.stderr); sys.exit(1)"
)


def test_a_process_hears_signals_that_the_program_was_started_to_ignore(monkeypatch, tmp_path):
    real = subprocess.Popen

    def started(_line, **options):
        return real([sys.executable, "-c", ASKED], **options)

    monkeypatch.setattr(export_process.subprocess, "Popen", started)
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
    run._follower.join(60)
    assert run.state is not None and run.state.said == "SIGINT SIGTERM"
    assert after == [signal.SIG_IGN] * 2


# Prints what a broken pipe or another program's message may look like, between true events.
NOISY = """
print('{"event": "begin", "frames": 3}')
print('{"done": 1, "frames": 3}{"done": 2, "frames": 3}')
print('{a brace}')
print('[1]')
print('{"event": "frame", "done": 3, "frames": 3}')
"""


def followed(monkeypatch, tmp_path, program, wake):
    """Run `program` in the place of an export to its end, and return what is known of it."""
    real = subprocess.Popen

    def started(_line, **options):
        return real([sys.executable, "-c", program], **options)

    monkeypatch.setattr(export_process.subprocess, "Popen", started)
    run = ExportRun(wake)
    run.export(Shot(Lens(50.0, 2.0, 3.0, 36.0)), str(tmp_path / "a.####.exr"))
    assert run._follower is not None
    run._follower.join(60)
    return run.state


def test_lines_that_are_no_events_do_not_end_the_following(monkeypatch, tmp_path):
    state = followed(monkeypatch, tmp_path, NOISY, lambda: None)
    assert (state.done, state.frames, state.code) == (3, 3, 0)


def test_a_fault_while_following_ends_the_export_with_a_sentence(
    monkeypatch, tmp_path, expects_faults
):
    calls = []

    def wake():
        calls.append(1)
        if len(calls) == 1:
            raise ZeroDivisionError

    state = followed(monkeypatch, tmp_path, NOISY, wake)
    assert state.code == 70 and "is a fault of heatlens (ZeroDivisionError)" in state.said
    assert len(calls) == 2  # the window is told


def test_a_process_that_ignores_signals_is_killed(monkeypatch, tmp_path):
    monkeypatch.setattr("heatlens.deliver.farm.processes.PATIENCE_S", 0.2)
    real = subprocess.Popen

    def started(_line, **options):
        return real([sys.executable, "-c", DEAF], **options)

    monkeypatch.setattr(export_process.subprocess, "Popen", started)
    woken: list[float] = []
    run = ExportRun(lambda: woken.append(time.monotonic()))
    run.export(Shot(Lens(50.0, 2.0, 3.0, 36.0)), str(tmp_path / "a.####.exr"))
    end = time.monotonic() + 60
    while not woken:  # it has begun, and is deaf
        assert time.monotonic() < end
        time.sleep(0.01)
    run.cancel()
    process = run._process
    assert process is not None and process.wait(60) < 0
    run.close()
    assert run.state is not None and run.state.is_stopped and "Stopped" in run.state.said


@pytest.mark.parametrize("part", ["Popen", "Thread"])
def test_an_export_that_cannot_begin_says_so_and_the_next_one_can(monkeypatch, tmp_path, part):
    def fails(*_words, **_options):
        raise OSError(24, "Too many open files")

    real, left = subprocess.Popen, tmp_path / "left"
    left.mkdir()
    monkeypatch.setattr(export_process.tempfile, "tempdir", str(left))
    monkeypatch.setattr(
        export_process.subprocess,
        "Popen",
        lambda _line, **of: real([sys.executable, "-c", ""], **of),
    )
    run, shot = ExportRun(lambda: None), Shot(Lens(50.0, 2.0, 3.0, 36.0))
    with monkeypatch.context() as broken:
        owner = export_process.subprocess if part == "Popen" else export_process
        broken.setattr(owner, part, fails)
        with pytest.raises(InputError, match=r"The export to .* could not start: Too many open"):
            run.export(shot, str(tmp_path / "a.####.exr"))
    assert not run.is_busy and run.state is None and not list(left.iterdir())
    run.export(shot, str(tmp_path / "a.####.exr"))
    assert run.state is not None and run._follower is not None
    run._follower.join(60)
    assert run.state.code == 0


def test_what_stays_of_a_stopped_export_is_told_of_frames_and_of_movies():
    frames, movie = (ExportState("t", output=name) for name in ("o.####.exr", "o.MOV"))
    assert "kept" in frames.when_stopped and "deleted" in movie.when_stopped
