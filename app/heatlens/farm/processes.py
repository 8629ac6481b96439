"""Hand the frames of an export to processes on this machine, and follow them."""

import json
import queue
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from threading import Thread
from typing import Any

from heatlens.base.errors import InputError
from heatlens.export.plan import PlannedFrame
from heatlens.export.run import FrameDone
from heatlens.farm.children import started, stop
from heatlens.sequence.names import frames_text

_TOLD = ("--progress=json", "--quiet")


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
        self._news: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()

    def __call__(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        """Yield the frames as they are finished. Raises InputError where a process fails."""
        paths = {frame.frame: frame.path for frame in frames}
        # Each process gets frames from the whole shot, so that all end at about the same time.
        shares = [frames[at :: self._count] for at in range(min(self._count, len(frames)))]
        with ExitStack() as undone:
            for number, share in enumerate(shares):
                part = f"--part={frames_text([frame.frame for frame in share])}"
                more = (part, *device_words(self._devices, number))
                self._follow(undone, started([*self._words, *more, *_TOLD], count=len(shares)))
            running = len(shares)
            while running:
                news = self._news.get()
                if news["event"] == "frame":
                    frame, was_there = news["frame"], news["state"] != "written"
                    yield FrameDone(frame, paths[frame], was_there)
                running -= self._has_ended(news)

    def _follow(self, undone: ExitStack, process: "subprocess.Popen[str]") -> None:
        undone.enter_context(process)
        undone.callback(stop, process)
        Thread(target=self._read, args=(process,), daemon=True).start()

    def _read(self, process: "subprocess.Popen[str]") -> None:
        """Pass on the events of a process, and its end; runs on a thread."""
        assert process.stdout is not None
        assert process.stderr is not None
        for line in process.stdout:
            self._news.put(json.loads(line))
        why = process.stderr.read().strip().removeprefix("heatlens: ")
        if process.wait() != 0:
            self._news.put({"event": "exit", "why": why or f"exit code {process.returncode}"})

    def _has_ended(self, news: dict[str, Any]) -> bool:
        """Return True if a process has succeeded. Raises InputError if it has failed."""
        if news["event"] == "end" and "told" in news:
            self._say(news["told"])
        if news["event"] == "failed":
            raise InputError(news["message"])
        if news["event"] == "exit":
            raise InputError(
                f"A process ended early ({news['why']}). Finished frames are kept; export again to "
                "go on."
            )
        return bool(news["event"] == "end")


def device_words(devices: Sequence[int], number: int) -> tuple[str, ...]:
    """Return the option with which process `number` of several takes one of the devices."""
    return (f"--device={devices[number % len(devices)]}",) if devices else ()
