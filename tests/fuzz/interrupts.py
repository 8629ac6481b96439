"""Stop signals at random moments of every command: what must be true afterwards, and a long run.

    python tests/fuzz/interrupts.py --times 200            # of every command
    python tests/fuzz/interrupts.py --times 50 --only render,study --signal TERM

Half of the signals go to the process alone, half to its whole group, as terminals send them.
"""

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

import heatlens
from heatlens.paths import data_dir

STILL = data_dir("assets") / "still_life.exr"
ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(heatlens.__file__).parents[1])}
PATIENCE_S = 30.0  # for a process that should have ended long ago
SMALL = ("--size", "64x36")
# What each command is called with. {out} is an empty folder, {shot} a shot file, {ref} an EXR.
COMMANDS: dict[str, tuple[str, ...]] = {
    "render": ("render", str(STILL), "-o", "{out}/o.exr", "--focus-at", "290,190"),
    "render-png": ("render", str(STILL), "-o", "{out}/o.png", "--focus-at", "290,190"),
    "accumulation": (
        *("render", "demo", "-o", "{out}/o.exr", "--method", "accumulation", "--views", "16"),
        *SMALL,
    ),
    "export": ("export", "demo", "-o", "{out}/new/n.####.exr", "--frames", "1-6", *SMALL),
    "export-movie": ("export", "demo", "-o", "{out}/n.mov", "--frames", "1-6", *SMALL),
    "shot-new": ("shot", "new", str(STILL), "-o", "{out}/s.heatlens.json", "--focus-distance", "2"),
    "shot-show": ("shot", "show", "{shot}"),
    "camera": ("camera", "{shot}", "-o", "{out}/cam.usda", "--frames", "1-3"),
    "info": ("info", str(STILL)),
    "info-scene": ("info", "demo"),
    "compare": ("compare", "{ref}", str(STILL)),
    "study": (
        *("study", str(STILL), "-o", "{out}/report", "--focus-at", "290,190", "--runs", "1"),
        *("--methods", "gather,heat"),
    ),
    "doctor": ("doctor",),
    "bench": ("bench", "--size", "320x180", "--runs", "1"),
}
_UNTRUE = re.compile("Traceback|Exception ignored|cannot be loaded|Install|initialization|a fault")
_OF_PYTHON = re.compile(r'File "(?!<frozen)[^"]*heatlens')


@dataclass
class Outcome:
    """One process that was sent a signal."""

    code: int
    seconds: float  # from the signal to its end
    said: str
    left: list[str]  # files that should not be there
    alive: bool  # something of its process group still ran
    before_python: bool  # the signal came before the first line of heatlens

    def faults(self, number: int, limit_s: float) -> list[str]:
        """What is wrong with it, in words."""
        if self.before_python:
            return []
        found = []
        if self.code not in (0, 128 + number):
            found.append(f"exit code {self.code}")
        if _UNTRUE.search(self.said):
            found.append("said what is not true")
        if self.left:
            found.append(f"left {self.left}")
        if self.alive:
            found.append("left a process")
        if self.seconds > limit_s:
            found.append(f"took {self.seconds:.2f} s")
        return found


