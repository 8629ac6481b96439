"""A worker of a cluster that lies: `python -m support.lying_worker ADDRESS HOW`.

HOW names a lie of LIES, or is `seed N`: then each task draws its lie, and the bytes of its answer.
"""

import asyncio
import os
import pickle
import random
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.farm import answers, frame_worker
from heatlens.deliver.farm.answers import FetchedPart, PartDone
from heatlens.deliver.farm.cluster import PartTask
from heatlens.deliver.farm.connection import library
from heatlens.fronts.commands import worker as honest
from heatlens.media.sequence.names import parse_frames

Parts = list[FetchedPart]
Tell = Callable[[PartDone], None]


class Ran:
    """What runs a command where it is unpickled: it makes a file with the number of the process.

    Workers unpickle their own errors.
    """

    def __reduce__(self):
        return os.system, (f"touch {os.environ['RAN']}.$PPID",)


class RanError(Exception):
    def __reduce__(self):
        return Ran().__reduce__()


def _told(task: PartTask, data: bytes | None, tell: Tell) -> Parts:
    """Tell of all frames of a task as made, with the same bytes for each, or with none written."""
    return _given(task, [data] * len(parse_frames(task.frames)), tell)


def _given(task: PartTask, files: Sequence[bytes | None], tell: Tell) -> Parts:
    """Send these files as those of the frames, or write them where they are awaited."""
    found: Parts = []
    paths = {} if task.fetch else {it.frame: it.path for it in honest._planned(task).frames}
    for frame, data in zip(parse_frames(task.frames), files, strict=True):
        size = len(data) if task.fetch and data is not None else None
        done = PartDone(frame, False, "", (), ("a driver\x1b[2J", "tcp://worker"), "", size)
        if not task.fetch:
            if data is not None:
                paths[frame].write_bytes(data)
            tell(done)
        found.append((done, data if size is not None else None))
    return found


def _files(task: PartTask, tell: Tell) -> list[bytes]:
    return [data or b"" for _, data in _MADE(replace(task, fetch=True), tell)]


def _of_another_frame(task: PartTask, tell: Tell) -> Parts:
    """Give the files of the frames before; the first gets that of the last."""
    files = _files(replace(task, frames="1001-1006"), tell)
    by_frame = dict(zip(range(1002, 1008), files, strict=True)) | {1001: files[-1]}
    return _given(task, [by_frame[frame] for frame in parse_frames(task.frames)], tell)


def _half(task: PartTask, tell: Tell) -> Parts:
    return _given(task, [data[: len(data) // 2] for data in _files(task, tell)], tell)


def _other_frames(task: PartTask, tell: Tell) -> Parts:
    done = PartDone(7, False, "", ())
    tell(done)
    return [(done, None)]


def _warns(task: PartTask, tell: Tell) -> Parts:
    for topic in ("warn", "print"):
        told = {"message": pickle.dumps(Ran()), "category": pickle.dumps(Ran()), "args": ["x"]}
        library().get_worker().log_event(topic, told)
    return _told(task, None, tell)


LIES: dict[str, Callable[[PartTask, Tell], Parts]] = {
    "nothing written": lambda task, tell: _told(task, None, tell),
    "garbage": lambda task, tell: _told(task, b"not an exr", tell),
    "empty": lambda task, tell: _told(task, b"", tell),
    "huge": lambda task, tell: _told(task, b"x" * 30_000_000, tell),
    "short": lambda task, tell: _told(task, None, tell)[:0],
    "other frames": _other_frames,
    "another frame": _of_another_frame,
    "half": _half,
    "warns": _warns,
}


def _raised() -> object:
    raise RanError


# Lies about the answer itself, which Dask would unpickle where the export was started.
ANSWERS: dict[str, Callable[[], object]] = {
    "runs": Ran,
    "runs in a list": lambda: [Ran()],
    "fails and runs": _raised,
    "a text": lambda: "done",
    "no answer": lambda: b"\x00\xff",
    "deep": lambda: b"[" * 100_000,
    "a number": lambda: b'{"frames": [{"frame": 1e999}]}\n',
    "a long sentence": lambda: b'{"problem": "\\u001b[2J' + b"x" * 100_000 + b'"}\n',
}
_MADE = honest._made


def _drawn(task: PartTask, tell: Tell, chance: random.Random) -> Parts:
    lies = [*LIES.values(), _MADE]
    return chance.choice(lies)(task, tell)


def _mutated(answer: bytes, chance: random.Random) -> bytes:
    """Change an answer in a few places."""
    changed = bytearray(answer)
    for _ in range(chance.choice((0, 0, 1, 3))):
        at = chance.randrange(min(len(changed), 400) or 1)
        changed[at : at + chance.choice((0, 1, 8))] = chance.randbytes(chance.choice((0, 1, 4)))
    return bytes(changed)


def lying_part(task: PartTask) -> object:
    """Answer in place of `made_part`, on the thread of a worker."""
    how = os.environ["HOW"]
    worker = library().get_worker()

    def tell(done: PartDone) -> None:
        worker.log_event(task.topic, {"frame": answers.part_text(done)})

    if how in ANSWERS:
        return ANSWERS[how]()
    chance = random.Random(f"{how} {task.frames} {time.time_ns()}")
    if how in LIES:
        return answers.packed_parts(LIES[how](task, tell))
    if chance.random() < 0.2:
        return chance.choice(list(ANSWERS.values()))()
    return _mutated(answers.packed_parts(_drawn(task, tell, chance)), chance)


def main() -> None:
    os.environ["HOW"] = " ".join(sys.argv[2:])
    honest.made_part = lying_part
    frame_worker.program_of = frame_worker.rendered = lambda *_: ANSWERS[os.environ["HOW"]]()
    with temporary_folder() as folder:
        asyncio.run(honest._work(sys.argv[1], "127.0.0.1", folder))


if __name__ == "__main__":
    main()
