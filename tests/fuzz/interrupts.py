"""Send stop signals at random moments of every command, and check how the commands end.

    python tests/fuzz/interrupts.py --times 200            # of every command, SIGINT and SIGTERM
    python tests/fuzz/interrupts.py --times 50 --only render,study --signals TERM
    python tests/fuzz/interrupts.py --times 20 --only render-8k   # only where it is named

Half of the signals go to the process alone, half to its whole group, as terminals send them.
On a busy machine an answer may take longer by the number of processes that wait for a processor;
the time that processors worked between the signal and the end is told beside it.
"""

import argparse
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

import numpy as np

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]
import heatlens
from heatlens.core.base.paths import data_dir
from heatlens.media.plate.header.camera_header import lens_attributes
from support.exr_files import write_file
from support.plates import room
from support.x_server import Screen

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
    "view": ("view", str(STILL)),
    "render-8k": ("render", "{large}", "-o", "{out}/o.exr", "--quality", "film"),
}
# Those that are not waited for to know how long they take; their signals come within so many s.
ENDLESS_S = {"view": 5.0, "render-8k": 60.0}
_UNTRUE = re.compile("Traceback|Exception ignored|cannot be loaded|Install|initialization|a fault")
# A traceback with a line of heatlens: one without it is Python's, which had not yet begun with it.
_OF_HEATLENS = re.compile(r'File "(?!<frozen)[^"]*heatlens')


@dataclass
class Outcome:
    """The outcome of one process that was sent a signal."""

    code: int
    seconds: float  # from the signal to its end
    busy_s: float  # that processors worked for it from then on
    output: str
    leftover_files: list[str]  # files that should not be there
    alive: bool  # something of its process group still ran
    before_python: bool  # the signal came before the first line of heatlens

    def faults(self, number: int, limit_s: float) -> list[str]:
        """Return descriptions of all that is wrong with the outcome."""
        if self.before_python:
            return []
        fault_texts = []
        if self.code not in (0, 128 + number):
            fault_texts.append(f"exit code {self.code}")
        if _UNTRUE.search(self.output):
            fault_texts.append("said what is not true")
        if self.leftover_files:
            fault_texts.append(f"left {self.leftover_files}")
        if self.alive:
            fault_texts.append("left a process")
        if self.seconds > limit_s:
            fault_texts.append(f"took {self.seconds:.2f} s, {self.busy_s:.2f} s of processor time")
        return fault_texts


