"""Fuzz a reader: damaged files, the same for the same seed, each read in a process that may end.

    python tests/fuzz/run.py --formats obj exr --minutes 5 --seed 7 --keep found
    python tests/fuzz/run.py --mutants 100000 --first 20000   # mutants 20,000 to 119,999 of each

A mutant is well answered when its reader refuses it with one sentence, or gives nothing but finite
numbers, within ten seconds of a processor and two gigabytes. Everything else is counted, and kept
where asked. USD is read by the program in a process of its own with bounds on time and memory, so
a USD mutant that ends such a process, or goes beyond its bounds, is well answered too.

A worker imports the readers once and forks the processes that read, so that a new one costs
milliseconds when a mutant has ended the one before.
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
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

SECONDS_MOST, BYTES_MOST = 10.0, 2_000_000_000
_SILENCE_S = 60.0  # of a process that reads: it hangs, also on a busy machine
_ADDRESSES_MOST = 12_000_000_000  # bytes: ends a reader before it takes the machine's memory
_ADDRESSES_OF_USD = 3_000_000_000  # as the program allows
GOOD = ("fine", "told")
GOOD_APART = (*GOOD, "crash", "hang", "slow", "memory")
_HERE = Path(__file__).resolve()
_IN_MEMORY = Path("/dev/shm")  # mutants are written there where it exists: no disk is worn


def fuzzed(
    name: str,
    seed: int,
    seconds: float | None = None,
    mutants: int | None = None,
    first: int = 0,
    keep: Path | None = None,
) -> collections.Counter[str]:
    """Return how many mutants of the format `name` came to each end.

    The numbers of the mutants begin with `first`; it ends after so many seconds or mutants.
    """
    words = ["--worker", name, "--seed", str(seed), "--first", str(first)]
    words += ["--keep", str(keep)] if keep else []
    words += ["--minutes", str(seconds / 60)] if seconds else []
    words += ["--mutants", str(mutants)] if mutants else []
    done = subprocess.run(
        [sys.executable, str(_HERE), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=True,
    )
    return collections.Counter(json.loads(done.stdout.splitlines()[-1]))


def badly_answered(name: str, counts: collections.Counter[str]) -> dict[str, int]:
    """Return how many came to an end that no mutant of the format may come to."""
    good = GOOD_APART if name.startswith("usd") else GOOD
    return {outcome: count for outcome, count in counts.items() if outcome not in good}


class Worker:
    """The readers of one format, imported, and the whole files that are damaged."""

    def __init__(self, name: str, seed: int, keep: Path | None, folder: Path) -> None:
        """Write the whole files into `folder`."""
        sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parents[2] / "app")]
        import OpenEXR
        from formats import FORMATS, without_slow_guesses

        without_slow_guesses()
        OpenEXR.set_global_thread_count(0)  # a forked process would miss them
        self._name, self._seed, self._keep = name, seed, keep
        self._form = FORMATS[name]
        self._whole = {path: path.read_bytes() for path in self._written(folder)}

    def _written(self, folder: Path) -> list[Path]:
        """Write the whole files in a process of its own: libraries that write start threads."""
        names, write = os.pipe()
        writer = os.fork()
        if writer == 0:
            with _ends_with_the_block():
                os.write(write, json.dumps([str(p) for p in self._form.write(folder)]).encode())
        os.close(write)
        with open(names, "rb") as file:
            told = file.read()
        os.waitpid(writer, 0)
        return [Path(name) for name in json.loads(told)]

    def fuzz(self, first: int, is_over: Callable[[int], bool]) -> collections.Counter[str]:
        """Read mutants from number `first` on until `is_over` says so of how many were read."""
        counts: collections.Counter[str] = collections.Counter()
        while not is_over(counts.total()):
            reader, lines = self._forked(first + counts.total())
            ends = _EndsOf(reader, lines)
            for outcome in ends:
                self._count(counts, outcome, first)
                if outcome == "memory" or is_over(counts.total()):  # memory is not given back
                    break
            else:
                self._count(counts, ends.how, first)
            ends.stop()
        return counts

    def _count(self, counts: collections.Counter[str], outcome: str, first: int) -> None:
        number = first + counts.total()
        counts[outcome] += 1
        if self._keep and outcome not in GOOD:
            self._keep.mkdir(parents=True, exist_ok=True)
            path, data = self._mutant(number)
            kept = f"{self._name}-{self._seed}-{number}-{outcome}{path.suffix}"
            (self._keep / kept).write_bytes(data)

    def _mutant(self, number: int) -> tuple[Path, bytes]:
        """Return the file that mutant `number` damages, and what it holds then."""
        from mutate import mutated

        chance = random.Random(f"{self._name} {self._seed} {number}")
        path = chance.choice(sorted(self._whole))
        data = mutated(self._whole[path], chance)
        if self._form.seal and chance.random() < 0.5:
            data = self._form.seal(data)
        return path, data

    def _forked(self, number: int) -> tuple[int, int]:
        """Start a process that reads mutants from `number` on; return its id and a pipe."""
        for path, data in self._whole.items():  # a process that ended left a damaged one
            path.write_bytes(data)
        lines, write = os.pipe()
        reader = os.fork()
        if reader:
            os.close(write)
            return reader, lines
        with _ends_with_the_block():
            self._read_for_ever(number, write)
        raise AssertionError("a forked process went on")

    def _read_for_ever(self, number: int, write: int) -> None:
        most = _ADDRESSES_OF_USD if self._name.startswith("usd") else _ADDRESSES_MOST
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for path, data in self._whole.items():  # what is loaded once is no mutant's time
            self._outcome(path, data)
        while True:
            signal.setitimer(signal.ITIMER_PROF, SECONDS_MOST)  # its signal ends the process
            os.write(write, f"{self._outcome(*self._mutant(number))}\n".encode())
            number += 1

    def _outcome(self, path: Path, data: bytes) -> str:
        """How the file at `path` is answered when it holds `data`."""
        from heatlens.errors import FaultError, HeatlensError

        path.write_bytes(data)
        try:
            outcome = "fine" if _are_finite(self._form.read(path)) else "nonfinite"
        except MemoryError:
            outcome = "memory"
        except FaultError:
            outcome = "fault"
        except HeatlensError as error:
            outcome = "told" if len(str(error).splitlines()) == 1 else "many lines"
        except Exception as error:
            outcome = f"traceback {type(error).__name__}"
        path.write_bytes(self._whole[path])
        if resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 > BYTES_MOST:
            outcome = "memory"
        return outcome


class _EndsOf:
    """What became of each mutant that a process reads, until it ends or is silent too long."""

    def __init__(self, reader: int, lines: int) -> None:
        self._reader, self._lines = reader, lines
        self._has_ended = False
        self.how = ""  # it ended: crash, slow or hang

    def __iter__(self) -> Iterator[str]:
        rest = b""
        while select.select([self._lines], [], [], _SILENCE_S)[0]:
            read = os.read(self._lines, 1 << 16)
            if not read:
                self._has_ended = True
                _, status = os.waitpid(self._reader, 0)
                is_slow = os.waitstatus_to_exitcode(status) == -signal.SIGPROF
                self.how = "slow" if is_slow else "crash"
                return
            *whole, rest = (rest + read).split(b"\n")
            yield from (line.decode() for line in whole)
        self.how = "hang"

    def stop(self) -> None:
        """End the process."""
        if not self._has_ended:
            os.kill(self._reader, signal.SIGKILL)
            os.waitpid(self._reader, 0)
        os.close(self._lines)


def _are_finite(arrays) -> bool:
    import numpy as np

    return all(np.isfinite(values).all() for values in arrays)


@contextmanager
def _ends_with_the_block() -> Iterator[None]:
    """End a forked process there, before it does what the one that forked it is to do."""
    try:
        yield
    finally:
        os._exit(0)


@contextmanager
def _folder() -> Iterator[Path]:
    place = _IN_MEMORY if os.access(_IN_MEMORY, os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="heatlens-fuzz-", dir=place) as folder:
        os.environ["HEATLENS_LOG_DIR"] = folder  # reports of faults are not the user's
        yield Path(folder)


def _work(args: argparse.Namespace) -> None:
    """Fuzz one format in this process and print the counts."""
    import warnings

    warnings.simplefilter("ignore")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # the folder goes
    with _folder() as folder:
        worker = Worker(args.worker, args.seed, args.keep, folder)
        end = time.monotonic() + 60 * args.minutes if args.minutes else None

        def is_over(count: int) -> bool:
            is_late = end is not None and count > 0 and time.monotonic() > end
            return is_late or (args.mutants is not None and count >= args.mutants)

        print(json.dumps(worker.fuzz(args.first, is_over)))


def main() -> int:
    """Fuzz what the command line names; 1 where a mutant was not well answered."""
    args = _arguments()
    if args.worker:
        _work(args)
        return 0
    sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parents[2] / "app")]
    from formats import FORMATS

    is_bad = False
    seconds = 60 * args.minutes if args.minutes else None if args.mutants else 60.0
    for name in args.formats or FORMATS:
        begin = time.monotonic()
        counts = fuzzed(name, args.seed, seconds, args.mutants, args.first, args.keep)
        rate = counts.total() / (time.monotonic() - begin)
        said = ", ".join(f"{count:,} {outcome}" for outcome, count in counts.most_common())
        print(
            f"{name}: {counts.total():,} mutants from {args.first:,} of seed {args.seed}, "
            f"{rate:.0f} a second: {said}",
            flush=True,
        )
        is_bad |= bool(badly_answered(name, counts))
    return int(is_bad)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--formats", nargs="+", default=None, help="default: all")
    parser.add_argument("--minutes", type=float, help="of each format; default 1")
    parser.add_argument("--mutants", type=int, help="of each format, in place of minutes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--keep", type=Path, help="folder for mutants that were not well answered")
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
