"""Kill exports at random moments and resume them: the files must be those of a whole export.

    python tests/fuzz/kills.py --kills 1000 --seed 3       # 200 of each kind of file
    python tests/fuzz/kills.py --kills 50 --only exr,mov

Half of the signals are SIGKILL, the rest SIGTERM and SIGINT; one goes to the process that was
started, to the one that works for it, or to both. Half of them come at any moment from the start
on, the others shortly after a frame was told. Only signals that ended an export are counted.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]
from fuzz.interrupts import ended_before_heatlens
from heatlens.media.documents.shot_file import write_shot
from support.command_line import start_heatlens
from support.exports import files_in, shot_of, write_plates

FRAMES = tuple(range(1001, 1013))
VIEW_OPTIONS = ("--view", "sRGB curve")
# What is written, and the options that this needs.
KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "exr": ("n.####.exr", ()),
    "png": ("n.####.png", VIEW_OPTIONS),
    "jpg": ("n.####.jpg", VIEW_OPTIONS),
    "mp4": ("n.mp4", VIEW_OPTIONS),
    "mov": ("n.mov", VIEW_OPTIONS),
}
_KILLS_AT_ONE = 4  # of one export, before it may go on to its end
_PATIENCE_S = 120.0


@dataclass
class Exports:
    """A shot, and the files of its undisturbed export for each kind of file."""

    folder: Path
    shot: Path = field(init=False)
    whole: dict[str, dict[str, bytes]] = field(default_factory=dict)
    took_s: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.shot = self.folder / "s.heatlens.json"
        write_shot(self.shot, shot_of(write_plates(self.folder / "plates", FRAMES), FRAMES))

    def prepare(self, kind: str) -> None:
        """Export once without being stopped."""
        out = self.folder / f"whole-{kind}"
        out.mkdir()
        begin = time.monotonic()
        assert self.run_export(kind, out) == 0, kind
        self.took_s[kind] = time.monotonic() - begin
        self.whole[kind] = files_in(out)

    def start(self, kind: str, out: Path) -> subprocess.Popen[str]:
        """Start or resume an export into the folder `out`, in a process group of its own."""
        name, words = KINDS[kind]
        command = ("export", self.shot, "-o", out / name, "--progress", "json", *words)
        return start_heatlens(*command, start_new_session=True)

    def run_export(self, kind: str, out: Path) -> int:
        """Export to the end; returns the exit code."""
        process = self.start(kind, out)
        process.communicate(timeout=10 * _PATIENCE_S)
        return process.returncode

    def killed_and_resumed(self, kind: str, kills: int, rng: random.Random) -> "Outcome":
        """Kill an export `kills` times, then let it end; check its files after each run."""
        out = Path(tempfile.mkdtemp(prefix=f"{kind}-", dir=self.folder))
        outcome = Outcome()
        for _ in range(kills):
            self._kill_once(kind, out, rng, outcome)
            outcome.faults += [f"{n} differs" for n in self._wrong_files(kind, out)]
        code = self.run_export(kind, out)
        if code != 0:
            outcome.faults.append(f"the export that went on ended with {code}")
        if files_in(out) != self.whole[kind]:
            outcome.faults.append(f"in the end there are {sorted(files_in(out))}, or they differ")
        if not outcome.faults:
            shutil.rmtree(out)
        return outcome

    def _kill_once(self, kind: str, out: Path, rng: random.Random, outcome: "Outcome") -> None:
        process = self.start(kind, out)
        stop_signal = rng.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT))
        self._wait(process, kind, rng)
        target = rng.choice(("process", "worker", "group"))
        _send(process, stop_signal, target)
        _, errors = process.communicate(timeout=_PATIENCE_S)
        _until_gone(process.pid)
        code = process.returncode
        outcome.codes[f"{stop_signal.name} {code}"] += 1
        outcome.kills += code != 0
        is_expected = code in (0, -stop_signal, 128 + stop_signal) and "Traceback" not in errors
        if not is_expected and not ended_before_heatlens(code, errors):
            outcome.faults.append(f"{stop_signal.name} to the {target} ended with {code}: {errors}")

    def _wait(self, process: subprocess.Popen[str], kind: str, rng: random.Random) -> None:
        if rng.random() < 0.5:
            time.sleep(rng.uniform(0.0, self.took_s[kind]))
            return
        assert process.stdout is not None
        for _ in range(rng.randint(1, 4)):
            process.stdout.readline()
        time.sleep(rng.choice((0.0, rng.uniform(0.0, 0.05), rng.uniform(0.0, 0.4))))

    def _wrong_files(self, kind: str, out: Path) -> list[str]:
        """Return names of files that are neither a frame of the whole export nor a part of one."""
        whole = self.whole[kind]
        return [
            name
            for name, data in files_in(out).items()
            if not name.endswith(".part") and data != whole.get(name)
        ]


@dataclass
class Outcome:
    """The results of one export that was killed several times."""

    kills: int = 0
    codes: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


def _send(process: subprocess.Popen[str], stop_signal: signal.Signals, target: str) -> None:
    """Send a signal to the started process, to its worker, or to both."""
    if process.poll() is not None:
        return
    if target == "group":
        os.killpg(process.pid, stop_signal)
    elif target == "process":
        process.send_signal(stop_signal)
    else:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        # The one that works ignores what asks it to end: that is answered by the other one.
        for worker in children if stop_signal == signal.SIGKILL else [process.pid]:
            try:
                os.kill(int(worker), stop_signal)
            except ProcessLookupError:
                continue  # it has ended meanwhile


def _until_gone(group: int) -> None:
    """Wait until no process of the group is left: the kernel ends a worker a moment later."""
    end = time.monotonic() + _PATIENCE_S
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.01)
    raise TimeoutError(f"process group {group} is still there")


def kill_many_times(exports: Exports, kinds: list[str], kills: int, seed: int) -> Iterator[str]:
    """Kill exports of all kinds by turns, at least `kills` times; yield faults, then counts."""
    rng = random.Random(seed)
    counts: Counter[str] = Counter()
    codes: Counter[str] = Counter()
    exports_done: Counter[str] = Counter()
    while min(counts[kind] for kind in kinds) * len(kinds) < kills:
        for kind in kinds:
            outcome = exports.killed_and_resumed(kind, _KILLS_AT_ONE, rng)
            counts[kind] += outcome.kills
            exports_done[kind] += 1
            codes.update(outcome.codes)
            yield from (f"  {kind}: {fault}" for fault in outcome.faults)
        if exports_done[kinds[0]] % 10 == 0:
            yield f"{counts.total()} kills so far"
    for kind in kinds:
        yield f"{kind}: {counts[kind]} kills of {exports_done[kind]} exports that then went on"
    yield f"{counts.total()} kills, seed {seed}: {dict(sorted(codes.items()))}"


def main() -> int:
    """Kill exports as the command line says; return 1 if a file is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kills", type=int, default=50, help="of all kinds together")
    parser.add_argument("--only", default=",".join(KINDS), help="kinds of files")
    parser.add_argument("--seed", type=int, default=20060106)
    args = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # also where a shell ignores it
    kinds, is_bad = args.only.split(","), False
    with tempfile.TemporaryDirectory(prefix="heatlens-fuzz-kills-") as folder:
        exports = Exports(Path(folder))
        for kind in kinds:
            exports.prepare(kind)
        for line in kill_many_times(exports, kinds, args.kills, args.seed):
            is_bad |= line.startswith("  ")
            print(line, flush=True)
    return int(is_bad)


if __name__ == "__main__":
    sys.exit(main())
