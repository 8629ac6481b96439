"""Fuzz a reader: damaged files, the same for the same seed, each read in a process that may end.

    python tests/fuzz/run.py --formats obj exr --minutes 5 --seed 7 --keep found

A mutant is well answered when its reader refuses it with one sentence, or gives nothing but finite
numbers, within ten seconds of a processor and two gigabytes. Everything else is counted, and kept
where asked. Of USD, which the program reads in a process of its own with bounds, also a mutant is
well answered that ends such a process or goes beyond its bounds: that is what it is there for.
"""

import argparse
import collections
import random
import resource
import select
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SECONDS_MOST, BYTES_MOST = 10.0, 2_000_000_000
_SILENCE_S = 60.0  # of a process that reads: it hangs, also on a busy machine
GOOD = ("fine", "told")
GOOD_APART = (*GOOD, "crash", "hang", "slow", "memory")
_HERE = Path(__file__).resolve()


def fuzzed(name: str, seed: int, seconds: float, keep: Path | None = None) -> collections.Counter:
    """Return how many mutants of the format `name` came to each end in so many seconds."""
    counts: collections.Counter[str] = collections.Counter()
    number, left_s = 0, seconds
    while left_s > 0:
        number, left_s = _one_process(name, seed, number, left_s, counts, keep)
    return counts


def badly_answered(name: str, counts: collections.Counter) -> dict[str, int]:
    """Return how many came to an end that no mutant of the format may come to."""
    good = GOOD_APART if name.startswith("usd") else GOOD
    return {outcome: count for outcome, count in counts.items() if outcome not in good}


def _one_process(
    name: str, seed: int, number: int, left_s: float, counts: collections.Counter, keep: Path | None
) -> tuple[int, float]:
    """Read mutants from `number` on, for `left_s` once the process is there, or until it ends.

    Returns the next number, and the time that is left.
    """
    words = ["--worker", name, "--seed", str(seed), "--first", str(number)]
    words += ["--keep", str(keep)] if keep else []
    command = [sys.executable, str(_HERE), *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as worker:
        assert worker.stdout is not None
        patience_s = 120.0  # to be there at all, on a busy machine
        end = time.monotonic() + left_s
        while select.select([worker.stdout], [], [], patience_s)[0]:
            line = worker.stdout.readline().decode().strip()
            if not line:
                counts["crash"] += 1
                return number + 1, end - time.monotonic()
            patience_s = _SILENCE_S
            if line == "ready":
                end = time.monotonic() + left_s
                continue
            counts[line] += 1
            number += 1
            if line == "memory":  # what was set aside once is not given back
                break
            if time.monotonic() > end:
                break
        else:
            counts["hang"] += 1
            number += 1
        worker.kill()
        return number, end - time.monotonic()


def _work(name: str, seed: int, number: int, keep: Path | None) -> None:
    """Read mutants for ever; a line for each."""
    sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parents[2] / "app")]
    from formats import FORMATS

    form = FORMATS[name]
    with tempfile.TemporaryDirectory(prefix="heatlens-fuzz-") as text:
        folder = Path(text)
        whole = {path: path.read_bytes() for path in form.write(folder)}
        for path in whole:  # what is loaded once is not the time of a mutant
            _outcome(form, {path: path.read_bytes()}, None)
        print("ready", flush=True)
        while True:
            outcome, data = _outcome(form, whole, random.Random(f"{name} {seed} {number}"))
            if keep and outcome not in GOOD:
                keep.mkdir(parents=True, exist_ok=True)
                (keep / f"{name}-{seed}-{number}-{outcome}").write_bytes(data)
            print(outcome, flush=True)
            number += 1


def _outcome(form, whole: dict[Path, bytes], chance: random.Random | None) -> tuple[str, bytes]:
    """How a mutant was answered, and the mutant; without `chance` nothing is damaged."""
    import warnings

    from mutate import mutated

    from heatlens.errors import HeatlensError

    path = chance.choice(sorted(whole)) if chance else next(iter(whole))
    data = mutated(whole[path], chance) if chance else whole[path]
    path.write_bytes(data)
    begin = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            outcome = "fine" if _are_finite(form.read(path)) else "nonfinite"
    except HeatlensError as error:
        outcome = "told" if len(str(error).splitlines()) == 1 else "many lines"
    except Exception as error:
        outcome = f"traceback {type(error).__name__}"
    path.write_bytes(whole[path])
    if time.process_time() - begin > SECONDS_MOST:
        outcome = "slow"
    if resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 > BYTES_MOST:
        outcome = "memory"
    return outcome, data


def _are_finite(arrays) -> bool:
    import numpy as np

    return all(np.isfinite(values).all() for values in arrays)


def main() -> int:
    """Fuzz what the command line names; 1 where a mutant was not well answered."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--formats", nargs="+", default=None, help="default: all")
    parser.add_argument("--minutes", type=float, default=1.0, help="of each format")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for mutants that were not well answered")
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    parser.add_argument("--first", type=int, default=0, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.worker:
        _work(args.worker, args.seed, args.first, args.keep)
    sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parents[2] / "app")]
    from formats import FORMATS

    is_bad = False
    for name in args.formats or FORMATS:
        counts = fuzzed(name, args.seed, 60 * args.minutes, args.keep)
        said = ", ".join(f"{count:,} {outcome}" for outcome, count in counts.most_common())
        print(f"{name}: {sum(counts.values()):,} mutants: {said}", flush=True)
        is_bad |= bool(badly_answered(name, counts))
    return int(is_bad)


if __name__ == "__main__":
    sys.exit(main())
