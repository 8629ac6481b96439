"""Where an export of the window runs: this machine, a cluster, or a job that a farm runs later."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from heatlens.deliver.farm.connection import SchedulerIdentity
from heatlens.media.documents.shot_file import SHOT_SUFFIX


class Where(StrEnum):
    """Who makes the frames: this machine, the workers of a cluster, or a job on a farm."""

    HERE = "this machine"
    CLUSTER = "a cluster (Dask)"
    SLURM = "a job for Slurm"
    BUNDLE = "a job bundle (Open Job Description)"


@dataclass(frozen=True)
class ExportPlace:
    """Who makes the frames, and how.

    processes  the number of processes on this machine
    scheduler  the address of the scheduler of a cluster
    ahead      the workers of the cluster render the frames ahead of the playhead too
    at_rest    the workers render the whole picture too, once the input rests
    agreed     the only scheduler that may be used; None: the one that answers
    """

    where: Where = Where.HERE
    processes: int = 1
    scheduler: str = "tcp://127.0.0.1:8786"
    ahead: bool = True
    at_rest: bool = False
    agreed: SchedulerIdentity | None = None

    @property
    def is_job(self) -> bool:
        """True if a job is written instead of the frames."""
        return self.where in (Where.SLURM, Where.BUNDLE)

    @property
    def needs_shot_beside(self) -> bool:
        """True if other machines read the shot, which then lies beside the frames."""
        return self.where is not Where.HERE

    def words(self, output: str) -> tuple[str, ...]:
        """Return the options of `heatlens export`."""
        if self.where is Where.SLURM:
            return ("--submit", "slurm")
        if self.where is Where.BUNDLE:
            return ("--submit", "openjd", "--bundle", str(job_path(output)))
        progress = ("--progress", "json")
        if self.where is Where.CLUSTER:
            agreed_option = () if self.agreed is None else (f"--agreed={self.agreed.text}",)
            return (*progress, "--cluster", self.scheduler, *agreed_option)
        return progress if self.processes == 1 else (*progress, "--processes", str(self.processes))

    def job_name(self, output: str) -> str:
        """Return the name of the job's script or folder."""
        return job_path(output).name + (".sh" if self.where is Where.SLURM else "")


HERE = ExportPlace()


@dataclass(frozen=True)
class LeftExport:
    """An export that a cluster continues while no window follows it.

    output     the pattern of the frames, or the movie; its shot lies beside it, see `shot_of_job`
    job        the text of its file of options
    scheduler  the address of the scheduler of the cluster
    """

    output: str
    job: str
    scheduler: str


def job_path(output: str) -> Path:
    """Return the path of a job beside its frames, without an extension: /out/name.job."""
    path = Path(output).expanduser().absolute()
    return path.with_name(f"{path.name.split('.')[0]}.job")


def shot_of_job(output: str) -> Path:
    """Return the path of the shot that a job renders, which lies beside it."""
    return job_path(output).with_suffix(f".job{SHOT_SUFFIX}")
