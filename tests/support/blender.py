"""Blender as a module of Python, for tests that are skipped where it is missing.

`HEATLENS_BPY_PYTHON` names the Python of an environment with `pip install bpy`; without it, this
one is taken where it has the module.
"""

import importlib.util
import os
import sys

_OWN = sys.executable if importlib.util.find_spec("bpy") else ""
PYTHON = os.environ.get("HEATLENS_BPY_PYTHON", _OWN)
