"""Nothing that a cluster sends runs code here, or counts as made before it is seen here."""

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
from heatlens.deliver.farm.connection import library, met, own_host
from heatlens.deliver.farm.data_only import NotDataError, take_only_data
from heatlens.fronts.commands.main import main
from support.dask_cluster import DaskCluster, wait_for
from support.exports import exported, files_in, refused
from support.lying_worker import ANSWERS, LIES

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


@pytest.fixture
def liars(scheduler):
    """A cluster whose workers do not do what they say."""
    yield scheduler
    scheduler.stop(but=("scheduler",))


def listening(process: int) -> set[str]:
    """Return the addresses on which a process and its children listen."""
    all_of = [psutil.Process(process), *psutil.Process(process).children(recursive=True)]
    found = [it for of in all_of for it in of.net_connections("tcp")]
    return {it.laddr.ip for it in found if it.status == psutil.CONN_LISTEN}


def test_a_worker_on_loopback_is_reached_by_no_network(liars, tmp_path):
    liars.work("here", TMPDIR=str(tmp_path))
    wait_for(lambda: "works for" in liars.said("here"))
    assert listening(liars.process("here")) == {"127.0.0.1"}
    made = list(tmp_path.iterdir())
    assert made and all(it.stat().st_mode & 0o77 == 0 for it in made), made


def test_the_scheduler_of_the_manual_is_reached_by_no_network(scheduler):
    assert listening(scheduler.process("scheduler")) == {"127.0.0.1"}


def test_own_address_is_the_one_that_reaches_the_other():
    assert own_host("tcp://127.0.0.1:8786") == "127.0.0.1"
    assert own_host("tcp://[::1]:8786") == "::1"


def test_a_worker_listens_on_no_address_of_others(capsys, scheduler):
    assert main(["worker", scheduler.address, "--host", "192.0.2.7"]) == 2
    assert "no address of this machine" in capsys.readouterr().err


@pytest.fixture
def impatient(monkeypatch):
    """No file comes late, as it may from a network disk."""
    monkeypatch.setattr(elsewhere, "_LATE_S", 0.0)


def test_a_connection_that_sends_code_is_closed():
    """Else each such message would leave a socket open."""
    take_only_data(library())

    async def talk() -> bool:
        async def says(other) -> None:
            await other.write({"x": ToPickle(os.getcwd)})

        async with listen("tcp://127.0.0.1:0", says) as listener:
            line = await connect(listener.contact_address)
            with pytest.raises(NotDataError, match="getcwd"):
                await line.read()
            return bool(line.closed())

    assert asyncio.run(talk())


@pytest.mark.parametrize("how", sorted(ANSWERS))
def test_no_answer_of_a_worker_runs_code_here(capsys, shot_file, tmp_path, liars, how, impatient):
    out = tmp_path / "out"
    liars.lie("liar", how, RAN=str(tmp_path / "ran"))
    said = refused(capsys, shot_file, out / "n.####.exr", "--cluster", liars.address)
    assert not (tmp_path / f"ran.{os.getpid()}").exists()
    assert "\x1b" not in said and len(said.splitlines()[-1]) < 900
    assert files_in(out) == {}


@pytest.mark.parametrize("how", sorted(LIES))
@pytest.mark.parametrize("fetch", [(), ("--fetch",)])
def test_only_what_is_here_is_made(capsys, shot_file, tmp_path, liars, how, fetch, impatient):
    """Whatever the workers report, what follows does not run, and no wrong file counts as made."""
    out = tmp_path / "out"
    liars.lie("liar", how, RAN=str(tmp_path / "ran"))
    words = (out / "n.####.exr", "--cluster", liars.address, *fetch)
    said = refused(capsys, shot_file, *words, "--after-export", f"touch {tmp_path / 'after'}")
    last = said.splitlines()[-1]
    assert "of 6 frames are not in" in last or "is not the finished file" in last, last
    assert ("--fetch" in last) == (not fetch)
    assert not (tmp_path / f"ran.{os.getpid()}").exists()
    assert not (tmp_path / "after").exists() and "\x1b" not in said
    assert not list(tmp_path.glob("**/.heatlens-*"))
    assert not (fetch and files_in(out))


def test_honest_workers_with_disks_of_their_own(capsys, shot_file, tmp_path, liars):
    """They write where this machine sees nothing, and report each frame as written."""
    own, out = tmp_path / "own", tmp_path / "out"
    out.mkdir()
    own.mkdir()
    mount = f"mount --bind {own} {out}"
    tried = subprocess.run(["unshare", "-rm", "sh", "-c", mount], check=False, capture_output=True)
    if tried.returncode:
        pytest.skip("this system lets nobody have mounts of his own")
    liars.work("away", limit=f'exec unshare -rm sh -c \'{mount}; exec "$@"\' sh "$@"')
    export = liars.export("export", shot_file, "-o", out / "n.####.exr")
    assert export.wait(90) == 2
    last = liars.said("export").splitlines()[-1]
    assert "6 of 6 frames are not in" in last and "--fetch brings" in last
    assert files_in(out) == {} and len(files_in(own)) == 6
    exported(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    liars.exported(shot_file, "-o", out / "n.####.exr", "--fetch")
    assert files_in(out) == files_in(tmp_path / "whole")


@pytest.mark.parametrize("handler", ["identity", "versions", "gather", "publish_get"])
def test_no_message_of_a_scheduler_runs_code_here(shot_file, tmp_path, handler):
    ran, cluster = tmp_path / "ran", DaskCluster(tmp_path)
    (tmp_path / "runs.py").write_text(RUNS % (ran, handler))
    try:
        cluster.schedule("--preload", str(tmp_path / "runs.py"))
        if handler in ("gather", "publish_get"):
            cluster.work("worker 0")
        export = cluster.export("export", shot_file, "-o", tmp_path / "out" / "n.####.exr")
        assert export.wait(60) == 2, cluster.said("export")
    finally:
        cluster.stop()
    assert not ran.exists() and "Traceback" not in cluster.said("export")


def test_another_version_of_dask_is_told(scheduler, monkeypatch):
    monkeypatch.setattr(distributed, "__version__", "2025.1.0")
    with pytest.raises(InputError, match=r"has Dask .* but this machine has 2025\.1\.0"):
        met(scheduler.address)
