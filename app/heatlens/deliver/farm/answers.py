"""The answers of workers: a line of JSON, followed by the bytes of files or pixels.

An answer is data that is checked here entry by entry. Nothing in it can run code, as a pickle can.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.faults import to_heatlens_error
from heatlens.core.base.outside_text import one_line, printable
from heatlens.deliver.farm import connection
from heatlens.deliver.farm.dask_types import Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.media.files.json_record import JsonEntry, record_to_json

_MOST_LETTERS = 600  # letters of a worker's sentence that are shown
_ANSWER_NAME = Path("the answer of a worker")
FOREIGN_ANSWER = (
    "A worker has sent something other than an answer of this heatlens: install the same version "
    "on all machines."
)


@dataclass(frozen=True)
class PartDone:
    """A frame that a worker has made, see `FrameDone`.

    driver  graphics driver and address of the worker; None for a frame that was finished before
    size    bytes of its file if it is fetched
    """

    frame: int
    was_there: bool
    surfaces_lost: str
    remarks: tuple[tuple[str, str], ...]
    driver: tuple[str, str] | None = None
    pace: str = ""
    size: int | None = None


FetchedPart = tuple[PartDone, bytes | None]  # with its file if it is fetched


def pack_answer(facts: Mapping[str, object], data: Sequence[bytes] = ()) -> bytes:
    """Return an answer: the facts as a line of JSON, then the bytes of `data`."""
    return b"".join((json.dumps(facts).encode(), b"\n", *data))


def answer_with(work: Callable[[], bytes], worker: str) -> bytes:
    """Return the answer of `work`; if it fails, an answer that holds the error message."""
    try:
        return work()
    except Exception as error:
        sentence = to_heatlens_error(error, "A worker could not do its part")
        return pack_answer({"problem": f"{sentence} (worker {worker})"})


def pack_frames(parts: Sequence[FetchedPart]) -> bytes:
    """Return the answer that holds frames and their files."""
    files = [data for _, data in parts if data is not None]
    return pack_answer({"frames": [record_to_json(done) for done, _ in parts]}, files)


def event_text(done: PartDone) -> str:
    """Return a finished frame as the text of an event."""
    return json.dumps(record_to_json(done))


def parse_event_text(text: object) -> PartDone:
    """Return the finished frame from the text of an event. Raises InputError for other texts."""
    return _parse_json(str(text).encode("utf-8", "replace")).record(PartDone)


def frames_of_answer(answer: bytes) -> list[FetchedPart]:
    """Return the frames of an answer. Raises InputError with the error message of a worker."""
    entry, data = unpack_answer(answer)
    frames = entry.members(("frames",), ("frames",))["frames"]
    return list(_split_files([item.record(PartDone) for item in frames.items()], data))


def _split_files(parts: Sequence[PartDone], data: bytes) -> Iterator[FetchedPart]:
    """Yield each frame with its file, cut from the joined bytes of all files. Raises InputError."""
    begin = 0
    for done in parts:
        if done.size is None:
            yield done, None
            continue
        if not 0 <= done.size <= len(data) - begin:
            raise InputError(FOREIGN_ANSWER)
        yield done, data[begin : begin + done.size]
        begin += done.size


def unpack_answer(answer: bytes) -> tuple[JsonEntry, bytes]:
    """Return the facts of an answer, and its bytes. Raises InputError with a worker's message."""
    line, _, data = answer.partition(b"\n")
    entry = _parse_json(line)
    if isinstance(entry.value, dict) and "problem" in entry.value:
        raise InputError(printable(str(entry.value["problem"]))[:_MOST_LETTERS])
    return entry, data


def _parse_json(line: bytes) -> JsonEntry:
    """Return the JSON of an answer. Raises InputError for anything else."""
    try:
        return JsonEntry(_ANSWER_NAME, "", json.loads(line, parse_constant=_refuse_constant))
    except (ValueError, RecursionError) as error:
        raise InputError(FOREIGN_ANSWER) from error


def _refuse_constant(name: str) -> object:
    raise ValueError(f"{name} is not JSON")


def answer_of(future: Future, patience: float = 1.0) -> bytes | None:
    """Return the answer of a task; None if it does not arrive in time, as when its worker has died.

    Without a time limit, the scheduler would wait for the worker forever. `patience` is a factor on
    the usual limit. Raises InputError if the task has failed, or its answer is not one of heatlens.
    """
    answer: Any = None
    try:
        answer = future.result(timeout=patience * connection.PATIENCE_S)
    except NotDataError as error:
        raise InputError(FOREIGN_ANSWER) from error
    except Exception as error:
        if future.status == "error":
            raise InputError(failure_message(error)) from error
        if not isinstance(error, TimeoutError):
            raise
        return None
    if not isinstance(answer, bytes):
        raise InputError(FOREIGN_ANSWER)
    return answer


def failure_message(error: BaseException) -> str:
    """Return an error message for a task that ended without an answer."""
    if b"KilledWorker" in next((it for it in error.args if isinstance(it, bytes)), b""):
        return "The workers that made them died; their memory may be too small."
    if type(error) is Exception:  # an error that is not data, so not one of heatlens
        return FOREIGN_ANSWER
    return f"A worker could not begin: {one_line(printable(f'{type(error).__name__}: {error}'))}."
