"""A Slurm of one node on this machine, for tests: munged, slurmctld and slurmd on loopback."""

import os
import secrets
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from support.patience import PATIENCE_S

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch")
BIN = Path(sys.executable).parent  # where `heatlens` of this environment is
_CONF = """\
ClusterName=here
SlurmctldHost=localhost
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0
SlurmdTimeout=5
MessageTimeout=3
BatchStartTimeout=5
KillWait=2
SlurmdParameters=config_overrides
MailProg=/bin/true
MaxArraySize=1001
NodeName=here NodeHostname={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=8000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def why_no_slurm() -> str:
    """Return why no Slurm can be started here; "" if it can."""
    missing = [name for name in PROGRAMS if _program_path(name) is None]
    if missing:
        return f"Slurm is not installed: {', '.join(missing)} missing"
    return "" if os.geteuid() == 0 else "slurmd runs jobs as root alone"


def _program_path(name: str) -> str | None:
    return shutil.which(name, path=f"{os.environ['PATH']}{os.pathsep}/usr/sbin")


def free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for port_socket in sockets:
        port_socket.bind(("127.0.0.1", 0))
    ports = [port_socket.getsockname()[1] for port_socket in sockets]
    for port_socket in sockets:
        port_socket.close()
    return ports


class Slurm:
    """The running programs; `environment` is that of the commands."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "state").mkdir()
        (folder / "spool").mkdir()
        conf = _CONF.format(folder=folder, ports=free_ports(2), host=socket.gethostname())
        (folder / "slurm.conf").write_text(conf)
        paths = (str(BIN), os.environ["PATH"], "/usr/sbin")
        variables = {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": os.pathsep.join(paths)}
        variables["SBATCH_OUTPUT"] = f"{folder}/slurm-%j.out"
        self.environment = os.environ | variables
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self) -> None:
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(1024))
        key.chmod(0o400)
        self.folder.chmod(0o755)
        files = {"key-file": key.name, "socket": "munge.socket", "pid-file": "munge.pid"}
        files |= {"log-file": "munge.log", "seed-file": "munge.seed"}
        words = [f"--{name}={self.folder / file}" for name, file in files.items()]
        self.run("munged", "--foreground", "--force", *words)
        wait_for((self.folder / "munge.socket").exists)
        self.begin()

    def begin(self) -> None:
        """Start the controller and the node with an empty queue."""
        self.run("slurmctld", "-D", "-c")
        self.run("slurmd", "-D", "-N", "here")
        wait_for(lambda: "idle" in self.said("sinfo", "-h", "-o", "%T"))

    def run(self, name: str, *words: str) -> None:
        """Start one of the programs, again if it was killed."""
        program = _program_path(name)
        assert program is not None
        with (self.folder / f"{name}.log").open("ab") as log:
            self._running[name] = subprocess.Popen(
                [program, *words], stdout=log, stderr=log, env=self.environment, cwd=self.folder
            )

    def kill(self, name: str) -> None:
        self._running[name].kill()
        self._running[name].wait()

    def stop(self) -> None:
        self.said("scancel", "--user=root")
        for process in reversed(self._running.values()):
            process.kill()
            process.wait()

    def said(self, *words: str) -> str:
        """Return what a command prints."""
        run = subprocess.run(
            words,
            capture_output=True,
            text=True,
            env=self.environment,
            check=False,
            timeout=PATIENCE_S,
        )
        return run.stdout

    def submitted(self, script: str, folder: Path) -> "subprocess.CompletedProcess[str]":
        """Run a submission script as a user would; its jobs print to files in the folder."""
        # It also holds where the folder of a job is unknown.
        environment = self.environment | {"SBATCH_OUTPUT": f"{folder}/slurm-%j.out"}
        return subprocess.run(
            ["sh"], input=script, capture_output=True, text=True, env=environment,
            cwd=folder, check=False, timeout=PATIENCE_S,
        )  # fmt: skip

    def drained(self) -> None:
        """Wait until no job is left."""
        wait_for(lambda: not self.said("squeue", "-h").strip())


def wait_for(is_true: Callable[[], object]) -> None:
    """Wait until something is true; fail after a long time."""
    end = time.monotonic() + PATIENCE_S
    while not is_true():
        assert time.monotonic() < end, "it never became true"
        time.sleep(0.1)
