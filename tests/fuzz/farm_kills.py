"""Kill parts of a render farm at random moments, start them again, and count wrong frames.

    python tests/fuzz/farm_kills.py --kills 20 --seed 1
    python tests/fuzz/farm_kills.py --kills 5 --only worker,client

A frame is missing if it is not there after one more start, half if an EXR file of its name cannot
be read whole at any time, and made twice if it was finished before the kill and is written again.
"""

import argparse
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]
from heatlens.deliver.export.finished import is_complete
from heatlens.media.documents.shot_file import write_shot
from support.command_line import start_heatlens
from support.dask_cluster import DaskCluster, dask_cluster
from support.exports import MANY_FRAMES, files_in, shot_of, write_plates
from support.slurm import Slurm, why_no_slurm

PATIENCE_S = 120.0


class Farm:
    """A shot, the files of its undisturbed export, and counts of faults after kills."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.rng = folder, random.Random(seed)
        self.shot, self.out = folder / "s.heatlens.json", folder / "out"
        write_shot(self.shot, shot_of(write_plates(folder / "plates", MANY_FRAMES), MANY_FRAMES))
        assert self.run_export("-o", folder / "whole" / "n.####.exr") == 0
        self.whole = files_in(folder / "whole")
        self.counts: Counter[str] = Counter()
        self._inodes_before: dict[Path, int] = {}

    def run_export(self, *words: object) -> int:
        process = start_heatlens("export", self.shot, *words)
        process.communicate(timeout=PATIENCE_S)
        return process.returncode

    def words(self) -> tuple[object, ...]:
        return ("-o", self.out / "n.####.exr", "--chunk", 8)

    def wait_for_random_frames(self, ended: Callable[[], bool]) -> None:
        """Wait for a random number of frames and up to 0.1 s more, or until `ended` is true."""
        count, end = self.rng.randrange(len(MANY_FRAMES) - 4), time.monotonic() + PATIENCE_S
        while len(list(self.out.glob("n.*.exr"))) < count and not ended():
            assert time.monotonic() < end, "no frames came"
            time.sleep(0.02)
        time.sleep(self.rng.uniform(0.0, 0.1))

    def count_finished_frames(self) -> None:
        """Count the finished and the truncated frames after a kill, and remember their inodes."""
        self._inodes_before = {path: path.stat().st_ino for path in self.out.glob("n.*.exr")}
        self.counts["half"] += sum(not is_complete(path) for path in self._inodes_before)
        self.counts["finished before the kill"] += len(self._inodes_before)

    def compare_frames(self) -> None:
        """Count missing, different and rewritten frames against the whole export; delete them."""
        out_files = files_in(self.out)
        self.counts["missing"] += len(self.whole.keys() - out_files.keys())
        self.counts["different"] += sum(
            out_files.get(name, data) != data for name, data in self.whole.items()
        )
        self.counts["left over"] += len([name for name in out_files if name not in self.whole])
        self.counts["twice"] += sum(
            path.exists() and path.stat().st_ino != inode
            for path, inode in self._inodes_before.items()
        )
        self.counts["kills"] += 1
        print(dict(self.counts), file=sys.stderr, flush=True)
        shutil.rmtree(self.out)


def kill_in_cluster(farm: Farm, cluster: DaskCluster, kind: str) -> None:
    """Kill the worker, the client or the scheduler, and start it once more."""
    export = cluster.export("export", farm.shot, *farm.words())
    farm.wait_for_random_frames(lambda: export.poll() is not None)
    if export.poll() is not None:
        farm.compare_frames()
        farm.counts["kills"] -= 1
        return
    cluster.kill({"client": "export"}.get(kind, kind))
    if kind == "worker":
        farm.count_finished_frames()
        cluster.work("worker")
        assert export.wait(PATIENCE_S) == 0, cluster.said("export")
    elif kind == "scheduler":
        export.wait(PATIENCE_S)
        cluster.ended("worker")
        farm.count_finished_frames()
        cluster.schedule()
        cluster.work("worker")
    if kind != "worker":
        if kind == "client":
            time.sleep(1.0)  # a task that is under way ends
            farm.count_finished_frames()
        cluster.exported(farm.shot, *farm.words())
    farm.compare_frames()


def wait_until_drained(slurm: Slurm) -> None:
    """Wait until Slurm has no task left; the limit is long, for loaded machines."""
    end = time.monotonic() + 5 * PATIENCE_S
    while slurm.said("squeue", "-h").strip():
        assert time.monotonic() < end, "the tasks never ended"
        time.sleep(0.2)


def kill_in_slurm(farm: Farm, slurm: Slurm, kind: str, script: str) -> None:
    """Kill a task or the node's daemon, and submit the job once more."""
    ids = slurm.submitted(script, farm.folder).stdout.split()
    farm.wait_for_random_frames(lambda: not slurm.said("squeue", "-h").strip())
    if kind == "task":
        task = f"{ids[0]}_{farm.rng.randrange(3)}"
        slurm.said("scancel", "--signal=KILL", "--full", task)
    else:
        slurm.kill("slurmd")
        slurm.run("slurmd", "-D", "-N", "here")
    farm.count_finished_frames()
    wait_until_drained(slurm)
    assert slurm.submitted(script, farm.folder).returncode == 0
    wait_until_drained(slurm)
    farm.compare_frames()


def kill_repeatedly(farm: Farm, kind: str, kills: int, stack: ExitStack) -> None:
    if kind in ("worker", "client", "scheduler"):
        cluster = stack.enter_context(dask_cluster(farm.folder / f"of {kind}", workers=0))
        cluster.work("worker")
        while farm.counts["kills"] < kills:
            kill_in_cluster(farm, cluster, kind)
        return
    (farm.folder / "slurm").mkdir()
    slurm = Slurm(farm.folder / "slurm")
    stack.callback(slurm.stop)
    slurm.start()
    script = farm.folder / "job.sh"
    process = start_heatlens(
        "export", farm.shot, *farm.words(), "--submit", "slurm", "--memory", 1, "--cpus", 1
    )
    script.write_text(process.communicate(timeout=PATIENCE_S)[0])
    while farm.counts["kills"] < kills:
        kill_in_slurm(farm, slurm, kind, script.read_text())


def main() -> int:
    kinds = ("worker", "client", "scheduler", "task", "slurmd")
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=",".join(kinds))
    args = parser.parse_args()
    wrong = 0
    for kind in args.only.split(","):
        if kind in ("task", "slurmd") and why_no_slurm():
            print(f"{kind}: {why_no_slurm()}")
            continue
        with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
            Path(folder).chmod(0o755)
            farm = Farm(Path(folder), args.seed)
            kill_repeatedly(farm, kind, args.kills, stack)
        names = (
            "kills",
            "finished before the kill",
            "missing",
            "half",
            "twice",
            "different",
            "left over",
        )
        print(f"{kind}:", ", ".join(f"{name} {farm.counts[name]}" for name in names), flush=True)
        wrong += sum(farm.counts[name] for name in names[2:])
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
