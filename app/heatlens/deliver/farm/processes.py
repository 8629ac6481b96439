"""Hand the frames of an export to processes on this machine, and follow them until they stop."""

import os
import queue
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from threading import Thread, current_thread, main_thread

from heatlens.core.base.errors import InputError
from heatlens.core.base.last_words import LastWords
from heatlens.deliver.export.plan import PlannedFrame
from heatlens.deliver.export.run import FrameDone
from heatlens.deliver.farm.events import Event, event_in
from heatlens.media.sequence.names import frames_text

_AS_EVENTS = ("--progress=json", "--quiet")
PATIENCE_S = 2.0  # time to stop before a process is killed
_STOPS = (signal.SIGINT, signal.SIGTERM)


class ProcessMaker:
    """Makes frames in `count` processes; `say` shows the messages about their frames."""

    def __init__(
        self,
        words: Sequence[str],
        count: int,
        say: Callable[[str], None],
        devices: Sequence[int] = (),
    ) -> None:
        """Create it; `words` are the command line of `heatlens` that makes all frames.

        The processes take the `devices` in turn.
        """
        self._devices = devices
        self._words = words
        self._count = count
        self._say = say
        self._news: queue.SimpleQueue[Event] = queue.SimpleQueue()

    def __call__(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        """Yield the frames as they are finished. Raises InputError where a process fails."""
        paths = {frame.frame: frame.path for frame in frames}
        # Each process gets frames from the whole shot, so that all end at about the same time.
        shares = [frames[at :: self._count] for at in range(min(self._count, len(frames)))]
        with ExitStack() as undone:
            for number, share in enumerate(shares):
                part = f"--part={frames_text([frame.frame for frame in share])}"
                more = (part, *device_words(self._devices, number))
                self._follow(undone, started([*self._words, *more, *_AS_EVENTS], count=len(shares)))
            running = len(shares)
            while running:
                news = self._news.get()
                if news["event"] == "frame":
                    frame, was_there = news["frame"], news["state"] != "written"
                    pace = news.get("pace", "")
                    yield FrameDone(frame, paths[frame], was_there, pace=pace)
                running -= self._has_ended(news)

    def _follow(self, undone: ExitStack, process: "subprocess.Popen[str]") -> None:
        undone.enter_context(process)
        undone.callback(stop, process)
        Thread(target=self._read, args=(process,), daemon=True).start()

    def _read(self, process: "subprocess.Popen[str]") -> None:
        """Pass on the events of a process, and its end; runs on a thread."""
        assert process.stdout is not None
        said = LastWords(process)
        for line in process.stdout:
            if (event := event_in(line)) is not None:
                self._news.put(event)
        why = said.text().rpartition("heatlens: ")[2]
        if process.wait() != 0:
            self._news.put({"event": "exit", "why": why or f"exit code {process.returncode}"})

    def _has_ended(self, news: Event) -> bool:
        """Return True if a process has succeeded. Raises InputError if it has failed."""
        if news["event"] == "end" and (sentence := _without_pace(news)):
            self._say(sentence)
        if news["event"] == "failed":
            raise InputError(news["message"])
        if news["event"] == "exit":
            raise InputError(
                f"A process ended early ({news['why']}). Finished frames are kept; export again to "
                "go on."
            )
        return bool(news["event"] == "end")


def _without_pace(news: Event) -> str:
    """Return what a process says of its frames; their pace is said once, for all processes."""
    sentence, pace = str(news.get("told", "")), news.get("pace")
    return sentence.removesuffix(f"{pace}.").strip() if pace else sentence


def device_words(devices: Sequence[int], number: int) -> tuple[str, ...]:
    """Return the option with which process `number` of several takes one of the devices."""
    return (f"--device={devices[number % len(devices)]}",) if devices else ()


def started(
    words: Sequence[str], is_shown: bool = False, count: int = 1
) -> "subprocess.Popen[str]":
    """Start the heatlens command with these words as a process, one of `count` at work.

    If `is_shown`, it prints here.
    """
    # -P: do not run a file in the current folder that has the name of a Python module.
    line = [sys.executable, "-P", "-m", "heatlens", *words]
    with _signals_heard_by_children():
        pipe = None if is_shown else subprocess.PIPE
        environment = _share_of_processors(count) | os.environ
        return subprocess.Popen(line, stdout=pipe, stderr=pipe, text=True, env=environment)


# Mesa starts a thread for each processor in every process, and each pass then waits for the slowest
# of them: 24 frames of 480x270 in two processes took 27 s, and take 18 s with a share of the
# threads.
def _share_of_processors(count: int) -> dict[str, str]:
    """Return the number of threads for Mesa's software rasteriser, which else takes all processors.

    With more threads than processors, each pass waits for the slowest of them.
    """
    threads = max(1, (os.cpu_count() or 1) // count)
    return {"LP_NUM_THREADS": str(threads)} if count > 1 else {}


@contextmanager
def _signals_heard_by_children() -> Iterator[None]:
    """Start processes that obey stop signals, even if this process ignores them.

    A child inherits ignored signals, for example from `heatlens x &` in a script; a signal with a
    handler has its usual effect in the child. Only the main thread may set handlers.
    """
    if current_thread() is not main_thread():
        yield
        return
    ignored = [number for number in _STOPS if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, lambda *_: None)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


def stop(process: "subprocess.Popen[str]", how: signal.Signals = signal.SIGTERM) -> None:
    """Ask `process` to stop; kill it after a while if it has not."""
    process.send_signal(how)  # SIGTERM works from the first moment on, unlike Ctrl-C
    Thread(target=_kill_late, args=(process,), daemon=True).start()


def _kill_late(process: "subprocess.Popen[str]") -> None:
    """Kill a process that was asked to stop and still runs; runs on a thread."""
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
