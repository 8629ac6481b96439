"""`export --processes`: several processes on this machine, and the files of one."""

import os
import signal
import subprocess

import pytest

from heatlens.core.base.errors import InputError
from heatlens.deliver.farm import processes
from heatlens.media.documents.shot_file import write_shot
from support.dask_cluster import HEATLENS, children_of, wait_for
from support.exports import MANY, exported, files_in, refused, shot_of, write_plates


@pytest.mark.parametrize("output", ["n.####.exr", "n.####.png", "m.mov"])
def test_processes_make_what_one_makes(capsys, shot_file, tmp_path, output):
    exported(capsys, shot_file, tmp_path / "whole" / output)
    said = exported(capsys, shot_file, tmp_path / "out" / output, "--processes", 2)
    assert "6 frames written" in said
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    again = exported(capsys, shot_file, tmp_path / "out" / output, "--processes", 2)
    assert "0 frames written, 6 were finished before" in again
    assert not list((tmp_path / "out").glob("*.frames"))


@pytest.mark.parametrize(
    ("count", "given", "expected"),
    [(2, None, "4"), (3, None, "2"), (20, None, "1"), (1, None, ""), (2, "7", "7")],
)
def test_processes_share_the_processors(monkeypatch, tmp_path, count, given, expected):
    """The software rasteriser of each would otherwise start a thread for every processor."""
    heard = tmp_path / "python"
    heard.write_text('#!/bin/sh\necho "$LP_NUM_THREADS"\n')
    heard.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(heard))
    monkeypatch.setattr("os.cpu_count", lambda: 8)
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    if given is not None:
        monkeypatch.setenv("LP_NUM_THREADS", given)
    with processes.started(["export"], count=count) as process:
        assert process.communicate()[0] == f"{expected}\n"


def test_each_process_is_told_how_many_there_are(capsys, shot_file, tmp_path, monkeypatch):
    def refuse(words, count):
        raise InputError(f"one of {count}")

    monkeypatch.setattr(processes, "started", refuse)
    assert "one of 3" in refused(capsys, shot_file, tmp_path / "n.####.exr", "--processes", 3)


def test_unusual_frames_are_told_as_by_one_process(capsys, mixed_plates, tmp_path):
    said = exported(capsys, mixed_plates, tmp_path / "n.####.exr", "--processes", 2)
    assert said.count("The depths are about 100 times") == 2  # each process tells of its frames


def test_only_the_missing_frames_are_made(capsys, shot_file, tmp_path):
    out = tmp_path / "out"
    exported(capsys, shot_file, out / "n.####.exr", "--frames", "1002-1004")
    before = {path: path.stat().st_ino for path in out.iterdir()}
    said = exported(capsys, shot_file, out / "n.####.exr", "--processes", 3)
    assert "3 frames written, 3 were finished before" in said
    assert all(path.stat().st_ino == inode for path, inode in before.items())


def test_a_frame_that_fails_ends_the_others_with_its_sentence(capsys, shot_file, tmp_path):
    plate = tmp_path / "plates" / "plate.1004.exr"
    data = bytearray(plate.read_bytes())
    data[-400:] = bytes(400)
    plate.write_bytes(data)
    said = refused(capsys, shot_file, tmp_path / "n.####.exr", "--processes", 2)
    assert "plate.1004.exr" in said and not list(tmp_path.glob(".heatlens-*"))


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
def test_what_cannot_go_together(capsys, shot_file, tmp_path, words, expected):
    assert expected in refused(capsys, shot_file, tmp_path / "n.####.exr", *words)


@pytest.mark.parametrize("who", ["a process", "the export", "the export, asked"])
def test_whoever_is_killed_one_more_start_makes_all(capsys, tmp_path, who):
    shot, out = tmp_path / "s.heatlens.json", tmp_path / "out"
    write_shot(shot, shot_of(write_plates(tmp_path / "plates", MANY), MANY))
    exported(capsys, shot, tmp_path / "whole" / "n.####.exr")
    line = [*HEATLENS, "export", str(shot), "-o", str(out / "n.####.exr"), "--processes", "2"]
    with subprocess.Popen(line, stderr=subprocess.PIPE, text=True) as export:
        wait_for(lambda: len(list(out.glob("n.*"))) > 2)
        (worker,) = children_of(export.pid)
        processes = children_of(worker)
        if who == "a process":
            os.kill(processes[0], signal.SIGKILL)
        else:
            export.send_signal(signal.SIGINT if "asked" in who else signal.SIGKILL)
        assert export.wait(60) == {"a process": 2, "the export": -9}.get(who, 130)
        assert export.stderr is not None
        said = export.stderr.read()
    assert "export again" in said or who != "a process"
    wait_for(lambda: not any(os.path.exists(f"/proc/{process}") for process in processes))
    exported(capsys, shot, out / "n.####.exr", "--processes", 2)
    assert files_in(out) == files_in(tmp_path / "whole")
