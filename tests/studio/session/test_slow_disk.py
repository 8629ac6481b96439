"""A disk that does not answer stops neither the loop of the window nor the end of the program.

`SlowDisk` blocks every read of a file whose name has "slow" in it until the test sets `answers`.
A loop that waited for such a read would never reach the line that sets it.
"""

import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from threading import Event, current_thread

import pytest

from heatlens.core.base.background import Threads, has_busy_threads
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import autosave_path
from heatlens.media.frame_cache import sequence_reader
from heatlens.media.plate import plate as plate_module
from heatlens.media.plate.plate import Plate
from heatlens.render.source.opened import Opened
from heatlens.studio.board.session import Session
from heatlens.studio.session.opened.open_source import OpenSource
from heatlens.studio.session.opened.picture_feed import Playhead
from heatlens.studio.session.shot import shot_store
from heatlens.studio.session.shot.shot_store import ShotStore
from heatlens.studio.settings import preferences
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.exr_files import distances, rgb, write_file
from support.patience import PATIENCE_S
from support.shot_files import FULL as SHOT


def plate_file(path: Path) -> Path:
    return write_file(path, rgb() | {"Z": distances()})


KNOWN = PlateOptions(depth_convention=DepthConvention.DISTANCE)


class SlowDisk:
    """Reads plates, and blocks reads of files named "slow" until `answers` is set."""

    def __init__(self) -> None:
        self.answers, self.is_asked = Event(), Event()
        self._read = sequence_reader.read_plate

    def __call__(self, path: Path, options: PlateOptions) -> Plate:
        if "slow" in path.name:
            self.is_asked.set()
            assert self.answers.wait(PATIENCE_S)
        return self._read(path, options)


@pytest.fixture
def disk(monkeypatch):
    slow = SlowDisk()
    monkeypatch.setattr(sequence_reader, "read_plate", slow)
    yield slow
    slow.answers.set()


@pytest.fixture
def wake_event():
    return Event()


@pytest.fixture
def source(renderer, ctx, wake_event):
    new_source = OpenSource(renderer, wake_event.set)
    yield new_source
    new_source.close()


def wait_for_source(source: OpenSource, wake_event: Event) -> Opened:
    """Return the opened source; sleep until a thread wakes the loop, as the window does."""
    while (opened := source.switch_source()) is None:
        assert wake_event.wait(PATIENCE_S)
        wake_event.clear()
    return opened


def test_another_source_opens_while_a_frame_of_the_last_is_being_read(
    source, disk, wake_event, tmp_path
):
    for number in (1, 2, 3):
        plate_file(tmp_path / f"slow.{number}.exr")
    disk.answers.set()
    source.opener.open(str(tmp_path / "slow.#.exr"), KNOWN)
    before = wait_for_source(source, wake_event)
    disk.answers.clear()
    disk.is_asked.clear()
    source.feed.show(Shot(Lens(50.0, 2.8, 2.0, 36.0)), Playhead(2))
    assert disk.is_asked.wait(PATIENCE_S)

    source.opener.open(str(plate_file(tmp_path / "other.exr")), KNOWN)
    after = wait_for_source(source, wake_event)
    assert after is source.opened is not before and not disk.answers.is_set()


def test_file_that_hangs_blocks_neither_next_file_nor_close(source, disk, wake_event, tmp_path):
    slow, other = plate_file(tmp_path / "slow.exr"), plate_file(tmp_path / "other.exr")
    source.opener.open(str(slow), KNOWN)
    assert disk.is_asked.wait(PATIENCE_S)
    source.opener.open(str(other), KNOWN)
    assert wait_for_source(source, wake_event).text == str(other)
    source.opener.open(str(slow), KNOWN)
    source.close()
    assert not disk.answers.is_set()


def test_depth_histogram_is_counted_on_the_reading_thread(
    source, wake_event, tmp_path, monkeypatch
):
    counting_threads, bins_of = [], plate_module.bin_values

    def record_thread(values):
        counting_threads.append(current_thread())
        return bins_of(values)

    monkeypatch.setattr(plate_module, "bin_values", record_thread)
    source.opener.open(str(plate_file(tmp_path / "a.exr")), KNOWN)
    wait_for_source(source, wake_event)
    assert source.picture.histogram is not None
    assert counting_threads and current_thread() not in counting_threads


def test_source_that_arrives_after_cancel_is_closed(
    source, disk, wake_event, tmp_path, monkeypatch
):
    closed = Event()
    monkeypatch.setattr(
        "heatlens.render.source.opened_plates.OpenedPlates.close",
        lambda self: (self.cache.close(), closed.set()),
    )
    source.opener.open(str(plate_file(tmp_path / "slow.exr")), KNOWN)
    assert disk.is_asked.wait(PATIENCE_S)
    source.opener.cancel()
    disk.answers.set()
    assert closed.wait(PATIENCE_S)
    assert source.switch_source() is None


def test_shot_file_read_that_hangs_does_not_delay_a_save(monkeypatch, tmp_path):
    answers, is_asked = Event(), Event()

    def block(path: Path) -> Shot:
        is_asked.set()
        assert answers.wait(PATIENCE_S)
        return SHOT

    monkeypatch.setattr(shot_store, "read_shot", block)
    store, path = ShotStore(lambda: None), tmp_path / "a.heatlens.json"
    path.touch()
    reading = store.read(path)
    assert is_asked.wait(PATIENCE_S)
    store.save(path, SHOT).result(PATIENCE_S)
    store.close()
    assert path.stat().st_size and not reading.done()
    answers.set()
    assert reading.result(PATIENCE_S).saved == SHOT


