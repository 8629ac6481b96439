"""Run `heatlens export`, `camera` and `shot sheet` as processes beside the window.

A separate process has its own OpenGL, does not block the window, and leaves whole files if stopped.
"""

import signal
import subprocess
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread

from heatlens.core.base.errors import FAULT_CODE
from heatlens.core.base.faults import faults_reported, told_error
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.output import MOVIE_SUFFIXES
from heatlens.deliver.farm.cluster import LEAVE
from heatlens.deliver.farm.events import event_in
from heatlens.deliver.farm.processes import PATIENCE_S, started, stop
from heatlens.media.documents.shot_file import SHOT_SUFFIX, write_shot
from heatlens.media.files.atomic_file import write_whole
from heatlens.studio.session.settings.export_place import (
    HERE,
    ExportPlace,
    LeftExport,
    Where,
    job_path,
    shot_of_job,
)

_KILLED_S = 1.0  # time for the system to remove a killed process
_TITLES = {"shot sheet": "pull sheet"}
_STOPPED = (128 + signal.SIGTERM, -signal.SIGTERM, -signal.SIGKILL)


@dataclass
class ExportState:
    """The progress of an export, as its process reports it."""

    title: str
    done: int = 0
    frames: int = 0
    left_s: float | None = None
    pace: str = ""  # words on the time of the quality final
    said: str = ""  # the last sentence of the process
    code: int | None = None  # None while it runs
    output: str = ""  # the pattern of the frames, or the file
    told: str = ""  # a sentence of the process about the written files
    made_by: Counter[str] = field(default_factory=Counter)  # frames, by the worker of a cluster
    printed: list[str] = field(default_factory=list)  # what is no event: the text of a job
    earlier: int = 0  # frames that were finished before it began
    is_left: bool = False  # the cluster goes on with it

    @property
    def is_stopped(self) -> bool:
        """Return True if the user stopped it."""
        return self.code in _STOPPED

    @property
    def when_stopped(self) -> str:
        """A sentence on what remains if the export is stopped."""
        if Path(self.output).suffix.lower() in MOVIE_SUFFIXES:
            return "An unfinished movie is deleted; exporting again starts over."
        return "Finished frames are kept; exporting again continues with the rest."


