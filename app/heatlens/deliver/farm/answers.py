"""What workers answer: a line of JSON, and the bytes of files or pixels behind it.

An answer is data that is checked here entry by entry. Nothing in it can run code, as a pickle can.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.faults import told_error
from heatlens.core.base.outside_text import one_line, printable
from heatlens.deliver.farm import connection
from heatlens.deliver.farm.dask_types import Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.media.files.json_record import JsonEntry, record_to_json

_WORDS_MOST = 600  # letters of a worker's sentence that are shown
_PLACE = Path("the answer of a worker")
OTHER = (
    "A worker has sent something other than an answer of this heatlens: install the same version "
    "on all machines."
)


@dataclass(frozen=True)
class PartDone:
    """A frame that a worker has made, see `FrameDone`.

    driver  OpenGL driver and address of the worker; None for a frame that was there
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


def packed(facts: Mapping[str, object], data: Sequence[bytes] = ()) -> bytes:
    """Return an answer."""
    return b"".join((json.dumps(facts).encode(), b"\n", *data))


def answered(work: Callable[[], bytes], worker: str) -> bytes:
    """Return the answer of `work`, or the sentence that tells why there is none."""
    try:
        return work()
    except Exception as error:
        sentence = told_error(error, "A worker could not do its part")
        return packed({"problem": f"{sentence} (worker {worker})"})


def packed_parts(parts: Sequence[FetchedPart]) -> bytes:
    """Return the answer that holds frames and their files."""
    files = [data for _, data in parts if data is not None]
    return packed({"frames": [record_to_json(done) for done, _ in parts]}, files)


def part_text(done: PartDone) -> str:
    """Return a frame as a text, as an event tells it."""
    return json.dumps(record_to_json(done))


def part_of_text(text: object) -> PartDone:
    """Return the frame of an event. Raises InputError if it is none."""
    return _parsed(str(text).encode("utf-8", "replace")).record(PartDone)


def parts_of_answer(answer: bytes) -> list[FetchedPart]:
    """Return the frames of an answer. Raises InputError with the sentence of a worker."""
    entry, data = opened(answer)
    frames = entry.members(("frames",), ("frames",))["frames"]
    return list(_with_files([item.record(PartDone) for item in frames.items()], data))


def _with_files(parts: Sequence[PartDone], data: bytes) -> Iterator[FetchedPart]:
    at = 0
    for done in parts:
        if done.size is None:
            yield done, None
            continue
        if not 0 <= done.size <= len(data) - at:
            raise InputError(OTHER)
        yield done, data[at : at + done.size]
        at += done.size


def opened(answer: bytes) -> tuple[JsonEntry, bytes]:
    """Return the facts of an answer, and its bytes. Raises InputError with a worker's sentence."""
    line, _, data = answer.partition(b"\n")
    entry = _parsed(line)
    if isinstance(entry.value, dict) and "problem" in entry.value:
        raise InputError(printable(str(entry.value["problem"]))[:_WORDS_MOST])
    return entry, data


def _parsed(line: bytes) -> JsonEntry:
    try:
        return JsonEntry(_PLACE, "", json.loads(line, parse_constant=_no_number))
    except (ValueError, RecursionError) as error:
        raise InputError(OTHER) from error


def _no_number(name: str) -> object:
    raise ValueError(f"{name} is not JSON")


def answer_of(future: Future, patience: float = 1.0) -> bytes | None:
    """Return what a task has answered, or None if its worker has died with it, as far as is known.

    The scheduler would wait for ever for a worker. `patience` is in usual limits of time. Raises
    InputError if the task has failed, or its answer is none.
    """
    answer: Any = None
    try:
        answer = future.result(timeout=patience * connection.PATIENCE_S)
    except NotDataError as error:
        raise InputError(OTHER) from error
    except Exception as error:
        if future.status == "error":
            raise InputError(failure_of(error)) from error
        if not isinstance(error, TimeoutError):
            raise
        return None
    if not isinstance(answer, bytes):
        raise InputError(OTHER)
    return answer


def failure_of(error: BaseException) -> str:
    """Return a sentence on a task that ended without an answer."""
    if b"KilledWorker" in next((it for it in error.args if isinstance(it, bytes)), b""):
        return "The workers that made them died; their memory may be too small."
    if type(error) is Exception:  # an error that is not data, so not one of heatlens
        return OTHER
    return f"A worker could not begin: {one_line(printable(f'{type(error).__name__}: {error}'))}."
