"""A Dask cluster on loopback, for tests: a scheduler and workers, each a process of its own."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from heatlens.fronts.commands.main import main
from support.patience import PATIENCE_S

QUIET = ("--no-dashboard", "--dashboard-address", "127.0.0.1:0")
HEATLENS = (sys.executable, "-P", "-m", "heatlens")


class DaskCluster:
    """A scheduler and its workers as processes; each writes its output to a log in the folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.port = 0  # the scheduler chooses one, which no other process can take before
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        # A killed worker cannot remove its temporary files.
        self._temporary = TemporaryDirectory(prefix="dask-", ignore_cleanup_errors=True)

    def schedule(self, *more: str) -> None:
        words = ("--host", "127.0.0.1", "--port", str(self.port), *QUIET, *more)
        line = [sys.executable, "-m", "distributed.cli.dask_scheduler", *words]
        self._start("scheduler", line)
        wait_for(lambda: self._scheduler_port() or self._running["scheduler"].poll() is not None)
        self.port = self._scheduler_port()
        assert self.port, self.said("scheduler")

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def _scheduler_port(self) -> int:
        """Return the port that the scheduler names in its log; 0 before that."""
        match = re.search(r"Scheduler at: +tcp://[0-9.]+:(\d+)\n", self.said("scheduler"))
        return int(match[1]) if match else 0

    def work(
        self, name: str = "one", limit: str = "", more: Sequence[str] = (), **environment: str
    ) -> None:
        """Start a worker; `limit` is a shell command that runs first, such as ulimit."""
        line = [*HEATLENS, "worker", self.address, *more]
        line = ["bash", "-c", f'{limit}; exec "$@"', "bash", *line] if limit else line
        self._start(name, line, environment)

    def lie(self, name: str, how: str, ran: Path) -> None:
        """Let a worker send false answers of the kind `how`, see `lying_worker.py`.

        Code that it sends makes files `ran` with a process id. The worker is started if none runs.
        """
        lie_file = self.folder / f"{name}.lie"
        lie_file.write_text(f"{how}\n{ran}\n")
        if name not in self._running or self._running[name].poll() is not None:
            line = [sys.executable, "-P", "-m", "support.lying_worker", self.address, str(lie_file)]
            self._start(name, line, {"PYTHONPATH": str(Path(__file__).parents[1])})

    def export(self, name: str, *words: object) -> "subprocess.Popen[bytes]":
        """Start an export on this cluster."""
        line = [*HEATLENS, "export", *map(str, words), "--cluster", self.address]
        return self._start(name, line)

    def exported(self, *words: object) -> str:
        """Run an export on this cluster from this process. Return its output; it must succeed."""
        said = StringIO()
        with redirect_stdout(said), redirect_stderr(said):
            code = main(["export", *map(str, words), "--cluster", self.address])
        assert code == 0, said.getvalue()
        return said.getvalue()

    def _start(
        self, name: str, line: list[str], environment: dict[str, str] | None = None
    ) -> "subprocess.Popen[bytes]":
        settings = os.environ | {"TMPDIR": self._temporary.name} | (environment or {})
        with (self.folder / f"{name}.log").open("wb") as log:
            self._running[name] = subprocess.Popen(line, stdout=log, stderr=log, env=settings)
        return self._running[name]

    def said(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text()

    def process(self, name: str) -> int:
        """Return the number of a running process."""
        return self._running[name].pid

    def ended(self, name: str) -> int:
        """Wait until a process has ended by itself; return its exit code."""
        return self._running.pop(name).wait(PATIENCE_S)

    def kill(self, name: str, how: signal.Signals = signal.SIGKILL) -> None:
        """Kill a process and its children; other signals than SIGKILL go to the process only."""
        process = self._running.pop(name)
        if how == signal.SIGKILL:
            for child in children_of(process.pid):
                os.kill(child, how)
        process.send_signal(how)
        process.wait(PATIENCE_S)

    def stop(self, but: Sequence[str] = ()) -> None:
        for name in self._running.keys() - set(but):
            self.kill(name)
        if not self._running:
            self._temporary.cleanup()


def children_of(process: int) -> list[int]:
    try:
        text = Path(f"/proc/{process}/task/{process}/children").read_text()
    except OSError:  # it has ended
        return []
    return [int(word) for word in text.split()]


@contextmanager
def dask_cluster(folder: Path, workers: int) -> Iterator[DaskCluster]:
    folder.mkdir(exist_ok=True)
    cluster = DaskCluster(folder)
    try:
        cluster.schedule()
        for number in range(workers):
            cluster.work(f"worker {number}")
        yield cluster
    finally:
        cluster.stop()


def wait_for(is_true: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_true():
        assert time.monotonic() < end, "it never became true"
        time.sleep(0.05)