@dataclass
class Bench:
    """Files that the commands need, and a folder to write in."""

    folder: Path
    shot: Path = field(init=False)
    reference: Path = field(init=False)

    def __post_init__(self) -> None:
        self.shot = self.folder / "shot.heatlens.json"
        self.reference = self.folder / "reference.exr"
        run = (sys.executable, "-m", "heatlens")
        focus = ("--focus-distance", "2")
        for words in (
            ("shot", "new", str(STILL), "-o", str(self.shot), *focus),
            ("render", str(STILL), "-o", str(self.reference), *focus, "--quality", "draft"),
        ):
            subprocess.run([*run, *words], env=ENVIRONMENT, check=True, capture_output=True)

    def words(self, name: str, out: Path) -> list[str]:
        """The command line of command `name`."""
        given = {"out": str(out), "shot": str(self.shot), "ref": str(self.reference)}
        return [word.format(**given) for word in COMMANDS[name]]

    def start(self, name: str, out: Path) -> subprocess.Popen[str]:
        """Start command `name`, which writes into `out`."""
        temporary = out.with_name("tmp")
        temporary.mkdir(exist_ok=True)
        return subprocess.Popen(
            [sys.executable, "-m", "heatlens", *self.words(name, out)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT | {"TMPDIR": str(temporary)},
            start_new_session=True,
        )

    def duration_s(self, name: str) -> float:
        """How long command `name` takes when nobody stops it."""
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            out = Path(folder) / "out"
            out.mkdir()
            start = time.monotonic()
            process = self.start(name, out)
            said = process.communicate()
            assert process.returncode == 0, (name, said)
            return time.monotonic() - start

    def interrupted(
        self, name: str, wait_s: float, number: signal.Signals, to_group: bool
    ) -> Outcome:
        """Start command `name`, send the signal after `wait_s`, and look at what there is then."""
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            out = Path(folder) / "out"
            out.mkdir()
            process = self.start(name, out)
            time.sleep(wait_s)
            begin = time.monotonic()
            if process.poll() is None:
                (os.killpg if to_group else os.kill)(process.pid, number)
            try:
                said = "".join(process.communicate(timeout=PATIENCE_S))
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                said = "".join(process.communicate()) + "(had to be killed)"
            seconds = time.monotonic() - begin
            code = process.returncode
            early = (code < 0 or "Traceback" in said) and not _OF_PYTHON.search(said)
            left = sorted(
                str(path.relative_to(folder))
                for path in Path(folder).rglob("*")
                if path.name not in ("out", "tmp") and not _is_whole(path, out, code)
            )
            return Outcome(code, seconds, said, left, _group_lives(process.pid), early)


def _is_whole(path: Path, out: Path, code: int) -> bool:
    """Whether `path` is a result that may be there: never half a file, never an empty folder."""
    if path.is_dir():
        return any(path.iterdir())
    inside = path.relative_to(out).as_posix() if path.is_relative_to(out) else ""
    # A report has many files, and its folder appears whole.
    names = r"o\.(exr|png)|new/n\.\d{4}\.exr|n\.mov|s\.heatlens\.json|cam\.usda|report/[^.]\S*"
    return bool(re.fullmatch(names, inside)) and path.stat().st_size > 0


def _group_lives(group: int) -> bool:
    """Whether a process of the group still runs a moment after its leader has ended."""
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        if not any(_runs_in(group, stat) for stat in Path("/proc").glob("[0-9]*/stat")):
            return False
        time.sleep(0.01)
    return True


def _runs_in(group: int, stat: Path) -> bool:
    """Zombies do not count: they are only names that the system has not yet taken off its list."""
    try:
        state, _parent, found = stat.read_text().rpartition(")")[2].split()[:3]
    except OSError:
        return False
    return int(found) == group and state not in "ZX"


def main() -> int:
    """A long run; prints a line for each command and every fault."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--only", default=",".join(COMMANDS))
    parser.add_argument("--signal", choices=("INT", "TERM"), default="INT")
    parser.add_argument("--seed", type=int, default=20060106)
    parser.add_argument("--limit", type=float, default=1.0, help="seconds that are allowed")
    args = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rng, number = random.Random(args.seed), signal.Signals[f"SIG{args.signal}"]
    faulty = 0
    with tempfile.TemporaryDirectory(prefix="interrupts-") as folder:
        bench = Bench(Path(folder))
        for name in args.only.split(","):
            faulty += _many(bench, name, args.times, rng, number, args.limit)
    return int(faulty > 0)


def _many(
    bench: Bench, name: str, times: int, rng: random.Random, number: signal.Signals, limit: float
) -> int:
    bench.duration_s(name)  # the first reads all files from the disk
    whole_s = bench.duration_s(name)
    codes: Counter[str] = Counter()
    waits_s: list[float] = []
    faulty = 0
    for _ in range(times):
        wait_s = rng.uniform(0.0, whole_s)
        outcome = bench.interrupted(name, wait_s, number, rng.random() < 0.5)
        codes["before heatlens" if outcome.before_python else str(outcome.code)] += 1
        waits_s.append(outcome.seconds)
        faults = outcome.faults(number, limit)
        if faults:
            faulty += 1
            print(f"  {name} at {wait_s:.3f} s: {'; '.join(faults)}\n{outcome.said}", flush=True)
    told = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
    print(
        f"{name:14} {whole_s:5.1f} s, {times} signals, {told}; median {median(waits_s):.2f} s, "
        f"slowest {max(waits_s):.2f} s, {faulty} faults; load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    return faulty


if __name__ == "__main__":
    sys.exit(main())