@dataclass
class Bench:
    """The input files of the commands, and a folder for their outputs."""

    folder: Path
    shot: Path = field(init=False)
    reference: Path = field(init=False)
    display: str = ""  # the X server for windows

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
        """Return the command line of command `name`."""
        large = self.folder / "large.exr"
        if "{large}" in COMMANDS[name] and not large.exists():
            write_large(large)
        values = {"out": out, "shot": self.shot, "ref": self.reference, "large": large}
        return [word.format(**values) for word in COMMANDS[name]]

    def start(self, name: str, out: Path) -> subprocess.Popen[str]:
        """Start command `name`, which writes into `out`."""
        temporary = out.with_name("tmp")
        temporary.mkdir(exist_ok=True)
        return subprocess.Popen(
            [sys.executable, "-m", "heatlens", *self.words(name, out)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT | self._environment(temporary),
            start_new_session=True,
        )

    def _environment(self, temporary: Path) -> dict[str, str]:
        """Return the environment without the user's preferences and windows."""
        folders = {"HEATLENS_CONFIG_DIR": "config", "HEATLENS_CACHE_DIR": "cache"}
        folder_variables = {name: str(self.folder / folder) for name, folder in folders.items()}
        return folder_variables | {
            "TMPDIR": str(temporary),
            "DISPLAY": self.display,
            "WAYLAND_DISPLAY": "",
        }

    def duration_s(self, name: str) -> float:
        """Return how long command `name` takes when nobody stops it."""
        if name in ENDLESS_S:
            return ENDLESS_S[name]
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            out = Path(folder) / "out"
            out.mkdir()
            start = time.monotonic()
            process = self.start(name, out)
            outputs = process.communicate()
            assert process.returncode == 0, (name, outputs)
            return time.monotonic() - start

    def interrupted(
        self, name: str, wait_s: float, number: signal.Signals, to_group: bool
    ) -> Outcome:
        """Start command `name`, send the signal after `wait_s` seconds, and return the outcome."""
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            out = Path(folder) / "out"
            out.mkdir()
            before_s = _children_s()
            process = self.start(name, out)
            time.sleep(wait_s)
            busy_s = _worked_s(process.pid)
            begin = time.monotonic()
            if process.poll() is None:
                (os.killpg if to_group else os.kill)(process.pid, number)
            try:
                output = "".join(process.communicate(timeout=PATIENCE_S))
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                output = "".join(process.communicate()) + "(had to be killed)"
            seconds, busy_s = time.monotonic() - begin, _children_s() - before_s - busy_s
            code = process.returncode
            is_early = ended_before_heatlens(code, output)
            leftover_files = sorted(
                str(path.relative_to(folder))
                for path in Path(folder).rglob("*")
                if path.name not in ("out", "tmp") and not _is_whole(path, out, code)
            )
            alive = _group_lives(process.pid)
            return Outcome(code, seconds, max(busy_s, 0.0), output, leftover_files, alive, is_early)


def ended_before_heatlens(code: int, output: str) -> bool:
    """Return whether a process ended by a signal before the first line of heatlens ran."""
    return (code < 0 or "Traceback" in output) and not _OF_HEATLENS.search(output)


def write_large(path: Path) -> None:
    """Write the room of the tests, 7680 x 4320, with a lens that blurs much of it far."""
    color, depth = (np.repeat(np.repeat(v, 240, axis=0), 240, axis=1) for v in room(32, 18))
    channels = {n: np.ascontiguousarray(color[..., i], np.float16) for i, n in enumerate("RGB")}
    header = lens_attributes(50.0, 1.4, 1.0, 36.0, 20.25)
    write_file(path, channels | {"Z": np.ascontiguousarray(depth)}, **header)


def _children_s() -> float:
    """Return the CPU seconds of all child processes that have ended and were waited for."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _worked_s(process: int) -> float:
    """Return the CPU seconds of `process` and all its descendants until now."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    except OSError:  # it has ended
        return 0.0
    own_s = sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    return own_s + sum(_worked_s(int(child)) for child in children)


def _is_whole(path: Path, out: Path, code: int) -> bool:
    """Return whether `path` may be there: never half a file, never an empty folder."""
    if path.is_dir():
        return any(path.iterdir())
    inside = path.relative_to(out).as_posix() if path.is_relative_to(out) else ""
    # A report has many files, and its folder appears whole.
    names = r"o\.(exr|png)|new/n\.\d{4}\.exr|n\.mov|s\.heatlens\.json|cam\.usda|report/[^.]\S*"
    return bool(re.fullmatch(names, inside)) and path.stat().st_size > 0


def _group_lives(group: int) -> bool:
    """Return whether a process of the group still runs a moment after its leader has ended."""
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        if not any(_runs_in(group, stat) for stat in Path("/proc").glob("[0-9]*/stat")):
            return False
        time.sleep(0.01)
    return True


def _runs_in(group: int, stat: Path) -> bool:
    """Return whether a process runs; zombies have ended and wait for their parent."""
    try:
        state, _parent, group_field = stat.read_text().rpartition(")")[2].split()[:3]
    except OSError:
        return False
    return int(group_field) == group and state not in "ZX"


def main() -> int:
    """Interrupt the chosen commands many times; print a line for each command and fault."""
    args = _arguments()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rng, faulty = random.Random(args.seed), 0
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="interrupts-"))
        bench = Bench(Path(folder))
        if "view" in args.only.split(","):
            screen = Screen()
            stack.callback(screen.close)
            bench.display = screen.display
        for name in args.only.split(","):
            numbers = [signal.Signals[f"SIG{word}"] for word in args.signals.split(",")]
            faulty += _interrupt_repeatedly(bench, name, args.times, rng, numbers, args.limit)
    return int(faulty > 0)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--times", type=int, default=20, help="signals of each command")
    parser.add_argument("--only", default=",".join(n for n in COMMANDS if n != "render-8k"))
    parser.add_argument("--signals", default="INT,TERM", help="in turns")
    parser.add_argument("--seed", type=int, default=20060106)
    parser.add_argument("--limit", type=float, default=1.0, help="seconds on a machine at rest")
    return parser.parse_args()


def _interrupt_repeatedly(
    bench: Bench,
    name: str,
    times: int,
    rng: random.Random,
    numbers: list[signal.Signals],
    limit_s: float,
) -> int:
    """Interrupt command `name` `times` times. Return the number of faulty outcomes."""
    bench.duration_s(name)  # the first reads all files from the disk
    whole_s = bench.duration_s(name)
    codes: Counter[str] = Counter()
    outcomes: list[Outcome] = []
    faulty = 0
    for turn in range(times):
        wait_s, number = rng.uniform(0.0, whole_s), numbers[turn % len(numbers)]
        outcome = bench.interrupted(name, wait_s, number, rng.random() < 0.5)
        outcomes.append(outcome)
        codes["before heatlens" if outcome.before_python else str(outcome.code)] += 1
        load = os.getloadavg()[0] / (os.cpu_count() or 1)
        faults = outcome.faults(number, limit_s * max(1.0, load))
        if faults:
            faulty += 1
            summary = f"{name}, {number.name} at {wait_s:.3f} s: {'; '.join(faults)}"
            print(f"  {summary}\n{outcome.output}", flush=True)
    summary = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
    print(
        f"{name:14} {whole_s:5.1f} s, {times} signals, {summary}; "
        f"{_spread('answer', [o.seconds for o in outcomes])}; "
        f"{_spread('of processor time', [o.busy_s for o in outcomes])}; "
        f"{faulty} faults; load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    return faulty


def _spread(label: str, seconds: Iterable[float]) -> str:
    ordered = sorted(seconds)
    return f"{label} median {median(ordered):.2f} s, slowest {ordered[-1]:.2f} s"


if __name__ == "__main__":
    sys.exit(main())
