"""Fuzz readers with damaged files, reproducible by seed, each read in a process that may crash.

    python tests/fuzz/run.py --formats obj exr --minutes 5 --seed 7 --keep found
    python tests/fuzz/run.py --mutants 100000 --first 20000   # mutants 20,000 to 119,999 of each

A mutant is well answered when its reader refuses it with one sentence, or gives nothing but finite
numbers, within ten seconds of a processor and two gigabytes. Everything else is counted, and kept
where asked. USD and edits are read by the program in a process of its own with bounds on time and
memory, so a mutant of these that ends such a process, or goes beyond its bounds, is well answered.

A worker imports all readers once and forks the processes that read, so that a new one costs
milliseconds when a mutant has ended the one before. All limits are of time that processors worked:
on a busy machine nothing is taken for a hang that only waits for a processor. A worker that gets
SIGTERM tells what it has counted until then.
"""

import argparse
import collections
import json
import os
import random
import resource
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

SECONDS_MOST, BYTES_MOST = 10.0, 2_000_000_000
_ASLEEP_S = 60.0  # that a process which reads waits for what never comes: it hangs
_GLANCE_S = 1.0
_ADDRESSES_MOST = 12_000_000_000  # bytes: ends a reader before it takes the machine's memory
_ADDRESSES_OF_USD = 3_000_000_000  # as the program allows
Counts = collections.Counter[str]  # how many mutants came to each end
GOOD = ("fine", "told")
_APART = ("usd", "edit")  # formats that the program reads in a process of its own
GOOD_APART = (*GOOD, "crash", "hang", "slow", "memory")
_HERE = Path(__file__).resolve()
_IN_MEMORY = Path("/dev/shm")  # mutants are written there where it exists: no disk is worn


@dataclass(frozen=True)
class Job:
    """Mutants of one format, numbered from `first` on, limited by a count or by seconds.

    Those that are not well answered are written into the folder `keep`.
    """

    name: str
    seed: int
    seconds: float | None = None
    mutants: int | None = None
    first: int = 0
    keep: str | None = None


