"""Test that threads share one heap, so that memory freed by one can be used by the others."""

import subprocess
import sys

import pytest

_HEAPS_OF_FOUR_THREADS = """
import ctypes, re, sys, threading
from heatlens.core.base.memory import share_one_heap

if sys.argv[1] == "shared":
    share_one_heap()
libc, meet = ctypes.CDLL(None), threading.Barrier(4)
libc.malloc.restype = ctypes.c_void_p

def allocate():
    meet.wait()
    libc.malloc(50_000)
    meet.wait()

threads = [threading.Thread(target=allocate) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
libc.fdopen.restype = ctypes.c_void_p
stream = ctypes.c_void_p(libc.fdopen(1, b"w"))
libc.malloc_info(0, stream)
libc.fflush(stream)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="glibc's heaps")
def test_share_one_heap_leaves_one_heap_for_all_threads():
    def heaps(how: str) -> int:
        words = [sys.executable, "-c", _HEAPS_OF_FOUR_THREADS, how]
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.count(
            "<heap nr"
        )

    assert heaps("apart") > 1
    assert heaps("shared") == 1
