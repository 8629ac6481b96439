"""A cluster worker that sends false answers: `python -m support.lying_worker ADDRESS LIE_FILE`.

The file is read for each task, so that one worker serves many tests. Its first line names a lie of
LIES or ANSWERS, or is `seed N`: then each task draws its lie, and the bytes of its answer. Its
second line is the path of the files that pickled code makes, without the process id at their end.
"""

import asyncio
import os
import pickle
import random
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.farm import answers, frame_worker
from heatlens.deliver.farm.answers import FetchedPart, PartDone
from heatlens.deliver.farm.cluster import PartTask
from heatlens.deliver.farm.connection import library
from heatlens.fronts.commands import worker as honest
from heatlens.media.sequence.names import parse_frames

Parts = list[FetchedPart]
Tell = Callable[[PartDone], None]


class RunsCommand:
    """An object that, when unpickled, runs a command that makes a file named by the process id.

    Workers unpickle their own errors.
    """

    def __reduce__(self):
        _, ran = current_lie()
        return os.system, (f"touch {ran}.$PPID",)


class RunsCommandError(Exception):
    def __reduce__(self):
        return RunsCommand().__reduce__()


def current_lie() -> tuple[str, str]:
    """Return the kind of lie that is asked for now, and the path of the files of pickled code."""
    kind, ran = Path(sys.argv[2]).read_text().splitlines()
    return kind, ran


def _claim_all_frames(task: PartTask, data: bytes | None, report: Tell) -> Parts:
    """Report all frames of a task as made, with the same bytes for each or without files."""
    return _send_files(task, [data] * len(parse_frames(task.frames)), report)


def _send_files(task: PartTask, files: Sequence[bytes | None], report: Tell) -> Parts:
    """Send `files` as those of the task's frames, or write them to the expected paths."""
    parts: Parts = []
    paths = {} if task.fetch else {it.frame: it.path for it in honest._plan_task(task).frames}
    for frame, data in zip(parse_frames(task.frames), files, strict=True):
        size = len(data) if task.fetch and data is not None else None
        report_of_part = PartDone(
            frame,
            was_there=False,
            surfaces_lost="",
            remarks=(),
            driver=("a driver\x1b[2J", "tcp://worker"),
            pace="",
            size=size,
        )
        if not task.fetch:
            if data is not None:
                paths[frame].write_bytes(data)
            report(report_of_part)
        parts.append((report_of_part, data if size is not None else None))
    return parts


def _rendered_files(task: PartTask, report: Tell) -> list[bytes]:
    return [data or b"" for _, data in _MADE(replace(task, fetch=True), report)]


def _of_another_frame(task: PartTask, report: Tell) -> Parts:
    """Send for each frame the file of the frame before; the first gets that of the last."""
    files = _rendered_files(replace(task, frames="1001-1006"), report)
    by_frame = dict(zip(range(1002, 1008), files, strict=True)) | {1001: files[-1]}
    return _send_files(task, [by_frame[frame] for frame in parse_frames(task.frames)], report)


def _truncated_files(task: PartTask, report: Tell) -> Parts:
    return _send_files(
        task, [data[: len(data) // 2] for data in _rendered_files(task, report)], report
    )


def _other_frames(task: PartTask, report: Tell) -> Parts:
    report_of_part = PartDone(7, was_there=False, surfaces_lost="", remarks=())
    report(report_of_part)
    return [(report_of_part, None)]


def _send_pickled_warnings(task: PartTask, report: Tell) -> Parts:
    for topic in ("warn", "print"):
        event = {
            "message": pickle.dumps(RunsCommand()),
            "category": pickle.dumps(RunsCommand()),
            "args": ["x"],
        }
        library().get_worker().log_event(topic, event)
    return _claim_all_frames(task, None, report)


LIES: dict[str, Callable[[PartTask, Tell], Parts]] = {
    "nothing written": lambda task, tell: _claim_all_frames(task, None, tell),
    "garbage": lambda task, tell: _claim_all_frames(task, b"not an exr", tell),
    "empty": lambda task, tell: _claim_all_frames(task, b"", tell),
    "huge": lambda task, tell: _claim_all_frames(task, b"x" * 30_000_000, tell),
    "short": lambda task, tell: _claim_all_frames(task, None, tell)[:0],
    "other frames": _other_frames,
    "another frame": _of_another_frame,
    "half": _truncated_files,
    "warns": _send_pickled_warnings,
}


def _raise_pickled_error() -> object:
    raise RunsCommandError


# Lies about the answer itself, which Dask would unpickle where the export was started.
ANSWERS: dict[str, Callable[[], object]] = {
    "runs": RunsCommand,
    "runs in a list": lambda: [RunsCommand()],
    "fails and runs": _raise_pickled_error,
    "a text": lambda: "done",
    "no answer": lambda: b"\x00\xff",
    "deep": lambda: b"[" * 100_000,
    "a number": lambda: b'{"frames": [{"frame": 1e999}]}\n',
    "a long sentence": lambda: b'{"problem": "\\u001b[2J' + b"x" * 100_000 + b'"}\n',
}
_MADE = honest._make_frames


def _random_lie(task: PartTask, report: Tell, rng: random.Random) -> Parts:
    lies = [*LIES.values(), _MADE]
    return rng.choice(lies)(task, report)


def _change_bytes(answer: bytes, rng: random.Random) -> bytes:
    """Change an answer in a few places."""
    changed = bytearray(answer)
    for _ in range(rng.choice((0, 0, 1, 3))):
        start = rng.randrange(min(len(changed), 400) or 1)
        changed[start : start + rng.choice((0, 1, 8))] = rng.randbytes(rng.choice((0, 1, 4)))
    return bytes(changed)


def lying_part(task: PartTask) -> object:
    """Answer in place of `make_part`, on the thread of a worker."""
    lie_kind, _ = current_lie()
    worker = library().get_worker()

    def tell(report_of_part: PartDone) -> None:
        worker.log_event(task.topic, {"frame": answers.event_text(report_of_part)})

    if lie_kind in ANSWERS:
        return ANSWERS[lie_kind]()
    rng = random.Random(f"{lie_kind} {task.frames} {time.time_ns()}")
    if lie_kind in LIES:
        return answers.pack_frames(LIES[lie_kind](task, tell))
    if rng.random() < 0.2:
        return rng.choice(list(ANSWERS.values()))()
    return _change_bytes(answers.pack_frames(_random_lie(task, tell, rng)), rng)


def main() -> None:
    honest.make_part = lying_part
    frame_worker.answer_program = frame_worker.answer_frame = lambda *_: ANSWERS[current_lie()[0]]()
    with temporary_folder() as folder:
        asyncio.run(honest._run_worker(sys.argv[1], "127.0.0.1", folder))


if __name__ == "__main__":
    main()