class Fuzzer:
    """A worker, to be used in a `with` block: it fuzzes one format after another."""

    def __enter__(self) -> "Fuzzer":
        """Start the worker."""
        self._worker = subprocess.Popen(
            [sys.executable, str(_HERE), "--worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        return self

    def __exit__(self, *_: object) -> None:
        """End the worker."""
        self._worker.communicate()

    def counts(self, job: Job) -> Counts:
        """Do a job in the worker. Return how many mutants had each outcome."""
        assert self._worker.stdin is not None and self._worker.stdout is not None
        self._worker.stdin.write(json.dumps(asdict(job)) + "\n")
        self._worker.stdin.flush()
        return collections.Counter(json.loads(self._worker.stdout.readline()))


def bad_outcomes(name: str, counts: Counts) -> dict[str, int]:
    """Return the counts of outcomes that no mutant of the format may have."""
    good = GOOD_APART if name.startswith(_APART) else GOOD
    return {outcome: count for outcome, count in counts.items() if outcome not in good}


class Mutants:
    """The mutants of one format and the processes that read them."""

    def __init__(self, job: Job, folder: Path) -> None:
        """Write the whole files, which are damaged then, into `folder`."""
        from formats import FORMATS

        self._name, self._seed, self._first = job.name, job.seed, job.first
        self._keep = None if job.keep is None else Path(job.keep)
        self._form = FORMATS[job.name]
        self._whole_files = {path: path.read_bytes() for path in sorted(self._write_files(folder))}
        self._paths = tuple(self._whole_files)
        self._damaged_path = self._paths[0]

    def _write_files(self, folder: Path) -> list[Path]:
        """Write the undamaged files in a forked process, as writing libraries start threads."""
        names, write = os.pipe()
        writer = os.fork()
        if writer == 0:
            with _exit_after_block():
                os.write(write, json.dumps([str(p) for p in self._form.write(folder)]).encode())
        os.close(write)
        with open(names, "rb") as file:
            paths_json = file.read()
        os.waitpid(writer, 0)
        return [Path(name) for name in json.loads(paths_json)]

    def fuzz(self, is_over: Callable[[Counts], bool]) -> Counts:
        """Read mutants until `is_over(counts)` is true. Return the counts of outcomes."""
        counts: Counts = collections.Counter()
        while not is_over(counts):
            reader, lines = self._fork_reader(self._first + counts.total())
            outcomes = _OutcomesOf(reader, lines)
            for outcome in outcomes:
                self._count(counts, outcome)
                if outcome == "memory" or is_over(counts):  # memory is not given back
                    break
            else:
                self._count(counts, outcomes.end)
            outcomes.stop()
        return counts

    def _count(self, counts: Counts, outcome: str) -> None:
        number = self._first + counts.total()
        counts[outcome] += 1
        if self._keep and outcome not in GOOD:
            self._keep.mkdir(parents=True, exist_ok=True)
            path, data = self._mutant(number)
            file_name = f"{self._name}-{self._seed}-{number}-{outcome}{path.suffix}"
            (self._keep / file_name).write_bytes(data)

    def _mutant(self, number: int) -> tuple[Path, bytes]:
        """Return the path of the file that mutant `number` damages, and its damaged bytes."""
        from mutate import mutated

        rng = random.Random(f"{self._name} {self._seed} {number}")
        path = rng.choice(self._paths)
        data = mutated(self._whole_files[path], rng)
        if self._form.seal and rng.random() < 0.5:
            data = self._form.seal(data)
        return path, data

    def _fork_reader(self, number: int) -> tuple[int, int]:
        """Start a process that reads mutants from `number` on; return its id and a pipe."""
        for path, data in self._whole_files.items():  # a process that ended left a damaged one
            path.write_bytes(data)
        lines, write = os.pipe()
        reader = os.fork()
        if reader:
            os.close(write)
            return reader, lines
        with _exit_after_block():
            self._read_for_ever(number, write)
        raise AssertionError("a forked process went on")

    def _read_for_ever(self, number: int, write: int) -> None:
        address_limit = _ADDRESSES_OF_USD if self._name.startswith("usd") else _ADDRESSES_MOST
        resource.setrlimit(resource.RLIMIT_AS, (address_limit, address_limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for path, data in self._whole_files.items():  # what is loaded once is no mutant's time
            outcome = self._outcome(path, data)
            if outcome != "fine":  # damage to it would go unseen
                os.write(write, f"{outcome} of whole {path.name}\n".encode())
        while True:
            signal.setitimer(signal.ITIMER_PROF, SECONDS_MOST)  # its signal ends the process
            os.write(write, f"{self._outcome(*self._mutant(number))}\n".encode())
            number += 1

    def _outcome(self, path: Path, data: bytes) -> str:
        """Return the outcome of reading the file at `path` with the content `data`."""
        from heatlens.core.base.errors import FaultError, HeatlensError

        self._write_mutant(path, data)
        try:
            outcome = "fine" if _all_finite(self._form.read(path)) else "nonfinite"
        except MemoryError:
            outcome = "memory"
        except FaultError:
            outcome = "fault"
        except HeatlensError as error:
            # Other control characters, which names may hold, are escaped where it is printed.
            outcome = "many lines" if "\n" in str(error) else "told"
        except Exception as error:
            outcome = f"traceback {type(error).__name__}"
        if resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 > BYTES_MOST:
            outcome = "memory"
        return outcome

    def _write_mutant(self, path: Path, data: bytes) -> None:
        """Write `data` into the file at `path`; all others are whole."""
        if self._damaged_path != path:
            self._damaged_path.write_bytes(self._whole_files[self._damaged_path])
        self._damaged_path = path
        path.write_bytes(data)


class _OutcomesOf:
    """An iterator of the outcomes of a reading process, until it ends or sleeps too long."""

    def __init__(self, reader: int, lines: int) -> None:
        self._reader, self._lines = reader, lines
        self._has_ended = False
        self.end = ""  # it ended: crash, slow or hang

    def __iter__(self) -> Iterator[str]:
        partial_line, asleep_s = b"", 0.0
        while asleep_s < _ASLEEP_S:
            if not select.select([self._lines], [], [], _GLANCE_S)[0]:
                asleep_s += _GLANCE_S if _is_asleep(self._reader) else 0.0
                continue
            asleep_s, received = 0.0, os.read(self._lines, 1 << 16)
            if not received:
                self._has_ended = True
                _, status = os.waitpid(self._reader, 0)
                is_slow = os.waitstatus_to_exitcode(status) == -signal.SIGPROF
                self.end = "slow" if is_slow else "crash"
                return
            *full_lines, partial_line = (partial_line + received).split(b"\n")
            yield from (line.decode() for line in full_lines)
        self.end = "hang"

    def stop(self) -> None:
        """End the process."""
        if not self._has_ended:
            os.kill(self._reader, signal.SIGKILL)
            os.waitpid(self._reader, 0)
        os.close(self._lines)


def _is_asleep(process: int) -> bool:
    """Return whether all threads of the process sleep, so that none runs or waits for a CPU."""
    threads = Path(f"/proc/{process}/task").glob("*/stat")
    return all(stat.read_text().rpartition(")")[2].split()[0] == "S" for stat in threads)


def _all_finite(arrays) -> bool:
    import numpy as np

    return all(np.isfinite(values).all() for values in arrays)


@contextmanager
def _exit_after_block() -> Iterator[None]:
    """Exit the forked process after the block, before it runs code of its parent."""
    try:
        yield
    finally:
        os._exit(0)


@contextmanager
def _temporary_folder() -> Iterator[Path]:
    parent_folder = _IN_MEMORY if os.access(_IN_MEMORY, os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="heatlens-fuzz-", dir=parent_folder) as folder:
        os.environ["HEATLENS_LOG_DIR"] = folder  # reports of faults are not the user's
        yield Path(folder)


def _work() -> None:
    """Do the jobs that come on stdin, one a line, and print the counts of each."""
    import warnings

    import OpenEXR
    from formats import without_own_processes, without_slow_guesses

    warnings.simplefilter("ignore")
    without_slow_guesses()
    without_own_processes()
    OpenEXR.set_global_thread_count(0)  # a forked process would miss them
    stop_requested, parent = threading.Event(), os.getppid()
    signal.signal(signal.SIGTERM, lambda *_: stop_requested.set())

    def is_stopped() -> bool:
        return stop_requested.is_set() or os.getppid() != parent

    with _temporary_folder() as folder:
        for line in sys.stdin:
            with tempfile.TemporaryDirectory(dir=folder) as job_folder:
                print(
                    json.dumps(_do_job(Job(**json.loads(line)), Path(job_folder), is_stopped)),
                    flush=True,
                )


def _do_job(job: Job, folder: Path, is_stopped: Callable[[], bool]) -> Counts:
    """Do one job in this process."""
    mutants = Mutants(job, folder)
    end = time.monotonic() + job.seconds if job.seconds else None

    def is_over(counts: Counts) -> bool:
        is_late = end is not None and counts.total() > 0 and time.monotonic() > end
        is_whole = job.mutants is not None and counts.total() >= job.mutants
        return is_late or is_whole or is_stopped()

    return mutants.fuzz(is_over)


def main() -> int:
    """Fuzz what the command line names; return 1 if a mutant was not well answered."""
    args = _arguments()
    sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parents[2] / "app")]
    if args.worker:
        _work()
        return 0
    from formats import FORMATS

    is_bad = False
    seconds = 60 * args.minutes if args.minutes else None if args.mutants else 60.0
    keep = None if args.keep is None else str(args.keep.absolute())
    with Fuzzer() as fuzzer:
        for name in args.formats or FORMATS:
            job = Job(name, args.seed, seconds, args.mutants, args.first, keep)
            is_bad |= _print_job(fuzzer, job)
    return int(is_bad)


def _print_job(fuzzer: Fuzzer, job: Job) -> bool:
    """Do one job and print its counts. Return whether a mutant was not well answered."""
    begin = time.monotonic()
    counts = fuzzer.counts(job)
    rate = counts.total() / (time.monotonic() - begin)
    outcome_counts = ", ".join(f"{count:,} {outcome}" for outcome, count in counts.most_common())
    print(
        f"{job.name}: {counts.total():,} mutants from {job.first:,} of seed {job.seed}, "
        f"{rate:.0f} a second: {outcome_counts}",
        flush=True,
    )
    return bool(bad_outcomes(job.name, counts))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--formats", nargs="+", default=None, help="default: all")
    parser.add_argument("--minutes", type=float, help="of each format; default 1")
    parser.add_argument("--mutants", type=int, help="of each format, in place of minutes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--keep", type=Path, help="folder for mutants that were not well answered")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
