"""`export --cluster` and `heatlens worker`: a Dask scheduler and workers on loopback."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import pytest
from distributed.comm import CommClosedError

from heatlens.core.base.errors import InputError
from heatlens.deliver.export.plan import planned
from heatlens.deliver.farm import cluster as cluster_export
from heatlens.deliver.farm import connection
from heatlens.deliver.farm.answers import parts_of_answer
from heatlens.deliver.farm.cluster import ClusterMaker, PartTask, topic_of
from heatlens.deliver.farm.connection import connected
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.export_options import job_of
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.worker import made_part
from heatlens.media.documents.shot_file import write_shot
from heatlens.version import __version__
from support.dask_cluster import children_of, dask_cluster, wait_for
from support.exports import MANY, exported, files_in, shot_of, write_plates


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("cluster"), workers=2) as found:
        yield found


@pytest.fixture
def lost(scheduler):
    """A cluster whose workers and exports are killed."""
    scheduler.work("worker 0")
    yield scheduler
    scheduler.stop(but=("scheduler",))


@pytest.fixture
def own(tmp_path):
    """A cluster of which the scheduler is killed too, or what it says is read."""
    with dask_cluster(tmp_path / "cluster", workers=1) as found:
        yield found


@pytest.fixture
def many(tmp_path):
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(write_plates(tmp_path / "plates", MANY), MANY))
    return shot


@pytest.mark.parametrize(
    ("output", "fetch"),
    [("n.####.exr", ()), ("n.####.png", ("--fetch",)), ("m.mov", ("--fetch",))],
)
def test_a_cluster_makes_what_one_machine_makes(
    capsys, shot_file, tmp_path, cluster, output, fetch
):
    exported(capsys, shot_file, tmp_path / "whole" / output)
    said = cluster.exported(shot_file, "-o", tmp_path / "out" / output, *fetch)
    assert "6 frames written" in said
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    assert not list((tmp_path / "out").glob("*.frames"))
    again = cluster.exported(shot_file, "-o", tmp_path / "out" / output, *fetch)
    assert "0 frames written, 6 were finished before" in again


def test_names_with_any_character_arrive(capsys, tmp_path, cluster):
    odd = tmp_path / "a 'b' \"c\" % {{d}} $e\n#"
    odd.mkdir()
    shot = odd / "s.heatlens.json"
    write_shot(shot, shot_of(write_plates(odd / "plates")))
    exported(capsys, shot, tmp_path / "whole" / "n.####.exr")
    cluster.exported(shot, "-o", odd / "out" / "n.####.exr")
    assert files_in(odd / "out") == files_in(tmp_path / "whole")


def test_a_plate_that_a_worker_cannot_read_is_named_with_the_worker(shot_file, tmp_path, cluster):
    """Its length is right, and its pixels are not: nobody can see that before it is read."""
    plate = tmp_path / "plates" / "plate.1004.exr"
    data = bytearray(plate.read_bytes())
    data[-400:] = bytes(400)
    plate.write_bytes(data)
    assert cluster.export("failing", shot_file, "-o", tmp_path / "n.####.exr").wait(60) == 2
    last = cluster.said("failing").splitlines()[-1]
    assert "plate.1004.exr" in last and "worker tcp://127.0.0.1" in last
    assert not list(tmp_path.glob(".heatlens-*"))


@pytest.mark.parametrize(
    ("changes", "expected"), [({"version": "9.9"}, "9.9"), ({}, "plate.1001.exr")]
)
def test_what_a_worker_cannot_do_is_told_with_its_address(tmp_path, cluster, changes, expected):
    """Another version, and a disk without the plates."""
    missing = str(tmp_path / "plate.1001.exr")
    words = ("export", missing, f"--output={tmp_path}/n.exr", "--f-stop=2", "--focus-distance=2")
    task = replace(PartTask(words, "1", __version__, False, "topic"), **changes)
    with connected(cluster.address) as client, pytest.raises(InputError) as told:
        parts_of_answer(client.submit(made_part, task, pure=False).result())
    assert expected in str(told.value) and "worker tcp://127.0.0.1" in str(told.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fetch", [(), ("--fetch",)])
def test_unusual_frames_are_told_as_by_one_machine(capsys, mixed_plates, tmp_path, cluster, fetch):
    """The task whose frames are all unusual compares them with the frame before."""
    alone = exported(capsys, mixed_plates, tmp_path / "whole" / "n.####.exr")
    assert "Frame 1004, and likewise 1005-1006: The depths are about 100 times" in alone
    words = ("-o", tmp_path / "out" / "n.####.exr", "--chunk", 3, *fetch)
    assert cluster.exported(mixed_plates, *words).splitlines()[:-1] == alone.splitlines()


@pytest.mark.parametrize("fetch", [(), ("--fetch",)])
def test_a_full_disk_of_a_worker_is_told_and_leaves_nothing_half(shot_file, tmp_path, lost, fetch):
    """A limit on the size of files stands for it: the library's writes fail likewise."""
    lost.kill("worker 0")
    lost.work("full", limit="ulimit -f 1")
    out = tmp_path / "out"
    assert lost.export("export", shot_file, "-o", out / "n.####.exr", *fetch).wait(60) == 2
    last = lost.said("export").splitlines()[-1]
    assert "could not be written" in last and "worker tcp://" in last
    assert files_in(out) == {}
    lost.kill("full")
    lost.work("another")
    assert "6 frames written" in lost.exported(shot_file, "-o", out / "n.####.exr", *fetch)


