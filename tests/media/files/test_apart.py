"""Test that a reading process has limits that grow with its files, and ends with its parent."""

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
from heatlens.media.files.usd_library import report_usd_failures
from heatlens.render.source.opened import Opened
from heatlens.render.source.opener import SourceOpener
from support.command_line import CAMERA, ENVIRONMENT, channels
from support.exr_files import write_file
from support.patience import PATIENCE_S
from support.usd_cameras import nested_references_stage
from support.x_server import Screen, Window

LONG = {"HEATLENS_READING_SECONDS": "600", "HEATLENS_READING_GIGABYTES": "60"}


@pytest.fixture
def endless(usd_path, monkeypatch) -> Path:
    """Return a stage that takes minutes to open, with the time to do so."""
    for name, value in LONG.items():
        monkeypatch.setenv(name, value)
    usd_path.write_text(nested_references_stage())
    return usd_path


def wait_until(condition) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def children_of(process: int) -> list[int]:
    tasks = Path(f"/proc/{process}/task").glob("*/children")
    return [int(word) for task in tasks for word in task.read_text().split()]


def scene_readers(process: int) -> list[int]:
    """Return the processes that read a scene, of those that `process` or its children started."""
    children = [child for child in children_of(process) if is_alive(child)]
    readers = [reader for child in children for reader in scene_readers(child)]
    return readers or [child for child in children if b"usd_scene" in command_of(child)]


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


def test_allow_for_adds_time_for_each_file_once(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).write_bytes(bytes(2_000_000))
    code = (
        "import resource; from heatlens.media.files import limits\n"
        "def told(): print(resource.getrlimit(resource.RLIMIT_CPU)[0])\n"
        "limits.allow_for('a'); told(); limits.bound_this_process(); told()\n"
        "for name in ('a', 'a', './b', 'none'): limits.allow_for(name); told()\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", code], env=ENVIRONMENT, cwd=tmp_path, capture_output=True, text=True
    )
    assert process.stdout.split() == ["-1", "10", "30", "30", "50", "50"], process.stderr


def test_kill_reading_processes_ends_reader_with_input_error(endless):
    errors: list[HeatlensError] = []

    def read() -> None:
        try:
            read_usd_camera(str(endless))
        except HeatlensError as error:
            errors.append(error)

    thread = Thread(target=read)
    thread.start()
    wait_until(lambda: apart._running_processes)
    apart.kill_reading_processes()
    thread.join(PATIENCE_S)
    assert isinstance(errors[0], InputError) and not apart._running_processes


def test_source_opener_opens_another_file_during_endless_read(endless, tmp_path):
    other = write_file(tmp_path / "o.exr", channels(), **CAMERA)
    opener = SourceOpener(lambda: None)
    opener.open(str(endless), PlateOptions())
    wait_until(lambda: apart._running_processes)
    opener.open(str(other), PlateOptions())
    opened: list[Opened] = []
    wait_until(lambda: opened.extend(filter(None, [opener.poll()])) or opened)
    assert opened[0].text == str(other)
    wait_until(lambda: not apart._running_processes)
    opened[0].close()
    opener.close()


def test_source_opener_close_stops_its_running_reader(endless):
    opener = SourceOpener(lambda: None)
    opener.open(str(endless), PlateOptions())
    wait_until(lambda: apart._running_processes)
    opener.close()
    wait_until(lambda: not apart._running_processes)


def test_window_that_closes_ends_its_readers(endless, tmp_path):
    screen = Screen()
    try:
        window = Window(screen, tmp_path, endless, title="heatlens", **LONG)
        wait_until(lambda: scene_readers(window.process.pid))
        reader_ids = scene_readers(window.process.pid)
        window.quit()
        assert window.closed() == (0, "")
    finally:
        screen.close()
    assert not any(map(is_alive, reader_ids))


@pytest.mark.skipif(sys.platform != "linux", reason="the system must end it")
def test_reader_ends_when_its_parent_is_killed(endless):
    code = f"from heatlens.media.camera.usd_read import *; read_usd_camera({str(endless)!r})"
    parent = subprocess.Popen([sys.executable, "-c", code], env=ENVIRONMENT | LONG)
    wait_until(lambda: children_of(parent.pid))
    (reader_id,) = children_of(parent.pid)
    parent.kill()
    parent.wait()
    wait_until(lambda: not is_alive(reader_id))


def test_usd_camera_rejects_stage_that_names_a_pipe(usd_path):
    os.mkfifo(usd_path.with_name("pipe.usda"))
    usd_path.write_text("#usda 1.0\n( subLayers = [@./pipe.usda@] )\n")
    with pytest.raises(InputError, match=r"pipe[^']*', which it names, is not a file"):
        usd_camera(str(usd_path))


def test_report_usd_failures_passes_on_errors_of_our_own_code():
    with pytest.raises(TypeError), report_usd_failures("a.usda"):
        float(None)
    with pytest.raises(ZeroDivisionError), report_usd_failures("a.usda"):
        print(1 // 0)


def test_call_in_process_reports_errors_of_our_own_code_as_faults(
    usd_path, expects_faults, tmp_path, monkeypatch
):
    """The function is called with wrong arguments."""
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(tmp_path))
    with pytest.raises(FaultError, match=r"a fault of heatlens \(TypeError.*The report is in"):
        apart.call_in_process(units_per_mm, str(usd_path), str(usd_path))
