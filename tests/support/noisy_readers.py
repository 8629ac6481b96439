"""Readers for another process that print what they like, before and after they read."""

import ctypes
import importlib
import os
import sys
from collections.abc import Callable
from typing import NamedTuple


class Noisy(NamedTuple):
    """Which reader to call with which argument, and what to print in which way."""

    reader: str  # module:name
    argument: object
    way: str
    words: bytes


def _by_c(words: bytes) -> None:
    library = ctypes.CDLL(None)
    library.printf(b"%s", words)
    library.fflush(None)


WAYS: dict[str, Callable[[bytes], object]] = {
    "print": lambda words: print(words.decode("latin-1"), flush=True),
    "descriptor": lambda words: os.write(1, words),
    "unflushed": lambda words: sys.stdout.write(words.decode("latin-1")),
    "C": _by_c,
}


def noisy(asked: Noisy) -> object:
    """Return what the reader does."""
    module, _, name = asked.reader.partition(":")
    WAYS[asked.way](asked.words)
    answer = getattr(importlib.import_module(module), name)(asked.argument)
    WAYS[asked.way](asked.words)
    return answer


class Evil:
    """Calls a function of another module when it is unpacked."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.mkdir, (self.path,)


def evil(path: str) -> Evil:
    """Return an answer that makes a folder when it is unpacked."""
    return Evil(path)
