"""The Python interface in processes that were forked, and its help."""

import inspect
import pydoc
import subprocess
import sys

import heatlens

_FORKED = """
import multiprocessing, sys
import numpy as np, heatlens

def drawn(_):
    try:
        return heatlens.open(np.ones((6, 8, 3)), np.ones((6, 8))).render(**LENS).shape
    except heatlens.HeatlensError as error:
        return str(error)

LENS = dict(focal_length_mm=50, f_stop=2, focus_distance_m=2, sensor_width_mm=36)
if sys.argv[1] == "drawn":
    drawn(0)
with multiprocessing.get_context("fork").Pool(2) as pool:
    print(pool.map(drawn, range(2)))
"""


def said_after_fork(before):
    words = [sys.executable, "-c", _FORKED, before]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_a_fork_after_a_picture_is_an_error_and_before_it_none():
    """OpenGL hangs for ever in a child whose parent has drawn."""
    assert said_after_fork("drawn").count("spawn") == 2
    assert said_after_fork("nothing").count("(6, 8, 4)") == 2


def test_help_begins_with_a_line_that_can_be_read():
    for name in heatlens.__all__:
        found = getattr(heatlens, name)
        if inspect.isfunction(found):
            line = pydoc.plain(pydoc.render_doc(found)).splitlines()[2]
            assert len(line) < 400, (name, line)
