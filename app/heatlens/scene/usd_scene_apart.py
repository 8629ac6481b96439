"""OpenUSD at work in a process of its own: some damaged files end the process that opens them.

Run as a module it reads the scene that its argument names, and writes what became of it to its
standard output for the process that asked.
"""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import heatlens
from heatlens.errors import InputError
from heatlens.scene.scene import Scene
from heatlens.scene.usd_scene_read import usd_scene

_FAILED = 1  # Python's code for an error that nobody has caught


def read_usd(path: Path) -> Scene:
    """`usd_scene` in a process of its own. Raises InputError also where OpenUSD ends that."""
    # -P: a file beside the user's that is called like one of Python's must not be run.
    command = [sys.executable, "-P", "-m", __spec__.name, str(path)]
    done = subprocess.run(command, capture_output=True, env=_environment(), check=False)
    if done.returncode == _FAILED:
        raise RuntimeError(done.stderr.decode(errors="replace"))
    if done.returncode:
        raise InputError(f"{path} cannot be read: it is damaged in a way that ends OpenUSD.")
    outcome: Scene | InputError = pickle.loads(done.stdout)
    if isinstance(outcome, InputError):
        raise outcome
    return outcome


def _environment() -> dict[str, str]:
    """The one of this process, with the way to this very package."""
    paths = [str(Path(heatlens.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def _outcome(text: str) -> Scene | InputError:
    try:
        return usd_scene(Path(text))
    except InputError as error:
        return error


if __name__ == "__main__":
    sys.stdout.buffer.write(pickle.dumps(_outcome(sys.argv[1])))