class ExportRun:
    """Runs one process at a time and follows its output."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Take `wake`, which is called on a thread when the export has news."""
        self._wake = wake
        self._process: subprocess.Popen[str] | None = None
        self._follower: Thread | None = None
        self._is_stopping = False
        self._place = HERE
        self._job = ""
        self.state: ExportState | None = None  # state of the latest process

    @property
    def is_busy(self) -> bool:
        """Return True while a process runs."""
        return self.state is not None and self.state.code is None

    def export(self, shot: Shot, output: str, job: str = "", place: ExportPlace = HERE) -> None:
        """Begin to write the frames of `shot` to `output`, or the job that makes them at `place`.

        `job` is the text of a file of options.
        """
        self._start("export", shot, output, place.words(output), job, place)

    def camera(self, shot: Shot, output: str, words: Sequence[str] = ()) -> None:
        """Begin to write the lens of `shot` as a camera file."""
        self._start("camera", shot, output, words)

    def sheet(self, shot: Shot, output: str, words: Sequence[str] = ()) -> None:
        """Begin to write the pull sheet of `shot`; `words` are options of the command."""
        self._start("shot sheet", shot, output, ("--progress", "json", *words))

    def cancel(self) -> None:
        """Ask the process to stop; finished files stay, and a later export continues from there.

        If it has not stopped after a while, it is killed. This method does not wait.
        """
        if self._process is not None and self.is_busy:
            self._is_stopping = True
            stop(self._process)

    @property
    def can_be_left(self) -> bool:
        """Return True if a cluster makes the frames, and would go on without the process."""
        is_there = self._place.where is Where.CLUSTER and LEAVE is not None
        return self.is_busy and is_there and not self._is_stopping

    # Closing the window used to end the export of the night. Where a cluster makes it, it may be
    # left there: the shot lies beside the frames, and a window that is opened on the same source
    # later starts the export again, which finds what is done and what is under way.
    def close(self) -> LeftExport | None:
        """End the process and wait for that, which does not take long.

        Return the export if the cluster goes on with it.
        """
        left = None
        if self.can_be_left and self._process is not None and self.state is not None:
            self.state.is_left = True
            left = LeftExport(self.state.output, self._job, self._place.scheduler)
            stop(self._process, LEAVE or signal.SIGTERM)
        else:
            self.cancel()
        if self._follower is not None:
            self._follower.join(PATIENCE_S + _KILLED_S)
        return None if self.state is not None and self.state.code == 0 else left

    # Another process exports, with options handed over as JSON. They used to be written as the
    # words of a command line and parsed again, so that each option stood in a second place.
    def _start(
        self,
        command: str,
        shot: Shot,
        output: str,
        words: Sequence[str],
        job: str = "",
        place: ExportPlace = HERE,
    ) -> None:
        """Start the process and follow it. If that fails, leave no process or files behind."""
        title = f"{_TITLES.get(command, command)} to {output}"
        self._place, self._job, self._is_stopping = place, job, False
        if place.is_job:
            title = f"{place.job_name(output)} in {Path(output).parent}"
        with faults_reported(f"The {title} could not start"), ExitStack() as undone:
            folder = tempfile.TemporaryDirectory(prefix="heatlens-")
            undone.enter_context(folder)
            path = Path(folder.name) / f"window{SHOT_SUFFIX}"
            if place.needs_shot_beside:
                path = shot_of_job(output)
            write_shot(path, shot)
            if job:
                job_path = Path(folder.name) / "job.json"
                job_path.write_text(job, encoding="utf-8")
                words = (*words, "--job", str(job_path))
            process = started([*command.split(), str(path), "-o", output, *words])
            undone.enter_context(process)  # closes its pipes
            undone.callback(process.kill)
            state = ExportState(title, output=output)
            followed = (process, state, folder, place)
            follower = Thread(target=self._follow, args=followed, daemon=True)
            follower.start()
            undone.pop_all()  # now the follower removes the folder when the process has ended
        self._process, self.state, self._follower = process, state, follower

    def _follow(
        self,
        process: "subprocess.Popen[str]",
        state: ExportState,
        folder: "tempfile.TemporaryDirectory[str]",
        place: ExportPlace,
    ) -> None:
        """Read what the process prints until it ends, then set its exit code; on a thread."""
        try:
            with folder, process:
                self._read(process, state)
            code = process.returncode
            if code == 0 and place.is_job:
                _keep_job(state, place)
            if place.where is Where.CLUSTER and (code == 0 or not state.is_left):
                shot_of_job(state.output).unlink(missing_ok=True)
            state.said = _closing_sentence(code, state)
        except Exception as error:  # without an exit code the window would wait forever
            state.said, code = str(told_error(error, f"{state.title} failed")), FAULT_CODE
        state.code = code
        self._wake()

    def _read(self, process: "subprocess.Popen[str]", state: ExportState) -> None:
        errors = Thread(target=self._listen, args=(process, state), daemon=True)
        errors.start()
        assert process.stdout is not None
        try:
            for line in process.stdout:
                _take(line, state)
                self._wake()
        except Exception:
            stop(process)
            raise
        finally:
            errors.join()

    def _listen(self, process: "subprocess.Popen[str]", state: ExportState) -> None:
        assert process.stderr is not None
        for line in process.stderr:
            state.said = line.strip().removeprefix("heatlens: ")


def _keep_job(state: ExportState, place: ExportPlace) -> None:
    """Save the text of a job beside its shot, and tell what the command says of its use."""
    if place.where is Where.SLURM:
        path = job_path(state.output).with_name(place.job_name(state.output))
        write_whole(path, "".join(state.printed).encode())
    state.told = state.said


def _closing_sentence(code: int, state: ExportState) -> str:
    """Return the message of the window for exit code `code`; for a failure, that of the command."""
    if code == 0:
        return f"Done: {state.title}. {state.told}".strip()
    if state.is_left:
        return f"Left to the cluster: {state.title}."
    if code in _STOPPED:
        return f"Stopped: {state.title}. {state.when_stopped}"
    return state.said


def _take(line: str, state: ExportState) -> None:
    """Take the event in a line of `--progress json`; keep other lines, such as those of a job."""
    event = event_in(line)
    if event is None:
        state.printed.append(line)
        return
    state.frames = event.get("frames", state.frames)
    state.done = event.get("done", state.done)
    state.left_s = event.get("seconds_left", state.left_s)
    state.told = event.get("told", state.told)
    state.pace = event.get("pace", state.pace)
    state.earlier += event.get("state") == "finished before"
    if "worker" in event:
        state.made_by[event["worker"]] += 1
