"""Test `export --cluster` and `heatlens worker` with a Dask scheduler and workers on loopback."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from distributed.comm import CommClosedError

from heatlens.core.base.errors import InputError
from heatlens.deliver.export.plan import plan_export
from heatlens.deliver.farm import cluster as cluster_export
from heatlens.deliver.farm import connection
from heatlens.deliver.farm.answers import frames_of_answer
from heatlens.deliver.farm.cluster import ClusterMaker, PartTask, topic_of
from heatlens.deliver.farm.connection import connected
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.export_options import make_export_job
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.worker import make_part
from heatlens.media.documents.shot_file import write_shot
from heatlens.version import __version__
from support.dask_cluster import children_of, dask_cluster, wait_for
from support.exports import MANY_FRAMES, export_shot, files_in, shot_of, write_plates
from support.patience import PATIENCE_S


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("cluster"), workers=2) as found:
        yield found


@pytest.fixture
def killable_cluster(scheduler):
    """Yield a cluster with one worker, whose workers and exports a test may kill."""
    scheduler.work("worker 0")
    yield scheduler
    scheduler.stop(but=("scheduler",))


@pytest.fixture
def own_cluster(tmp_path):
    """Yield a cluster of this test alone, whose scheduler the test may kill or read the log of."""
    with dask_cluster(tmp_path / "cluster", workers=1) as found:
        yield found


@pytest.fixture
def many_frames_shot(tmp_path):
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(write_plates(tmp_path / "plates", MANY_FRAMES), MANY_FRAMES))
    return shot


@pytest.mark.parametrize(
    ("output", "fetch"), [("n.####.exr", ()), ("n.####.png", ("--fetch",)), ("m.mov", ("--fetch",))]
)
def test_cluster_export_equals_export_of_one_machine(
    capsys, shot_file, tmp_path, cluster, output, fetch
):
    export_shot(capsys, shot_file, tmp_path / "whole" / output)
    message = cluster.exported(shot_file, "-o", tmp_path / "out" / output, *fetch)
    assert "6 frames written" in message
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    assert not list((tmp_path / "out").glob("*.frames"))
    second_message = cluster.exported(shot_file, "-o", tmp_path / "out" / output, *fetch)
    assert "0 frames written, 6 were finished before" in second_message


def test_cluster_export_handles_any_character_in_paths(capsys, tmp_path, cluster):
    odd = tmp_path / "a 'b' \"c\" % {{d}} $e\n#"
    odd.mkdir()
    shot = odd / "s.heatlens.json"
    write_shot(shot, shot_of(write_plates(odd / "plates")))
    export_shot(capsys, shot, tmp_path / "whole" / "n.####.exr")
    cluster.exported(shot, "-o", odd / "out" / "n.####.exr")
    assert files_in(odd / "out") == files_in(tmp_path / "whole")


def test_cluster_export_names_damaged_plate_and_worker(shot_file, tmp_path, cluster):
    """The damaged plate keeps its length, so only reading its pixels finds the damage."""
    plate = tmp_path / "plates" / "plate.1004.exr"
    data = bytearray(plate.read_bytes())
    data[-400:] = bytes(400)
    plate.write_bytes(data)
    assert cluster.export("failing", shot_file, "-o", tmp_path / "n.####.exr").wait(PATIENCE_S) == 2
    last = cluster.said("failing").splitlines()[-1]
    assert "plate.1004.exr" in last and "worker tcp://127.0.0.1" in last
    assert not list(tmp_path.glob(".heatlens-*"))


@pytest.mark.parametrize(
    ("changes", "expected"), [({"version": "9.9"}, "9.9"), ({}, "plate.1001.exr")]
)
def test_failed_task_names_cause_and_worker_address(tmp_path, cluster, changes, expected):
    """The causes are another version of heatlens and a disk without the plates."""
    missing = str(tmp_path / "plate.1001.exr")
    words = ("export", missing, f"--output={tmp_path}/n.exr", "--f-stop=2", "--focus-distance=2")
    task = replace(PartTask(words, "1", __version__, fetch=False, topic="topic"), **changes)
    with connected(cluster.address) as client, pytest.raises(InputError) as error:
        frames_of_answer(client.submit(make_part, task, pure=False).result())
    assert expected in str(error.value) and "worker tcp://127.0.0.1" in str(error.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fetch", [(), ("--fetch",)])
def test_cluster_export_warns_of_unusual_frames_like_one_machine(
    capsys, mixed_plates, tmp_path, cluster, fetch
):
    """The task whose frames are all in another unit compares them with the frame before it."""
    message_of_one_machine = export_shot(capsys, mixed_plates, tmp_path / "whole" / "n.####.exr")
    assert (
        "Frame 1004, and likewise 1005-1006: The depths are about 100 times"
        in message_of_one_machine
    )
    words = ("-o", tmp_path / "out" / "n.####.exr", "--chunk", 3, *fetch)
    assert (
        cluster.exported(mixed_plates, *words).splitlines()[:-1]
        == message_of_one_machine.splitlines()
    )


@pytest.mark.parametrize("fetch", [(), ("--fetch",)])
def test_full_disk_of_worker_is_reported_and_leaves_no_partial_file(
    shot_file, tmp_path, killable_cluster, fetch
):
    """A limit on the file size stands for the full disk, as writes fail alike."""
    killable_cluster.kill("worker 0")
    killable_cluster.work("full", limit="ulimit -f 1")
    out = tmp_path / "out"
    assert (
        killable_cluster.export("export", shot_file, "-o", out / "n.####.exr", *fetch).wait(
            PATIENCE_S
        )
        == 2
    )
    last = killable_cluster.said("export").splitlines()[-1]
    assert "could not be written" in last and "worker tcp://" in last
    assert files_in(out) == {}
    killable_cluster.kill("full")
    killable_cluster.work("another")
    assert "6 frames written" in killable_cluster.exported(
        shot_file, "-o", out / "n.####.exr", *fetch
    )


def test_worker_without_opengl_is_reported_with_its_address(shot_file, tmp_path, killable_cluster):
    killable_cluster.kill("worker 0")
    killable_cluster.work("blind", GLCONTEXT_LINUX_LIBEGL="no_such_library.so")
    assert (
        killable_cluster.export("export", shot_file, "-o", tmp_path / "out" / "n.####.exr").wait(
            PATIENCE_S
        )
        == 2
    )
    last = killable_cluster.said("export").splitlines()[-1]
    assert "No OpenGL 4.3" in last and "worker tcp://" in last
    assert files_in(tmp_path / "out") == {}


def test_cluster_movie_needs_no_encoder_on_workers(capsys, shot_file, tmp_path, killable_cluster):
    """Workers write lossless frames; the movie is joined where the export was started."""
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "av.py").write_text("raise ImportError('no such codec here')")
    killable_cluster.kill("worker 0")
    killable_cluster.work("poor", PYTHONPATH=str(tmp_path / "without"))
    export_shot(capsys, shot_file, tmp_path / "whole.mp4")
    killable_cluster.exported(shot_file, "-o", tmp_path / "m.mp4")
    assert (tmp_path / "m.mp4").read_bytes() == (tmp_path / "whole.mp4").read_bytes()


NOBODY = ("tcp://127.0.0.1:1", "bad://x:1", "localhost", "")
# Runs each of the command lines that it is given as JSON, and prints their exit codes.
IMPATIENT = (
    "import json, sys; from heatlens.deliver.farm import connection; connection.PATIENCE_S = 1;"
    "from heatlens.fronts.commands.main import main;"
    "print([main(['-q', *words]) for words in json.loads(sys.argv[1])])"
)


def test_missing_scheduler_is_reported_in_one_line(shot_file, tmp_path):
    """The export and the worker print one line, and Dask prints nothing, not even at its end."""
    export = ("export", str(shot_file), "-o", str(tmp_path / "n.####.exr"), "--cluster")
    lines = [words for address in NOBODY for words in ((*export, address), ("worker", address))]
    run = subprocess.run(
        [sys.executable, "-P", "-c", IMPATIENT, json.dumps(lines)],
        capture_output=True,
        text=True,
        check=True,
        timeout=PATIENCE_S,
    )
    assert json.loads(run.stdout) == [2] * len(lines)
    messages = run.stderr.splitlines()
    assert len(messages) == len(lines)
    assert all(it.startswith("heatlens: No Dask scheduler answers") for it in messages)
    assert not list(tmp_path.glob("n.*"))


def test_cluster_export_waits_for_first_worker_with_message(shot_file, tmp_path, killable_cluster):
    killable_cluster.kill("worker 0")
    export = killable_cluster.export("waiting", shot_file, "-o", tmp_path / "out" / "n.####.exr")
    wait_for(lambda: "no worker is there yet" in killable_cluster.said("waiting"))
    killable_cluster.work("late")
    assert export.wait(PATIENCE_S) == 0
    assert len(files_in(tmp_path / "out")) == 6


def test_cluster_export_completes_after_killed_worker(
    capsys, many_frames_shot, tmp_path, killable_cluster
):
    """Another worker renders the frames that were started; finished frames are kept."""
    export_shot(capsys, many_frames_shot, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out"
    export = killable_cluster.export(
        "export", many_frames_shot, "-o", out / "n.####.exr", "--chunk", 3
    )
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    killable_cluster.kill("worker 0")
    inodes_before = {path: path.stat().st_ino for path in out.glob("n.*")}
    killable_cluster.work("another")
    assert export.wait(PATIENCE_S) == 0, killable_cluster.said("export")
    assert files_in(out) == files_in(tmp_path / "whole")
    assert all(path.stat().st_ino == inode for path, inode in inodes_before.items())


def test_cluster_export_does_not_wait_for_lost_answer_of_dead_worker(
    capsys, shot_file, tmp_path, own_cluster, monkeypatch
):
    """The scheduler would wait forever for the answer; another worker renders the frames."""
    export_shot(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    answer_of, wait = cluster_export.answer_of, ClusterMaker._wait_for_workers

    def worker_dies_first(*of):
        if "worker 0" in own_cluster._running:
            own_cluster.kill("worker 0")
            wait_for(lambda: "Lost all workers" in own_cluster.said("scheduler"))
        return answer_of(*of)

    def another_comes(maker):
        if "worker 0" not in own_cluster._running and "another" not in own_cluster._running:
            own_cluster.work("another")
        wait(maker)

    monkeypatch.setattr(connection, "PATIENCE_S", 1)
    monkeypatch.setattr(cluster_export, "answer_of", worker_dies_first)
    monkeypatch.setattr(ClusterMaker, "_wait_for_workers", another_comes)
    words = "--cluster", own_cluster.address, "--fetch"
    message = export_shot(capsys, shot_file, tmp_path / "out" / "n.####.exr", *words)
    assert "no worker is there yet" in message
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


@pytest.mark.parametrize("stop_signal", [signal.SIGKILL, signal.SIGINT])
def test_stopped_cluster_export_can_be_resumed(
    capsys, many_frames_shot, tmp_path, killable_cluster, stop_signal
):
    export_shot(capsys, many_frames_shot, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out"
    export = killable_cluster.export(
        "export", many_frames_shot, "-o", out / "n.####.exr", "--chunk", 2
    )
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    killable_cluster.kill("export", stop_signal)
    assert export.returncode == (130 if stop_signal == signal.SIGINT else -9)
    killable_cluster.exported(many_frames_shot, "-o", out / "n.####.exr")
    assert files_in(out) == files_in(tmp_path / "whole")


@pytest.mark.parametrize(
    ("stop_signal", "output"), [(signal.SIGKILL, "n.####.exr"), (signal.SIGHUP, "m.mov")]
)
def test_cluster_export_continues_without_client_and_can_be_rejoined(
    capsys, many_frames_shot, tmp_path, killable_cluster, stop_signal, output
):
    """The cluster renders all frames without the client; a new client takes over the rest."""
    export_shot(capsys, many_frames_shot, tmp_path / "whole" / output)
    out = tmp_path / "out"
    export = killable_cluster.export("export", many_frames_shot, "-o", out / output, "--chunk", 2)
    wait_for(lambda: len(list(out.glob("**/*.exr"))) > 2)
    killable_cluster.kill("export", stop_signal)
    assert export.returncode == (129 if stop_signal == signal.SIGHUP else -9)
    wait_for(lambda: len(list(out.glob("**/*.exr"))) > 5)  # nobody asks for them now
    (worker,) = children_of(killable_cluster.process("worker 0"))
    os.kill(worker, signal.SIGSTOP)
    inodes_before = {path: path.stat().st_ino for path in out.glob("**/*.exr")}
    export = killable_cluster.export("again", many_frames_shot, "-o", out / output)
    wait_for(
        lambda: "goes on with what the cluster has under way" in killable_cluster.said("again")
    )
    os.kill(worker, signal.SIGCONT)
    assert export.wait(PATIENCE_S) == 0, killable_cluster.said("again")
    assert files_in(out) == files_in(tmp_path / "whole")
    assert all(
        path.stat().st_ino == inode for path, inode in inodes_before.items() if path.exists()
    )
    with connected(killable_cluster.address) as client:
        assert client.list_datasets() == ()


@pytest.mark.parametrize("stop_signal", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_cluster_export_cancels_its_tasks(
    many_frames_shot, tmp_path, killable_cluster, stop_signal
):
    out = tmp_path / "out"
    export = killable_cluster.export(
        "export", many_frames_shot, "-o", out / "n.####.exr", "--chunk", 1
    )
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    killable_cluster.kill("export", stop_signal)
    assert export.returncode == 128 + stop_signal
    with connected(killable_cluster.address) as client:
        assert client.list_datasets() == ()
        wait_for(lambda: not any(client.processing().values()))
    assert len(files_in(out)) < len(MANY_FRAMES)


def test_cluster_export_retries_task_that_failed_without_client(
    capsys, shot_file, tmp_path, killable_cluster
):
    """A task may have failed without a client, for example because a disk was full."""
    export_shot(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    words = [str(shot_file), "-o", str(tmp_path / "out" / "n.####.exr")]
    args = build_parser(["export"]).parse_args(["export", *words])
    topic = topic_of(plan_export(make_export_job(args)), fetch=False)
    with connected(killable_cluster.address) as client:
        failed = client.submit(int, "no number", key=f"{topic}:1:1001-1003")
        client.publish_dataset([failed], name=topic)
        wait_for(lambda: failed.status == "error")
    killable_cluster.exported(*words)
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    with connected(killable_cluster.address) as client:
        assert client.list_datasets() == ()


def test_lost_connection_to_scheduler_is_reported():
    class Lost:
        def nthreads(self):
            raise CommClosedError("in <TCP (closed)>: Stream is closed")

    task = PartTask(words=(), frames="", version="", fetch=False, topic="")
    maker = ClusterMaker(client=Lost(), work=lambda task: b"", task=task, chunk=None, report=print)
    with pytest.raises(InputError, match="The scheduler has gone"):
        list(maker([]))


def test_tasks_are_sent_where_the_last_worker_has_just_left():
    """The scheduler keeps the tasks for the next worker."""

    class Left:
        def __init__(self):
            self.worker_counts, self.sent = [{"tcp://a": 1}, {}], []

        def nthreads(self):
            return self.worker_counts.pop(0)

        def submit(self, _work, task, **_words):
            self.sent.append(task.frames)
            raise CommClosedError("the tasks are sent")

        def subscribe_topic(self, *_words):
            pass

        def get_dataset(self, *_words, default):
            return default

    client = Left()
    task = PartTask(words=(), frames="", version="", fetch=False, topic="")
    maker = ClusterMaker(client=client, work=lambda task: b"", task=task, chunk=None, report=print)
    frames = [SimpleNamespace(frame=frame) for frame in (1001, 1002)]
    with pytest.raises(InputError, match="The scheduler has gone"):
        list(maker(frames))
    assert len(client.sent) == 1


def test_death_of_scheduler_is_reported_and_export_can_be_resumed(
    capsys, many_frames_shot, tmp_path, own_cluster
):
    export_shot(capsys, many_frames_shot, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out"
    export = own_cluster.export("export", many_frames_shot, "-o", out / "n.####.exr", "--chunk", 2)
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    own_cluster.kill("scheduler")
    assert export.wait(PATIENCE_S) == 2
    assert "The scheduler has gone" in own_cluster.said("export").splitlines()[-1]
    assert own_cluster.ended("worker 0") == 0 and "the scheduler has ended" in own_cluster.said(
        "worker 0"
    )
    own_cluster.schedule()
    own_cluster.work()
    own_cluster.exported(many_frames_shot, "-o", out / "n.####.exr")
    assert files_in(out) == files_in(tmp_path / "whole")


def test_worker_command_runs_several_processes(capsys, many_frames_shot, tmp_path):
    """If one process is killed, the other continues; Ctrl-C ends all processes."""
    export_shot(capsys, many_frames_shot, tmp_path / "whole" / "n.####.exr")
    with dask_cluster(tmp_path / "cluster", workers=0) as cluster:
        cluster.work("two", more=("--processes", "2", "--device", "0,0"))
        wait_for(lambda: cluster.said("two").count("works for") == 2)
        out = tmp_path / "out"
        export = cluster.export("export", many_frames_shot, "-o", out / "n.####.exr", "--chunk", 2)
        wait_for(lambda: len(list(out.glob("n.*"))) > 2)
        (inner,) = children_of(cluster.process("two"))
        workers = children_of(inner)
        assert len(workers) == 2
        os.kill(workers[0], signal.SIGKILL)
        assert export.wait(PATIENCE_S) == 0, cluster.said("export")
        assert files_in(out) == files_in(tmp_path / "whole")
        cluster.kill("two", signal.SIGINT)
        wait_for(lambda: not any(os.path.exists(f"/proc/{worker}") for worker in workers))


@pytest.mark.parametrize("words", [("--processes", "0"), ("--device", "0,1"), ("--device", "-1")])
def test_worker_command_rejects_impossible_options(capsys, words):
    assert main(["worker", "tcp://127.0.0.1:1", *words]) == 2
    assert capsys.readouterr().err.count("\n") == 1
