"""Test that a library is silenced on any number of threads, and nothing else is."""

import os
import subprocess
import sys
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor

import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.files.quiet import quiet_library
from heatlens.media.plate.read import read_plate
from support.exr_files import distances, rgb, write_file
from support.patience import PATIENCE_S


def test_quiet_library_drops_only_output_of_its_thread(capfd):
    with quiet_library():
        print("inside")
        os.write(2, b"from C\n")
        other = threading.Thread(target=lambda: print("outside"))
        other.start()
        other.join()
        with quiet_library():
            print("inside, twice")
        print("inside still")
    print("after")
    os.write(2, b"from C after\n")
    assert capfd.readouterr() == ("outside\nafter\n", "from C after\n")


def test_quiet_library_restores_streams_after_overlapping_blocks(capfd):
    """If each block restored the stream that it found, the second would restore a muted one."""
    stdout, first_is_in, second_is_in = sys.stdout, threading.Event(), threading.Event()

    def first():
        with quiet_library():
            first_is_in.set()
            assert second_is_in.wait(PATIENCE_S)

    with ThreadPoolExecutor(1) as threads:
        job = threads.submit(first)
        assert first_is_in.wait(PATIENCE_S)
        with quiet_library():
            second_is_in.set()
            job.result()
            print("inside")
    assert sys.stdout is stdout
    print("after")
    os.write(2, b"from C after\n")
    assert capfd.readouterr() == ("after\n", "from C after\n")


def test_quiet_library_keeps_its_stream_alive():
    """`print` borrows sys.stdout: with a new stream for each block it sometimes crashed."""
    streams = []
    for _ in range(3):
        with quiet_library():
            streams.append(weakref.ref(sys.stdout))
    assert streams[0]() is not None and streams[0]() is streams[2]()


def test_quiet_library_passes_python_stderr_and_drops_c_stderr(capfd, monkeypatch):
    """Tracebacks and progress lines are written by Python."""
    with open(2, "w", buffering=1, closefd=False) as stderr:
        monkeypatch.setattr(sys, "stderr", stderr)
        with quiet_library():
            print("progress", file=sys.stderr)
            os.write(2, b"from C\n")
        assert sys.stderr is stderr
    assert capfd.readouterr() == ("", "progress\n")


# One thread prints while others mute the process all the time; without a buffer, as in containers,
# a line and its end are written one after the other.
PRINTING = """
import sys, threading
from heatlens.media.files.quiet import protect_output, quiet_library
protect_output()

is_over = threading.Event()

def read():
    while not is_over.is_set():
        with quiet_library():
            pass

threads = [threading.Thread(target=read) for _ in range(2)]
for thread in threads:
    thread.start()
for number in range(2000):
    print(number, flush=True)
    print(number, file=sys.stderr)
is_over.set()
for thread in threads:
    thread.join()
"""


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_protect_output_keeps_every_line_of_other_threads(unbuffered):
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    run = subprocess.run(
        [sys.executable, "-c", PRINTING], env=environment, capture_output=True, text=True
    )
    lines = [f"{number}" for number in range(2000)]
    assert (run.stdout.split("\n")[:-1], run.stderr.split("\n")[:-1]) == (lines, lines)


@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_quiet_library_works_without_stdout_or_stderr(monkeypatch, name):
    monkeypatch.setattr(sys, name, None)
    with quiet_library():
        print("nowhere")
    assert getattr(sys, name) is None


def test_damaged_files_on_many_threads_print_nothing(tmp_path, capfd):
    good = write_file(tmp_path / "good.exr", rgb(64, 64) | {"Z": distances(64, 64)})
    bad = tmp_path / "bad.exr"
    bad.write_bytes(good.read_bytes()[:-900])
    stdout, expected = sys.stdout, read_plate(good).color.tobytes()

    def read(path):
        try:
            return read_plate(path).color.tobytes() == expected
        except InputError as error:
            return "damaged or cut short" in str(error)

    with ThreadPoolExecutor(4) as threads:
        assert all(threads.map(read, [good, bad] * 40))
    assert sys.stdout is stdout
    assert capfd.readouterr() == ("", "")
