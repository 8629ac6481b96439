"""Test `export --processes`: several processes on this machine write the files of one."""

import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.base.last_words import StderrTail
from heatlens.deliver.farm import processes
from heatlens.media.documents.shot_file import write_shot
from support.dask_cluster import HEATLENS, children_of, wait_for
from support.exports import (
    MANY_FRAMES,
    export_shot,
    files_in,
    refused_export_message,
    shot_of,
    write_plates,
)
from support.patience import PATIENCE_S


@pytest.mark.parametrize("output", ["n.####.exr", "n.####.png", "m.mov"])
def test_export_with_processes_gives_files_of_one_process(capsys, shot_file, tmp_path, output):
    export_shot(capsys, shot_file, tmp_path / "whole" / output)
    message = export_shot(capsys, shot_file, tmp_path / "out" / output, "--processes", 2)
    assert "6 frames written" in message
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    second_message = export_shot(capsys, shot_file, tmp_path / "out" / output, "--processes", 2)
    assert "0 frames written, 6 were finished before" in second_message
    assert not list((tmp_path / "out").glob("*.frames"))


@pytest.mark.parametrize(
    ("count", "thread_count", "expected"),
    [(2, None, "4"), (3, None, "2"), (20, None, "1"), (1, None, ""), (2, "7", "7")],
)
def test_processes_divide_llvmpipe_threads_among_them(
    monkeypatch, tmp_path, count, thread_count, expected
):
    """Otherwise the software rasterizer of each process would start a thread for every CPU."""
    fake_python = tmp_path / "python"
    fake_python.write_text('#!/bin/sh\necho "$LP_NUM_THREADS"\n')
    fake_python.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(fake_python))
    monkeypatch.setattr("os.cpu_count", lambda: 8)
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    if thread_count is not None:
        monkeypatch.setenv("LP_NUM_THREADS", thread_count)
    with processes.start_process(["export"], count=count) as process:
        assert process.communicate()[0] == f"{expected}\n"


def test_readers_of_processes_have_ended_when_export_ends(monkeypatch, tmp_path):
    """A reader that begins late, on a busy machine, would read a pipe that is closed."""
    event = '{"event": "frame", "frame": 1, "state": "written"}'
    script = f"print('{event}', flush=True); import time; time.sleep(60)"

    def start(words, count):
        return subprocess.Popen(
            [sys.executable, "-c", script],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    read = StderrTail._read

    def read_late(self, process):
        time.sleep(0.3)
        read(self, process)

    monkeypatch.setattr(StderrTail, "_read", read_late)
    monkeypatch.setattr(processes, "start_process", start)
    planned = SimpleNamespace(frame=1, path=tmp_path / "n.1.exr")
    frames = processes.ProcessMaker(["export"], 1, print)([planned])
    assert next(frames).frame == 1
    frames.close()
    assert not [it.name for it in threading.enumerate() if "(_read" in it.name]


def test_export_passes_process_count_to_each_process(capsys, shot_file, tmp_path, monkeypatch):
    def refuse(words, count):
        raise InputError(f"one of {count}")

    monkeypatch.setattr(processes, "start_process", refuse)
    assert "one of 3" in refused_export_message(
        capsys, shot_file, tmp_path / "n.####.exr", "--processes", 3
    )


def test_each_process_warns_of_its_unusual_frames(capsys, mixed_plates, tmp_path):
    message = export_shot(capsys, mixed_plates, tmp_path / "n.####.exr", "--processes", 2)
    assert message.count("The depths are about 100 times") == 2  # each process tells of its frames


def test_export_with_processes_renders_only_missing_frames(capsys, shot_file, tmp_path):
    out = tmp_path / "out"
    export_shot(capsys, shot_file, out / "n.####.exr", "--frames", "1002-1004")
    inodes_before = {path: path.stat().st_ino for path in out.iterdir()}
    message = export_shot(capsys, shot_file, out / "n.####.exr", "--processes", 3)
    assert "3 frames written, 3 were finished before" in message
    assert all(path.stat().st_ino == inode for path, inode in inodes_before.items())


def test_failing_frame_ends_all_processes_with_its_message(capsys, shot_file, tmp_path):
    plate = tmp_path / "plates" / "plate.1004.exr"
    data = bytearray(plate.read_bytes())
    data[-400:] = bytes(400)
    plate.write_bytes(data)
    message = refused_export_message(capsys, shot_file, tmp_path / "n.####.exr", "--processes", 2)
    assert "plate.1004.exr" in message and not list(tmp_path.glob(".heatlens-*"))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--processes", 0), "1 or more"),
        (("--processes", 2, "--part", 1001), "cannot go together"),
        (("--processes", 2, "--submit", "slurm"), "cannot go together"),
        (("--chunk", 2), "--chunk needs --submit or --cluster"),
        (("--fetch",), "--fetch needs --cluster"),
        (("--memory", 2), "--memory needs --submit"),
    ],
)
def test_export_rejects_conflicting_process_options(capsys, shot_file, tmp_path, words, expected):
    assert expected in refused_export_message(capsys, shot_file, tmp_path / "n.####.exr", *words)


@pytest.mark.parametrize("victim", ["a process", "the export", "the export, asked"])
def test_export_with_killed_process_can_be_resumed(capsys, tmp_path, victim):
    shot, out = tmp_path / "s.heatlens.json", tmp_path / "out"
    write_shot(shot, shot_of(write_plates(tmp_path / "plates", MANY_FRAMES), MANY_FRAMES))
    export_shot(capsys, shot, tmp_path / "whole" / "n.####.exr")
    line = [*HEATLENS, "export", str(shot), "-o", str(out / "n.####.exr"), "--processes", "2"]
    with subprocess.Popen(line, stderr=subprocess.PIPE, text=True) as export:
        wait_for(lambda: len(list(out.glob("n.*"))) > 2)
        (worker,) = children_of(export.pid)
        processes = children_of(worker)
        if victim == "a process":
            os.kill(processes[0], signal.SIGKILL)
        else:
            export.send_signal(signal.SIGINT if "asked" in victim else signal.SIGKILL)
        assert export.wait(PATIENCE_S) == {"a process": 2, "the export": -9}.get(victim, 130)
        assert export.stderr is not None
        message = export.stderr.read()
    assert "export again" in message or victim != "a process"
    wait_for(lambda: not any(os.path.exists(f"/proc/{process}") for process in processes))
    export_shot(capsys, shot, out / "n.####.exr", "--processes", 2)
    assert files_in(out) == files_in(tmp_path / "whole")
