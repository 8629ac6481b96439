"""Play at random with the real window on a virtual screen, by mouse and keys of the X server.

    python tests/fuzz/window_monkey.py --acts 3000 --seed 7

It says how much memory the window holds as it goes. It ends where the window ends by itself, where
a report of a fault is written, and where something is printed on standard error. `monkey.py` plays
faster, without a window.
"""

import argparse
import os
import random
import sys
import tempfile
import time
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support.sequences import sequence_files
from support.x_server import SCREEN, Screen, Window

_KEYS = (
    *"abcdefghijklmnoprstuvwxyz0123456789[]=-,./",
    *("space", "Return", "Escape", "Tab", "Delete", "Home", "End", "Left", "Right", "Up", "Down"),
    *("F1", "question", "Page_Up", "Page_Down", "BackSpace"),
)
_MODIFIERS = ("", "", "", "shift+", "ctrl+", "ctrl+shift+")
_LEAVES_WINDOW = ("ctrl+q", "ctrl+w")
_BATCH = 10  # acts that are sent together
_PAUSE_S = 0.03  # between two acts


def words_of_act(rng: random.Random) -> list[object]:
    """Return the words for xdotool of one random act."""
    at = rng.randrange(SCREEN[0]), rng.randrange(SCREEN[1])
    kind = rng.choices(("click", "drag", "key", "wheel", "move"), (4, 3, 6, 2, 1))[0]
    if kind == "key":
        key = rng.choice(_MODIFIERS) + rng.choice(_KEYS)
        return [] if key in _LEAVES_WINDOW else ["key", key]
    words: list[object] = ["mousemove", *at]
    if kind == "click":
        words += ["click", rng.choice((1, 1, 1, 3))]
    elif kind == "wheel":
        words += ["click", "--repeat", rng.randint(1, 5), "--delay", 5, rng.choice((4, 5))]
    elif kind == "drag":
        words += ["mousedown", 1]
        for _ in range(4):
            words += ["mousemove_relative", "--", rng.randint(-90, 90), rng.randint(-40, 40)]
            words += ["sleep", 0.01]
        words += ["mouseup", 1]
    return words


def memory_mb(window: Window) -> int:
    """Return how much memory the largest process of a window holds: the one that draws it."""
    texts = (Path(f"/proc/{it}/status").read_text() for it in window.processes())
    return max(int(text.split("VmRSS:")[1].split()[0]) for text in texts) // 1024


def play(window: Window, reports: Path, acts: int, seed: int) -> str:
    """Play; return why it ended early, or "" after all acts."""
    rng = random.Random(seed)
    for done in range(0, acts, _BATCH):
        words: list[object] = []
        for _ in range(_BATCH):
            words += [*words_of_act(rng), "sleep", _PAUSE_S]
        window.screen.hand(*words)
        if window.process.poll() is not None:
            return f"the window ended after {done + _BATCH} acts: {window.process.communicate()}"
        if faults := sorted(reports.glob("fault-*")):
            return f"a fault after {done + _BATCH} acts:\n{faults[0].read_text()}"
        if done % 200 == 0:
            print(f"{done} acts, {memory_mb(window)} MB", flush=True)
    return ""


def main() -> int:
    """Play with a window of a small sequence, and say how it ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--acts", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    screen = Screen()
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            reports = folder / "reports"
            os.environ.setdefault("HEATLENS_GPU", "opengl")  # as in the tests, see conftest.py
            os.environ.setdefault("HEATLENS_CACHE_DIR", f"{name}/programs")
            source = sequence_files(folder, 1001, 1012)
            environment = {"HEATLENS_LOG_DIR": str(reports), "HOME": name}
            window = Window(screen, folder, source, "--quality", "draft", **environment)
            problem = play(window, reports, given.acts, given.seed)
            begun = time.monotonic()
            if not problem:
                window.changes("key", "--repeat", 3, "Escape", "sleep", 1, "key", "F1")
                print(f"an answer after {time.monotonic() - begun:.1f} s")
            window.process.kill()
            _, errors = window.process.communicate()
    finally:
        screen.close()
    print(problem or errors or f"{given.acts} acts, no fault")
    return 1 if problem or errors else 0


if __name__ == "__main__":
    sys.exit(main())
