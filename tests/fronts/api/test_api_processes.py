"""The Python interface in processes that were forked, and its help."""

import inspect
import pydoc
import subprocess
import sys

import heatlens
from support.patience import PATIENCE_S

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


def output_after_fork(before):
    words = [sys.executable, "-c", _FORKED, before]
    process = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert process.returncode == 0, process.stderr
    return process.stdout


def test_render_in_forked_process_fails_only_if_parent_has_rendered():
    """OpenGL would hang in a forked child whose parent has rendered, so an error is raised."""
    assert output_after_fork("drawn").count("spawn") == 2
    assert output_after_fork("nothing").count("(6, 8, 4)") == 2


def test_help_of_public_functions_begins_with_short_line():
    for name in heatlens.__all__:
        public_object = getattr(heatlens, name)
        if inspect.isfunction(public_object):
            line = pydoc.plain(pydoc.render_doc(public_object)).splitlines()[2]
            assert len(line) < 400, (name, line)
