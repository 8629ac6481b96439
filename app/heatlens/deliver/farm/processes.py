"""Hand the frames of an export to processes on this machine, and follow them until they stop."""

import os
import queue
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from threading import Thread, current_thread, main_thread

from heatlens.core.base.errors import InputError
from heatlens.core.base.last_words import StderrTail
from heatlens.core.base.own_command import own_command
from heatlens.deliver.export.plan import PlannedFrame
from heatlens.deliver.export.run import FrameDone
from heatlens.deliver.farm.events import Event, event_in
from heatlens.media.sequence.names import frames_text

_EVENT_OPTIONS = ("--progress=json", "--quiet")
PATIENCE_S = 2.0  # time to stop before a process is killed
_READERS_PATIENCE_S = 30.0  # time for the readers of a killed process, on a very busy machine
_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_OWN_GROUP = 0  # flags of a new process
if sys.platform == "win32":  # only who leads a group can be asked to stop; SIGTERM ends at once
    _OWN_GROUP = subprocess.CREATE_NEW_PROCESS_GROUP


class ProcessMaker:
    """Makes frames in `count` processes; `report` shows the messages about their frames."""

    def __init__(
        self,
        words: Sequence[str],
        count: int,
        report: Callable[[str], None],
        devices: Sequence[int] = (),
    ) -> None:
        """Create it; `words` are the command line of `heatlens` that makes all frames.

        The processes take the `devices` in turn.
        """
        self._devices = devices
        self._words = words
        self._count = count
        self._report = report
        self._events: queue.SimpleQueue[Event] = queue.SimpleQueue()

    def __call__(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        """Yield the frames as they are finished. Raises InputError where a process fails."""
        paths = {frame.frame: frame.path for frame in frames}
        # Each process gets frames from the whole shot, so that all end at about the same time.
        shares = [frames[first :: self._count] for first in range(min(self._count, len(frames)))]
        with ExitStack() as cleanup:
            for number, share in enumerate(shares):
                part_option = f"--part={frames_text([frame.frame for frame in share])}"
                options = (part_option, *device_option(self._devices, number))
                self._follow(
                    cleanup,
                    start_process([*self._words, *options, *_EVENT_OPTIONS], count=len(shares)),
                )
            running = len(shares)
            while running:
                event = self._events.get()
                if event["event"] == "frame":
                    frame, was_there = event["frame"], event["state"] != "written"
                    pace = event.get("pace", "")
                    yield FrameDone(frame, paths[frame], was_there, pace=pace)
                running -= self._check_end(event)

    def _follow(self, cleanup: ExitStack, process: "subprocess.Popen[str]") -> None:
        """Read the events of a process on a thread; `cleanup` stops the process at its end."""
        reader = Thread(target=self._read_events, args=(process, StderrTail(process)), daemon=True)
        reader.start()
        cleanup.enter_context(process)  # closes the pipes, so the thread has to end before it
        cleanup.callback(reader.join, _READERS_PATIENCE_S)
        cleanup.callback(stop, process)

    def _read_events(self, process: "subprocess.Popen[str]", last_words: StderrTail) -> None:
        """Pass on the events of a process, and its end; runs on a thread."""
        assert process.stdout is not None
        for line in process.stdout:
            if (event := event_in(line)) is not None:
                self._events.put(event)
        reason = last_words.text().rpartition("heatlens: ")[2]
        if process.wait() != 0:
            self._events.put({"event": "exit", "why": reason or f"exit code {process.returncode}"})

    def _check_end(self, event: Event) -> bool:
        """Return True for the event by which a process ends. Raises InputError if it has failed."""
        if event["event"] == "end" and (message := _message_without_pace(event)):
            self._report(message)
        if event["event"] == "failed":
            raise InputError(event["message"])
        if event["event"] == "exit":
            raise InputError(
                f"A process ended early ({event['why']}). Finished frames are kept; export again "
                "to "
                "go on."
            )
        return bool(event["event"] == "end")


def _message_without_pace(event: Event) -> str:
    """Return the message in the end event of a process, without the pace of its frames.

    The pace is reported once for all processes.
    """
    message, pace = str(event.get("told", "")), event.get("pace")
    return message.removesuffix(f"{pace}.").strip() if pace else message


def device_option(devices: Sequence[int], number: int) -> tuple[str, ...]:
    """Return the option with which process `number` of several takes one of the devices."""
    return (f"--device={devices[number % len(devices)]}",) if devices else ()


def start_process(
    words: Sequence[str], is_shown: bool = False, count: int = 1
) -> "subprocess.Popen[str]":
    """Start the heatlens command with these words as a process, one of `count` at work.

    If `is_shown`, it prints here.
    """
    with _children_obey_signals():
        pipe = None if is_shown else subprocess.PIPE
        environment = _thread_limit(count) | os.environ
        return subprocess.Popen(
            own_command(*words),
            stdout=pipe,
            stderr=pipe,
            text=True,
            env=environment,
            creationflags=_OWN_GROUP,
        )


# By default Mesa starts a thread for each processor in every process, and each pass waits for the
# slowest of them. With the threads shared out, 24 frames of 480x270 in two processes take 18 s
# instead of 27 s.
def _thread_limit(count: int) -> dict[str, str]:
    """Return the environment variable that limits the threads of Mesa's software rasterizer.

    Each of `count` processes gets an equal share of the processors.
    """
    threads = max(1, (os.cpu_count() or 1) // count)
    return {"LP_NUM_THREADS": str(threads)} if count > 1 else {}


@contextmanager
def _children_obey_signals() -> Iterator[None]:
    """Start processes that obey stop signals, even if this process ignores them.

    A child inherits ignored signals, for example from `heatlens x &` in a script; a signal with a
    handler has its usual effect in the child. Only the main thread may set handlers.
    """
    if current_thread() is not main_thread():
        yield
        return
    ignored = [number for number in _STOP_SIGNALS if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, lambda *_: None)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


def stop(process: "subprocess.Popen[str]", stop_signal: signal.Signals = signal.SIGTERM) -> None:
    """Ask `process` to stop; kill it after a while if it has not."""
    if sys.platform == "win32":
        with suppress(OSError):  # without a console no process can be asked, and it is killed
            process.send_signal(signal.CTRL_BREAK_EVENT)
    else:
        process.send_signal(stop_signal)  # SIGTERM works from the first moment on, unlike Ctrl-C
    Thread(target=_kill_late, args=(process,), daemon=True).start()


def _kill_late(process: "subprocess.Popen[str]") -> None:
    """Kill a process that was asked to stop and still runs; runs on a thread."""
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