def test_preferences_are_written_in_order_without_blocking_the_loop(
    renderer, monkeypatch, tmp_path
):
    answers, is_asked, write_atomically = Event(), Event(), preferences.write_atomically

    def block(*words):
        is_asked.set()
        assert answers.wait(PATIENCE_S)
        write_atomically(*words)

    monkeypatch.setattr(preferences, "write_atomically", block)
    session = Session(renderer, Start(""), preferences=Preferences.load(tmp_path))
    session.begin()
    for name in ("/a.exr", "/b.exr"):
        session.preferences.remember_opened(name)
        session.save_preferences()
        assert is_asked.wait(PATIENCE_S)
    assert not (tmp_path / preferences.FILE_NAME).exists()
    answers.set()
    session.close()
    assert Preferences.load(tmp_path).values.recent == ("/b.exr", "/a.exr")


def test_failed_write_of_preferences_is_shown_once_in_a_session(renderer, tmp_path):
    (tmp_path / "file").touch()
    session = Session(renderer, Start(""), preferences=Preferences.load(tmp_path / "file" / "in"))
    session.begin()
    messages: list[str] = []
    session.files.documents._notify = lambda sentence: messages.append(str(sentence))
    for name in ("/a.exr", "/b.exr"):
        session.preferences.remember_opened(name)
        session.save_preferences()
    session.files.documents.store.write(lambda: None).result(PATIENCE_S)
    session.poll()
    assert len(messages) == 1 and "Preferences cannot be saved" in messages[0]
    session.close()


@pytest.mark.parametrize("source", ["", "plate.exr"])
def test_damaged_preferences_message_stays_until_the_next_message(renderer, tmp_path, source):
    """The message stays for any time that the first window takes, with or without a plate."""
    (tmp_path / "preferences.json").write_text("{")
    start = Start(source and str(plate_file(tmp_path / source)))
    session = Session(renderer, start, preferences=Preferences.load(tmp_path))
    session.begin()
    session.messages._clock = iter(range(0, 10**6, 20)).__next__  # each look is 20 s later
    end = time.monotonic() + PATIENCE_S
    while "settings are reset" not in session.messages.text:
        assert time.monotonic() < end
        session.poll()
    assert "preferences.damaged.json" in session.messages.text and session.messages.is_problem
    for _ in range(5):
        session.poll()
    assert "settings are reset" in session.messages.text
    assert session.messages.seconds_until_needed() is None
    session.messages.notify("Saved.")
    session.poll()
    assert not session.messages.text
    session.close()


@pytest.mark.parametrize("hours", [-1, 0, 1])
def test_autosave_is_found_whatever_its_modification_time(tmp_path, hours):
    """Unsaved changes are found even if a clock went back or a server's clock differs."""
    store, path = ShotStore(lambda: None), tmp_path / "a.heatlens.json"
    store.save(path, SHOT)
    store.autosave(path, replace(SHOT, marks=())).result(PATIENCE_S)
    at_ns = path.stat().st_mtime_ns + hours * 3600 * 10**9
    os.utime(autosave_path(path), ns=(at_ns, at_ns))
    assert store.read(path).result(PATIENCE_S).unsaved == replace(SHOT, marks=())
    store.close()


def test_shot_store_reads_what_was_saved_before(tmp_path):
    store, path = ShotStore(lambda: None), tmp_path / "a.heatlens.json"
    store.save(path, SHOT)
    assert store.read(path).result(PATIENCE_S).saved == SHOT
    store.close()


def test_threads_close_cancels_waiting_jobs_and_finishes_the_running_one():
    has_begun, goes_on, threads = Event(), Event(), Threads("test-threads")

    def first() -> str:
        has_begun.set()
        assert goes_on.wait(PATIENCE_S)
        return "done"

    running, waiting = threads.submit(first), threads.submit(lambda: "never")
    assert has_begun.wait(PATIENCE_S) and has_busy_threads()
    threads.close()
    assert waiting.cancelled() and not running.done()
    goes_on.set()
    assert running.result(PATIENCE_S) == "done"
    with pytest.raises(RuntimeError, match="closed"):
        threads.submit(first)


def test_error_of_a_job_is_the_exception_of_its_future():
    threads = Threads("test-threads")
    assert isinstance(threads.submit(lambda: [][0]).exception(PATIENCE_S), IndexError)
    assert threads.submit(lambda: 3).result(PATIENCE_S) == 3


def test_process_ends_normally_while_a_thread_is_blocked():
    """It returns its exit code, prints its output and runs its `atexit` function."""
    code = (
        "import atexit, sys, threading\n"
        "from heatlens.core.base.background import Threads\n"
        "from heatlens.fronts.commands import launch, main\n"
        "def run():\n"
        "    begun = threading.Event()\n"
        "    Threads('slow').submit(lambda: (begun.set(), threading.Event().wait()))\n"
        "    begun.wait()\n"
        "    atexit.register(lambda: print('and its end'))\n"
        "    print('said', end=' ')\n"
        "    return 7\n"
        "main.main = run\n"
        "sys.exit(launch.main())\n"
    )
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (process.returncode, process.stdout, process.stderr) == (7, "said and its end\n", "")
