"""A virtual X screen (Xvfb) for tests of the real window, with xdotool for mouse and keys."""

import os
import shutil
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from PIL import Image, ImageGrab

from support.command_line import ENVIRONMENT, start_heatlens
from support.patience import PATIENCE_S

SCREEN = (1700, 1000)
REST_S = 0.3  # asleep and without a change of the picture
STEP_S = 0.25  # between what the hand does: the window takes it in frame by frame


class Screen:
    """A virtual X server of its own."""

    def __init__(self) -> None:
        for program in ("Xvfb", "xdotool"):
            assert shutil.which(program), f"apt-get install {program.lower()}"
        read_end, write_end = os.pipe()
        size = "x".join(map(str, SCREEN))
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{size}x24", "-noreset"],
            pass_fds=[write_end],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(write_end)
        self.started: list[subprocess.Popen[str]] = []
        with os.fdopen(read_end) as pipe:
            self.display = f":{pipe.readline().strip()}"

    def close(self) -> None:
        """Close the screen and what failed tests left open: a warning would fail another test."""
        for process in self.started:
            process.kill()
            process.communicate()
        self._server.terminate()
        self._server.wait(PATIENCE_S)

    def picture(self) -> Image.Image:
        return ImageGrab.grab(xdisplay=self.display)

    def hand(self, *words: object) -> str:
        """Run xdotool. Return what it prints."""
        command = ["xdotool", *map(str, words)]
        environment = os.environ | {"DISPLAY": self.display}
        run = subprocess.run(command, env=environment, capture_output=True, text=True)
        return run.stdout.strip()


def _cpu_seconds(process: str) -> float:
    fields = Path(f"{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _children(process: int) -> list[int]:
    return [int(it) for it in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def _is_awake(process: int) -> bool:
    """Return whether a thread of a process computes, or would if there were a processor for it."""
    with suppress(OSError):  # the process has just ended
        return any(map(_computes, list(Path(f"/proc/{process}/task").iterdir())))
    return False


def _computes(thread: Path) -> bool:
    with suppress(OSError):  # the thread has just ended
        return (thread / "stat").read_text().rpartition(")")[2].split()[0] in "RD"
    return False


def _share_known_programs(frames_folder: Path) -> None:
    """Let windows of these tests share which programs are known, so that one builds them."""
    shared = Path(os.environ["HEATLENS_CACHE_DIR"]) / "programs"
    shared.mkdir(parents=True, exist_ok=True)
    frames_folder.mkdir(parents=True, exist_ok=True)
    if not (frames_folder / "programs").exists():
        (frames_folder / "programs").symlink_to(shared)


class Window:
    """A process of `heatlens` with a window on `screen`; it is open once its name has `title`."""

    def __init__(
        self,
        screen: Screen,
        folder: Path,
        *words: object,
        title: str = " - heatlens",
        **more_environment: str,
    ) -> None:
        self.screen, self._title = screen, title
        environment = ENVIRONMENT | {
            "DISPLAY": screen.display,
            "HEATLENS_GPU": os.environ["HEATLENS_GPU"],
            "HEATLENS_CONFIG_DIR": str(folder / "config"),
            "HEATLENS_CACHE_DIR": str(folder / "cache"),
            "HEATLENS_RUNTIME_DIR": str(folder / "run"),
            **more_environment,
        }
        environment.pop("WAYLAND_DISPLAY", None)
        _share_known_programs(folder / "cache" / "frames")
        self.environment = environment
        self.process = start_heatlens(*words, env=environment)
        screen.started.append(self.process)
        self.id = ""
        self.until(self._is_shown, "a picture in the window")

    def _is_shown(self) -> bool:
        assert self.process.poll() is None, self.process.communicate()
        self.id = self.screen.hand("search", "--name", self._title).partition("\n")[0]
        return bool(self.id)

    def until(self, condition: Callable[[], bool], label: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, f"{label} never came"
            time.sleep(0.05)

    def changes(self, *words: object) -> None:
        """Run xdotool WORDS, which must change the picture of the screen."""
        before = self.screen.picture().tobytes()
        self.screen.hand(*words)
        self.until(lambda: self.screen.picture().tobytes() != before, f"an answer to {words}")

    def keys(self, *keys: str) -> None:
        # A change of focus makes ImGui forget the keys of that frame, long on a slow machine.
        if self.screen.hand("getwindowfocus") != self.id:
            self.screen.hand("windowfocus", "--sync", self.id)
            time.sleep(1.0)
        self.screen.hand("key", "--delay", 60, *keys)
        time.sleep(STEP_S)

    def move(self, x: float, y: float) -> None:
        self.screen.hand("mousemove", round(x), round(y))
        time.sleep(STEP_S)

    def click(self, x: float, y: float) -> None:
        """Click at a point of the window, wherever its frame has put it."""
        at = round(x), round(y)
        self.screen.hand("mousemove", "--window", self.id, *at, "sleep", 0.1, "click", 1)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self.move(*start)
        self.screen.hand("mousedown", 1)
        time.sleep(STEP_S)
        for i in range(1, 5):
            self.move(*(a + i / 4 * (b - a) for a, b in zip(start, end, strict=True)))
        self.screen.hand("mouseup", 1)
        time.sleep(STEP_S)

    def seen(self) -> bytes:
        """Return the pixels of the screen."""
        return self.screen.picture().tobytes()

    def rest(self) -> bytes:
        """Wait until the process sleeps and the screen no longer changes. Return the pixels.

        A thread that waits for a processor on a busy machine does not count as asleep.
        """
        last, since = self.seen(), time.monotonic()

        def is_at_rest() -> bool:
            nonlocal last, since
            if any(map(_is_awake, self.processes())):
                since = time.monotonic()
            elif time.monotonic() - since > REST_S:
                before, last, since = last, self.seen(), time.monotonic()
                return last == before
            return False

        self.until(is_at_rest, "rest")
        return last

    def activate(self) -> None:
        """Bring the window to the front under a window manager, and wait until it rests."""
        self.screen.hand("windowactivate", "--sync", self.id)
        self.until(lambda: self.screen.hand("getwindowfocus") == self.id, "the focus of keys")
        self.rest()

    def processes(self) -> list[int]:
        """Return the ids of the process and of all its descendants."""
        all_processes, newest = [self.process.pid], [self.process.pid]
        while newest:
            newest = [child for parent in newest for child in _children(parent)]
            all_processes += newest
        return all_processes

    def title(self) -> str:
        return self.screen.hand("getwindowname", self.id)

    def cpu_seconds(self) -> float:
        """Return the processor time of the process and of those that it started, all threads."""
        main_process, *children = (f"/proc/{number}" for number in self.processes())
        assert children, "the window runs in a process of its own"
        return sum(map(_cpu_seconds, (main_process, *children)))

    def quit(self) -> None:
        """Press Ctrl+Q until it works: without a window manager, focus may come a moment later."""
        end = time.monotonic() + PATIENCE_S
        while self.process.poll() is None and time.monotonic() < end:
            self.keys("ctrl+q")
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(1.0)

    def closed(self) -> tuple[int, str]:
        """Wait until the process has ended; return its exit code and output."""
        _, output = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, output
