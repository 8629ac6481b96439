"""Run `heatlens export`, `camera` and `shot sheet` as processes beside the window.

A separate process has a renderer of its own, does not block the window, and leaves whole files if
stopped.
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
from heatlens.core.base.faults import report_faults, to_heatlens_error
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.output import MOVIE_SUFFIXES
from heatlens.deliver.farm.cluster import DETACH_SIGNAL
from heatlens.deliver.farm.events import event_in
from heatlens.deliver.farm.export_place import (
    HERE,
    ExportPlace,
    LeftExport,
    Where,
    job_path,
    shot_of_job,
)
from heatlens.deliver.farm.processes import PATIENCE_S, start_process, stop
from heatlens.media.documents.shot_file import SHOT_SUFFIX, write_shot
from heatlens.media.files.atomic_file import write_atomically

_KILLED_S = 1.0  # time for the system to remove a killed process
_TITLES = {"shot sheet": "pull sheet"}
_STOPPED = (128 + signal.SIGTERM, -signal.SIGTERM)


@dataclass
class ExportState:
    """The progress of an export, as its process reports it."""

    title: str
    done_frames: int = 0
    frames: int = 0
    remaining_s: float | None = None
    pace: str = ""  # words on the time of the quality final
    last_sentence: str = ""  # the last sentence of the process
    code: int | None = None  # None while it runs
    output: str = ""  # the pattern of the frames, or the file
    files_note: str = ""  # a sentence of the process about the written files
    frames_by_worker: Counter[str] = field(
        default_factory=Counter
    )  # frames, by the worker of a cluster
    printed_lines: list[str] = field(
        default_factory=list
    )  # lines that are no events: the text of a job
    earlier_frames: int = 0  # frames that were finished before it began
    is_left_to_cluster: bool = False  # the cluster goes on with it
    is_cancelled: bool = False  # the user asked for its end

    @property
    def is_stopped(self) -> bool:
        """True if it was stopped before its end: here, or by a signal from outside.

        The exit code alone does not tell: a process that is ended on Windows has that of a failure.
        """
        return self.code in _STOPPED or (self.is_cancelled and self.code not in (None, 0))

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
        self._place = HERE
        self._job = ""
        self.state: ExportState | None = None  # state of the latest process

    @property
    def is_busy(self) -> bool:
        """True while a process runs."""
        return self.state is not None and self.state.code is None

    def export(self, shot: Shot, output: str, job: str = "", place: ExportPlace = HERE) -> None:
        """Begin to write the frames of `shot` to `output`, or the job that makes them at `place`.

        `job` is the text of a file of options.
        """
        self._start("export", shot, output, place.words(output), job, place)

    def camera(self, shot: Shot, output: str, options: Sequence[str] = ()) -> None:
        """Begin to write the lens of `shot` as a camera file."""
        self._start("camera", shot, output, options)

    def sheet(self, shot: Shot, output: str, options: Sequence[str] = ()) -> None:
        """Begin to write the pull sheet of `shot`; `words` are options of the command."""
        self._start("shot sheet", shot, output, ("--progress", "json", *options))

    def cancel(self) -> None:
        """Ask the process to stop; finished files stay, and a later export continues from there.

        If it has not stopped after a while, it is killed. This method does not wait.
        """
        if self._process is not None and self.state is not None and self.is_busy:
            self.state.is_cancelled = True
            stop(self._process)

    @property
    def can_be_left(self) -> bool:
        """True if a cluster makes the frames, and would go on without the process."""
        is_on_cluster = self._place.where is Where.CLUSTER and DETACH_SIGNAL is not None
        is_cancelled = self.state is not None and self.state.is_cancelled
        return self.is_busy and is_on_cluster and not is_cancelled

    # An export that a cluster makes continues there after the window is closed: the shot lies
    # beside the frames, and a window that is opened on the same source later starts the export
    # again, which finds the frames that are done and those under way.
    def close(self) -> LeftExport | None:
        """End the process and wait until it has ended, which does not take long.

        Return the export if the cluster goes on with it.
        """
        left_export = None
        if self.can_be_left and self._process is not None and self.state is not None:
            self.state.is_left_to_cluster = True
            left_export = LeftExport(self.state.output, self._job, self._place.scheduler)
            stop(self._process, DETACH_SIGNAL or signal.SIGTERM)
        else:
            self.cancel()
        if self._follower is not None:
            self._follower.join(PATIENCE_S + _KILLED_S)
        return None if self.state is not None and self.state.code == 0 else left_export

    # The options are handed to the process as JSON. As words of a command line, each option would
    # have to be written and parsed in a second place.
    def _start(
        self,
        command: str,
        shot: Shot,
        output: str,
        options: Sequence[str],
        job: str = "",
        place: ExportPlace = HERE,
    ) -> None:
        """Start the process and follow it. If that fails, leave no process or files behind."""
        title = f"{_TITLES.get(command, command)} to {output}"
        self._place, self._job = place, job
        if place.is_job:
            title = f"{place.job_name(output)} in {Path(output).parent}"
        with report_faults(f"The {title} could not start"), ExitStack() as cleanup:
            folder = tempfile.TemporaryDirectory(prefix="heatlens-")
            cleanup.enter_context(folder)
            path = Path(folder.name) / f"window{SHOT_SUFFIX}"
            if place.needs_shot_beside:
                path = shot_of_job(output)
            write_shot(path, shot)
            if job:
                job_path = Path(folder.name) / "job.json"
                job_path.write_text(job, encoding="utf-8")
                options = (*options, "--job", str(job_path))
            process = start_process([*command.split(), str(path), "-o", output, *options])
            cleanup.enter_context(process)  # closes its pipes
            cleanup.callback(process.kill)
            state = ExportState(title, output=output)
            thread_args = (process, state, folder, place)
            follower = Thread(target=self._follow_process, args=thread_args, daemon=True)
            follower.start()
            cleanup.pop_all()  # now the follower removes the folder when the process has ended
        self._process, self.state, self._follower = process, state, follower

    def _follow_process(
        self,
        process: "subprocess.Popen[str]",
        state: ExportState,
        folder: "tempfile.TemporaryDirectory[str]",
        place: ExportPlace,
    ) -> None:
        """Read what the process prints until it ends, then set its exit code; on a thread."""
        try:
            with folder, process:
                self._read_output(process, state)
            code = process.returncode
            if code == 0 and place.is_job:
                _keep_job(state, place)
            if place.where is Where.CLUSTER and (code == 0 or not state.is_left_to_cluster):
                shot_of_job(state.output).unlink(missing_ok=True)
            state.last_sentence = _closing_sentence(code, state)
        except Exception as error:  # without an exit code the window would wait forever
            state.last_sentence = str(to_heatlens_error(error, f"{state.title} failed"))
            code = FAULT_CODE
        state.code = code
        self._wake()

    def _read_output(self, process: "subprocess.Popen[str]", state: ExportState) -> None:
        """Read the events of the process until its output ends; another thread reads its errors."""
        errors = Thread(target=self._read_errors, args=(process, state), daemon=True)
        errors.start()
        assert process.stdout is not None
        try:
            for line in process.stdout:
                _read_event(line, state)
                self._wake()
        except Exception:
            stop(process)
            raise
        finally:
            errors.join()

    def _read_errors(self, process: "subprocess.Popen[str]", state: ExportState) -> None:
        """Keep the last line of the error output; runs on a thread."""
        assert process.stderr is not None
        for line in process.stderr:
            state.last_sentence = line.strip().removeprefix("heatlens: ")


def _keep_job(state: ExportState, place: ExportPlace) -> None:
    """Save the text of a job beside its shot, and keep the sentence that explains its use."""
    if place.where is Where.SLURM:
        path = job_path(state.output).with_name(place.job_name(state.output))
        write_atomically(path, "".join(state.printed_lines).encode())
    state.files_note = state.last_sentence


def _closing_sentence(code: int, state: ExportState) -> str:
    """Return the message of the window for exit code `code`; for a failure, that of the command."""
    if code == 0:
        return f"Done: {state.title}. {state.files_note}".strip()
    if state.is_left_to_cluster:
        return f"Left to the cluster: {state.title}."
    if state.is_cancelled or code in _STOPPED:
        return f"Stopped: {state.title}. {state.when_stopped}"
    return state.last_sentence


def _read_event(line: str, state: ExportState) -> None:
    """Apply the event in a line of `--progress json`; keep other lines, such as those of a job."""
    event = event_in(line)
    if event is None:
        state.printed_lines.append(line)
        return
    state.frames = event.get("frames", state.frames)
    state.done_frames = event.get("done", state.done_frames)
    state.remaining_s = event.get("seconds_left", state.remaining_s)
    state.files_note = event.get("told", state.files_note)
    state.pace = event.get("pace", state.pace)
    state.earlier_frames += event.get("state") == "finished before"
    if "worker" in event:
        state.frames_by_worker[event["worker"]] += 1