def test_a_worker_without_opengl_is_told_with_its_address(shot_file, tmp_path, lost):
    lost.kill("worker 0")
    lost.work("blind", GLCONTEXT_LINUX_LIBEGL="no_such_library.so")
    assert lost.export("export", shot_file, "-o", tmp_path / "out" / "n.####.exr").wait(60) == 2
    last = lost.said("export").splitlines()[-1]
    assert "No OpenGL 4.3" in last and "worker tcp://" in last
    assert files_in(tmp_path / "out") == {}


def test_workers_need_no_encoder(capsys, shot_file, tmp_path, lost):
    """They make lossless frames; the movie is joined where the export was started."""
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "av.py").write_text("raise ImportError('no such codec here')")
    lost.kill("worker 0")
    lost.work("poor", PYTHONPATH=str(tmp_path / "without"))
    exported(capsys, shot_file, tmp_path / "whole.mp4")
    lost.exported(shot_file, "-o", tmp_path / "m.mp4")
    assert (tmp_path / "m.mp4").read_bytes() == (tmp_path / "whole.mp4").read_bytes()


NOBODY = ("tcp://127.0.0.1:1", "bad://x:1", "localhost", "")
IMPATIENT = (
    "from heatlens.deliver.farm import connection; connection.PATIENCE_S = 1;"
    "from heatlens.fronts.commands.main import main; raise SystemExit(main())"
)


