"""A process that reads has bounds which grow with its files, and never outlives who asked."""

import os
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import pytest

from heatlens.core.base.errors import FaultError, HeatlensError, InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.camera.usd_read import read_usd_camera, usd_camera
from heatlens.media.camera.usd_write import units_per_mm
from heatlens.media.files import apart
from heatlens.media.files.usd_library import usd_failures_reported
from heatlens.render.source.opened import Opened
from heatlens.render.source.opener import SourceOpener
from support.command_line import CAMERA, ENVIRONMENT, channels
from support.exr_files import write_file
from support.usd_cameras import bomb
from support.x_server import Screen, Window

LONG = {"HEATLENS_READING_SECONDS": "600", "HEATLENS_READING_GIGABYTES": "60"}
PATIENCE_S = 60.0


@pytest.fixture
def endless(usd_path, monkeypatch) -> Path:
    """Return a stage that takes minutes to open, with the time to do so."""
    for name, value in LONG.items():
        monkeypatch.setenv(name, value)
    usd_path.write_text(bomb())
    return usd_path


def until(is_so) -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.01)


def children_of(process: int) -> list[int]:
    tasks = Path(f"/proc/{process}/task").glob("*/children")
    return [int(word) for task in tasks for word in task.read_text().split()]


def scene_readers(process: int) -> list[int]:
    """Return the processes that read a scene, of those that `process` or its children started."""
    found = [child for child in children_of(process) if is_alive(child)]
    below = [reader for child in found for reader in scene_readers(child)]
    return below or [child for child in found if b"usd_scene" in command_of(child)]


def command_of(process: int) -> bytes:
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""


def is_alive(process: int) -> bool:
    try:
        stat = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] not in "ZX"


def test_the_time_grows_with_each_file_once(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).write_bytes(bytes(2_000_000))
    code = (
        "import resource; from heatlens.media.files import limits\n"
        "def told(): print(resource.getrlimit(resource.RLIMIT_CPU)[0])\n"
        "limits.allow_for('a'); told(); limits.bound_this_process(); told()\n"
        "for name in ('a', 'a', './b', 'none'): limits.allow_for(name); told()\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], env=ENVIRONMENT, cwd=tmp_path, capture_output=True, text=True
    )
    assert said.stdout.split() == ["-1", "10", "30", "30", "50", "50"], said.stderr


def test_the_program_that_closes_ends_what_is_being_read(endless):
    refused: list[HeatlensError] = []

    def read() -> None:
        try:
            read_usd_camera(str(endless))
        except HeatlensError as error:
            refused.append(error)

    thread = Thread(target=read)
    thread.start()
    until(lambda: apart._running)
    apart.end_all()
    thread.join(PATIENCE_S)
    assert isinstance(refused[0], InputError) and not apart._running


def test_another_file_does_not_wait_for_one_that_takes_for_ever(endless, tmp_path):
    other = write_file(tmp_path / "o.exr", channels(), **CAMERA)
    opener = SourceOpener(lambda: None)
    opener.open(str(endless), PlateOptions())
    until(lambda: apart._running)
    opener.open(str(other), PlateOptions())
    opened: list[Opened] = []
    until(lambda: opened.extend(filter(None, [opener.poll()])) or opened)
    assert opened[0].text == str(other)
    until(lambda: not apart._running)
    opened[0].close()
    opener.close()


def test_a_window_that_closes_does_not_wait_for_what_it_opens(endless):
    opener = SourceOpener(lambda: None)
    opener.open(str(endless), PlateOptions())
    until(lambda: apart._running)
    opener.close()
    until(lambda: not apart._running)


def test_a_real_window_that_is_closed_ends_what_it_reads(endless, tmp_path):
    screen = Screen()
    try:
        window = Window(screen, tmp_path, endless, title="heatlens", **LONG)
        until(lambda: scene_readers(window.process.pid))
        reads = scene_readers(window.process.pid)
        window.quit()
        assert window.closed() == (0, "")
    finally:
        screen.close()
    assert not any(map(is_alive, reads))


@pytest.mark.skipif(sys.platform != "linux", reason="the system must end it")
def test_reading_ends_with_the_process_that_asked_when_that_is_killed(endless):
    code = f"from heatlens.media.camera.usd_read import *; read_usd_camera({str(endless)!r})"
    asks = subprocess.Popen([sys.executable, "-c", code], env=ENVIRONMENT | LONG)
    until(lambda: children_of(asks.pid))
    (reads,) = children_of(asks.pid)
    asks.kill()
    asks.wait()
    until(lambda: not is_alive(reads))


def test_a_stage_that_names_a_pipe_is_refused(usd_path):
    os.mkfifo(usd_path.with_name("pipe.usda"))
    usd_path.write_text("#usda 1.0\n( subLayers = [@./pipe.usda@] )\n")
    with pytest.raises(InputError, match=r"pipe[^']*', which it names, is not a file"):
        usd_camera(str(usd_path))


def test_our_own_mistakes_are_no_damage():
    with pytest.raises(TypeError), usd_failures_reported("a.usda"):
        float(None)
    with pytest.raises(ZeroDivisionError), usd_failures_reported("a.usda"):
        print(1 // 0)


def test_our_own_mistakes_cross_over_as_such(usd_path, expects_faults, tmp_path, monkeypatch):
    """A function that is called as it should not be."""
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(tmp_path))
    with pytest.raises(FaultError, match=r"a fault of heatlens \(TypeError.*The report is in"):
        apart.called_apart(units_per_mm, str(usd_path), str(usd_path))
