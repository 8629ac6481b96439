"""A whole evening's work on a shot, with neither ImGui nor GLFW nor a context of OpenGL."""

import os
import subprocess
import sys
from pathlib import Path

import heatlens

_WITHOUT = ("imgui_bundle", "glfw", "glcontext", "heatlens.studio.ui")
_EVENING = f"""
import sys
from pathlib import Path
sys.modules.update(dict.fromkeys({_WITHOUT!r}))  # an import of any of them is an error
from support.evening import evening
evening(Path(sys.argv[1]))
"""


def test_session_script_runs_without_imgui_glfw_and_opengl(tmp_path):
    paths = [Path(heatlens.__file__).parents[1], Path(__file__).parents[2]]
    environ = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, paths))}
    line = [sys.executable, "-c", _EVENING, str(tmp_path)]
    done = subprocess.run(line, env=environ, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
