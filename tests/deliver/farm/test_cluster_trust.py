"""Test that messages of a cluster run no code here, and that only files found here count."""

import asyncio
import os
import subprocess

import distributed
import psutil
import pytest
from distributed.comm import connect, listen
from distributed.protocol.serialize import ToPickle

from heatlens.core.base.errors import InputError
from heatlens.deliver.farm import elsewhere
from heatlens.deliver.farm.connection import (
    connected,
    identify_scheduler_safely,
    is_loss,
    library,
    own_host,
)
from heatlens.deliver.farm.data_only import NotDataError, take_only_data
from heatlens.fronts.commands.main import main
from support.dask_cluster import DaskCluster, dask_cluster, wait_for
from support.exports import export_shot, files_in, refused_export_message
from support.lying_worker import ANSWERS, LIES
from support.patience import PATIENCE_S

RUNS = """
from pathlib import Path
from distributed.protocol.serialize import ToPickle

class Ran:
    def __reduce__(self):
        import os
        return os.system, ("touch %s",)

async def dask_setup(scheduler):
    scheduler.handlers["%s"] = lambda *_, **__: {"id": "x", "workers": ToPickle(Ran())}
"""


@pytest.fixture(scope="module")
def lying_cluster(tmp_path_factory):
    """Start a cluster whose one worker sends false answers, for the tests of the file."""
    with dask_cluster(tmp_path_factory.mktemp("liars"), workers=0) as cluster:
        yield cluster


@pytest.fixture
def other_workers(scheduler):
    """Yield a cluster for workers of a test, which are killed at its end."""
    yield scheduler
    scheduler.stop(but=("scheduler",))


def listening_addresses(process: int) -> set[str]:
    """Return the IP addresses on which a process and its children listen."""
    family = [psutil.Process(process), *psutil.Process(process).children(recursive=True)]
    connections = [it for member in family for it in member.net_connections("tcp")]
    return {it.laddr.ip for it in connections if it.status == psutil.CONN_LISTEN}


def test_worker_on_loopback_listens_on_loopback_only(other_workers, tmp_path):
    other_workers.work("here", TMPDIR=str(tmp_path))
    wait_for(lambda: "works for" in other_workers.said("here"))
    assert listening_addresses(other_workers.process("here")) == {"127.0.0.1"}
    worker_files = list(tmp_path.iterdir())
    assert worker_files and all(it.stat().st_mode & 0o77 == 0 for it in worker_files), worker_files


def test_scheduler_of_manual_listens_on_loopback_only(scheduler):
    assert listening_addresses(scheduler.process("scheduler")) == {"127.0.0.1"}


def test_own_host_is_address_that_reaches_scheduler():
    assert own_host("tcp://127.0.0.1:8786") == "127.0.0.1"
    assert own_host("tcp://[::1]:8786") == "::1"


def test_worker_rejects_host_that_is_not_of_this_machine(capsys, scheduler):
    assert main(["worker", scheduler.address, "--host", "192.0.2.7"]) == 2
    assert "no address of this machine" in capsys.readouterr().err


@pytest.fixture
def no_late_files(monkeypatch):
    """Set the waiting time for late files of network disks to 0 s."""
    monkeypatch.setattr(elsewhere, "_LATE_FILES_S", 0.0)


def test_connection_that_sends_pickled_code_is_closed():
    """Without closing, each such message would leave a socket open."""
    take_only_data(library())

    async def talk() -> bool:
        async def says(connection) -> None:
            await connection.write({"x": ToPickle(os.getcwd)})

        async with listen("tcp://127.0.0.1:0", says) as listener:
            connection = await connect(listener.contact_address)
            with pytest.raises(NotDataError, match="getcwd"):
                await connection.read()
            return bool(connection.closed())

    assert asyncio.run(talk())


def test_client_that_lost_its_scheduler_connects_no_more(scheduler):
    with connected(scheduler.address) as client:
        task = client.submit(os.getcwd)
        client.loop.add_callback(client.scheduler_comm.comm.abort)
        with pytest.raises(Exception) as caught:
            task.result(timeout=PATIENCE_S)
        assert is_loss(caught.value)
        wait_for(client._handle_report_task.done)
        assert client.status != "running" and client.scheduler_comm is None