@pytest.mark.parametrize("address", NOBODY)
def test_a_scheduler_that_is_not_there(shot_file, tmp_path, address):
    """The export and the worker say so in one sentence, and Dask says nothing beside it."""
    words = ("export", str(shot_file), "-o", str(tmp_path / "n.####.exr"), "--cluster", address)
    for line in (words, ("worker", address)):
        run = subprocess.run(
            [sys.executable, "-P", "-c", IMPATIENT, "-q", *line],
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert run.returncode == 2
        assert run.stderr.startswith("heatlens: No Dask scheduler answers")
        assert run.stderr.count("\n") == 1
    assert not list(tmp_path.glob("n.*"))


def test_it_waits_for_the_first_worker_and_says_so(shot_file, tmp_path, lost):
    lost.kill("worker 0")
    export = lost.export("waiting", shot_file, "-o", tmp_path / "out" / "n.####.exr")
    wait_for(lambda: "no worker is there yet" in lost.said("waiting"))
    lost.work("late")
    assert export.wait(60) == 0
    assert len(files_in(tmp_path / "out")) == 6


def test_a_killed_worker_loses_nothing(capsys, many, tmp_path, lost):
    """Another one makes what it had begun; whatever was finished stays."""
    exported(capsys, many, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out"
    export = lost.export("export", many, "-o", out / "n.####.exr", "--chunk", 3)
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    lost.kill("worker 0")
    before = {path: path.stat().st_ino for path in out.glob("n.*")}
    lost.work("another")
    assert export.wait(60) == 0, lost.said("export")
    assert files_in(out) == files_in(tmp_path / "whole")
    assert all(path.stat().st_ino == inode for path, inode in before.items())


def test_a_worker_that_dies_with_its_answer_is_not_awaited(
    capsys, shot_file, tmp_path, own, monkeypatch
):
    """The scheduler would wait for it for ever; another one makes its frames."""
    exported(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    answer_of, wait = cluster_export.answer_of, ClusterMaker._wait_for_workers

    def worker_dies_first(*of):
        if "worker 0" in own._running:
            own.kill("worker 0")
            wait_for(lambda: "Lost all workers" in own.said("scheduler"))
        return answer_of(*of)

    def another_comes(maker):
        if "worker 0" not in own._running and "another" not in own._running:
            own.work("another")
        wait(maker)

    monkeypatch.setattr(connection, "PATIENCE_S", 1)
    monkeypatch.setattr(cluster_export, "answer_of", worker_dies_first)
    monkeypatch.setattr(ClusterMaker, "_wait_for_workers", another_comes)
    words = "--cluster", own.address, "--fetch"
    said = exported(capsys, shot_file, tmp_path / "out" / "n.####.exr", *words)
    assert "no worker is there yet" in said
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_stopped_export_goes_on_where_it_was(capsys, many, tmp_path, lost, how):
    exported(capsys, many, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out"
    export = lost.export("export", many, "-o", out / "n.####.exr", "--chunk", 2)
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    lost.kill("export", how)
    assert export.returncode == (130 if how == signal.SIGINT else -9)
    lost.exported(many, "-o", out / "n.####.exr")
    assert files_in(out) == files_in(tmp_path / "whole")


@pytest.mark.parametrize(
    ("how", "output"), [(signal.SIGKILL, "n.####.exr"), (signal.SIGHUP, "m.mov")]
)
def test_an_export_whose_terminal_is_gone_goes_on_and_is_followed_again(
    capsys, many, tmp_path, lost, how, output
):
    """The cluster makes all frames without the client; a new one finds them, or those left."""
    exported(capsys, many, tmp_path / "whole" / output)
    out = tmp_path / "out"
    export = lost.export("export", many, "-o", out / output, "--chunk", 2)
    wait_for(lambda: len(list(out.glob("**/*.exr"))) > 2)
    lost.kill("export", how)
    assert export.returncode == (129 if how == signal.SIGHUP else -9)
    wait_for(lambda: len(list(out.glob("**/*.exr"))) > 5)  # nobody asks for them now
    (worker,) = children_of(lost.process("worker 0"))
    os.kill(worker, signal.SIGSTOP)
    before = {path: path.stat().st_ino for path in out.glob("**/*.exr")}
    export = lost.export("again", many, "-o", out / output)
    wait_for(lambda: "goes on with what the cluster has under way" in lost.said("again"))
    os.kill(worker, signal.SIGCONT)
    assert export.wait(60) == 0, lost.said("again")
    assert files_in(out) == files_in(tmp_path / "whole")
    assert all(path.stat().st_ino == inode for path, inode in before.items() if path.exists())
    with connected(lost.address) as client:
        assert client.list_datasets() == ()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_export_that_is_stopped_leaves_nothing_at_the_scheduler(many, tmp_path, lost, how):
    out = tmp_path / "out"
    export = lost.export("export", many, "-o", out / "n.####.exr", "--chunk", 1)
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    lost.kill("export", how)
    assert export.returncode == 128 + how
    with connected(lost.address) as client:
        assert client.list_datasets() == ()
        wait_for(lambda: not any(client.processing().values()))
    assert len(files_in(out)) < len(MANY)


def test_what_failed_while_nobody_looked_is_tried_again(capsys, shot_file, tmp_path, lost):
    """For example on a disk that was full."""
    exported(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    words = [str(shot_file), "-o", str(tmp_path / "out" / "n.####.exr")]
    args = build_parser(["export"]).parse_args(["export", *words])
    topic = topic_of(planned(job_of(args)), False)
    with connected(lost.address) as client:
        failed = client.submit(int, "no number", key=f"{topic}:1:1001-1003")
        client.publish_dataset([failed], name=topic)
        wait_for(lambda: failed.status == "error")
    lost.exported(*words)
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    with connected(lost.address) as client:
        assert client.list_datasets() == ()


def test_a_connection_that_breaks_in_the_middle_of_an_answer_is_told():
    class Lost:
        def nthreads(self):
            raise CommClosedError("in <TCP (closed)>: Stream is closed")

    task = PartTask((), "", "", False, "")
    maker = ClusterMaker(Lost(), lambda task: b"", task, None, print)
    with pytest.raises(InputError, match="The scheduler has gone"):
        list(maker([]))


def test_a_scheduler_that_dies_is_told_and_nothing_is_lost(capsys, many, tmp_path, own):
    exported(capsys, many, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out"
    export = own.export("export", many, "-o", out / "n.####.exr", "--chunk", 2)
    wait_for(lambda: len(list(out.glob("n.*"))) > 2)
    own.kill("scheduler")
    assert export.wait(60) == 2
    assert "The scheduler has gone" in own.said("export").splitlines()[-1]
    assert own.ended("worker 0") == 0 and "the scheduler has ended" in own.said("worker 0")
    own.schedule()
    own.work()
    own.exported(many, "-o", out / "n.####.exr")
    assert files_in(out) == files_in(tmp_path / "whole")


def test_one_worker_command_runs_several_processes(capsys, many, tmp_path):
    """One of them is killed and the other goes on; Ctrl-C ends all that it started."""
    exported(capsys, many, tmp_path / "whole" / "n.####.exr")
    with dask_cluster(tmp_path / "cluster", workers=0) as cluster:
        cluster.work("two", more=("--processes", "2", "--device", "0,0"))
        wait_for(lambda: cluster.said("two").count("works for") == 2)
        out = tmp_path / "out"
        export = cluster.export("export", many, "-o", out / "n.####.exr", "--chunk", 2)
        wait_for(lambda: len(list(out.glob("n.*"))) > 2)
        (inner,) = children_of(cluster.process("two"))
        workers = children_of(inner)
        assert len(workers) == 2
        os.kill(workers[0], signal.SIGKILL)
        assert export.wait(60) == 0, cluster.said("export")
        assert files_in(out) == files_in(tmp_path / "whole")
        cluster.kill("two", signal.SIGINT)
        wait_for(lambda: not any(os.path.exists(f"/proc/{worker}") for worker in workers))


@pytest.mark.parametrize("words", [("--processes", "0"), ("--device", "0,1"), ("--device", "-1")])
def test_a_worker_that_cannot_be_started_so(capsys, words):
    assert main(["worker", "tcp://127.0.0.1:1", *words]) == 2
    assert capsys.readouterr().err.count("\n") == 1
