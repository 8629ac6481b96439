"""Readers for another process that print noise before and after they read."""

import ctypes
import importlib
import os
import sys
from collections.abc import Callable
from typing import NamedTuple


class Noisy(NamedTuple):
    """A request: the reader to call with its argument, and what to print, each in its way."""

    reader: str  # module:name
    argument: object
    noises: tuple[tuple[str, bytes], ...]  # the way and the words of each


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


def noisy(request: Noisy) -> object:
    """Print noise, call the reader, print noise again. Return the reader's result."""
    module, _, name = request.reader.partition(":")
    _print_noises(request)
    answer = getattr(importlib.import_module(module), name)(request.argument)
    _print_noises(request)
    return answer


def _print_noises(request: Noisy) -> None:
    for way, words in request.noises:
        WAYS[way](words)


class Evil:
    """An object that makes a folder when it is unpickled."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.mkdir, (self.path,)


def evil(path: str) -> Evil:
    """Return an answer that makes the folder `path` when it is unpickled."""
    return Evil(path)