@pytest.mark.parametrize("answer_kind", sorted(ANSWERS))
def test_export_runs_no_code_from_answers_of_workers(
    capsys, shot_file, tmp_path, lying_cluster, answer_kind, no_late_files
):
    out = tmp_path / "out"
    lying_cluster.lie("liar", answer_kind, tmp_path / "ran")
    message = refused_export_message(
        capsys, shot_file, out / "n.####.exr", "--cluster", lying_cluster.address
    )
    assert not (tmp_path / f"ran.{os.getpid()}").exists()
    assert "\x1b" not in message and len(message.splitlines()[-1]) < 900
    assert files_in(out) == {}


@pytest.mark.parametrize("lie_kind", sorted(LIES))
@pytest.mark.parametrize("fetch", [(), ("--fetch",)])
def test_export_trusts_no_false_reports_of_workers(
    capsys, shot_file, tmp_path, lying_cluster, lie_kind, fetch, no_late_files
):
    """No false report of a worker starts the `--after-export` command or passes a wrong file."""
    out = tmp_path / "out"
    lying_cluster.lie("liar", lie_kind, tmp_path / "ran")
    words = (out / "n.####.exr", "--cluster", lying_cluster.address, *fetch)
    message = refused_export_message(
        capsys, shot_file, *words, "--after-export", f"touch {tmp_path / 'after'}"
    )
    last = message.splitlines()[-1]
    assert "of 6 frames are not in" in last or "has sent a damaged file" in last, last
    assert ("--fetch" in last) == (not fetch)
    assert not (tmp_path / f"ran.{os.getpid()}").exists()
    assert not (tmp_path / "after").exists() and "\x1b" not in message
    assert not list(tmp_path.glob("**/.heatlens-*"))
    assert not (fetch and files_in(out))


def test_frames_on_private_worker_disk_are_missing_unless_fetched(
    capsys, shot_file, tmp_path, other_workers
):
    """The workers write to a disk that this machine cannot see, and report frames as written."""
    worker_folder, out = tmp_path / "own", tmp_path / "out"
    out.mkdir()
    worker_folder.mkdir()
    mount = f"mount --bind {worker_folder} {out}"
    mount_attempt = subprocess.run(
        ["unshare", "-rm", "sh", "-c", mount], check=False, capture_output=True
    )
    if mount_attempt.returncode:
        pytest.skip("this system lets nobody have mounts of his own")
    other_workers.work("away", limit=f'exec unshare -rm sh -c \'{mount}; exec "$@"\' sh "$@"')
    export = other_workers.export("export", shot_file, "-o", out / "n.####.exr")
    assert export.wait(PATIENCE_S) == 2
    last = other_workers.said("export").splitlines()[-1]
    assert "6 of 6 frames are not in" in last and "--fetch brings" in last
    assert files_in(out) == {} and len(files_in(worker_folder)) == 6
    export_shot(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    other_workers.exported(shot_file, "-o", out / "n.####.exr", "--fetch")
    assert files_in(out) == files_in(tmp_path / "whole")


@pytest.mark.parametrize("handler", ["identity", "versions", "gather", "publish_get"])
def test_export_runs_no_code_from_messages_of_scheduler(shot_file, tmp_path, handler):
    ran, cluster = tmp_path / "ran", DaskCluster(tmp_path)
    (tmp_path / "runs.py").write_text(RUNS % (ran, handler))
    try:
        cluster.schedule("--preload", str(tmp_path / "runs.py"))
        if handler in ("gather", "publish_get"):
            cluster.work("worker 0")
        export = cluster.export("export", shot_file, "-o", tmp_path / "out" / "n.####.exr")
        assert export.wait(PATIENCE_S) == 2, cluster.said("export")
    finally:
        cluster.stop()
    assert not ran.exists() and "Traceback" not in cluster.said("export")


def test_other_dask_version_of_scheduler_is_reported(scheduler, monkeypatch):
    monkeypatch.setattr(distributed, "__version__", "2025.1.0")
    with pytest.raises(InputError, match=r"has Dask .* but this machine has 2025\.1\.0"):
        identify_scheduler_safely(scheduler.address)
