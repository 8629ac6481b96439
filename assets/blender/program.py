"""heatlens as a program that the add-on starts, and installs where it is missing.

A button of the preferences installs heatlens with pip into a folder of the add-on's own, which
Blender removes with the add-on.
"""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import bpy


def preferences_of_addon():
    """Return the preferences of the add-on, or None where Blender has not enabled it."""
    entry = bpy.context.preferences.addons.get(__package__)
    return entry.preferences if entry is not None else None


def command(*words):
    """Return the command line of heatlens as the preferences name it."""
    preferences = preferences_of_addon()
    named = preferences.command if preferences is not None else ""
    own = named or os.environ.get("HEATLENS", "heatlens")
    for program in ("bin/heatlens", "Scripts/heatlens.exe", "heatlens", "heatlens.exe"):
        if named and (Path(named) / program).is_file():  # a folder with an environment or program
            return [str(Path(named) / program), *map(str, words)]
    return [*shlex.split(own, posix=os.name != "nt"), *map(str, words)]


def started(*words):
    """Start heatlens. Raises OSError where there is no such program."""
    return subprocess.Popen(
        command(*words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def opened_window(*words):
    """Start heatlens with a window, which nobody waits for."""
    return subprocess.Popen(
        command(*words), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=True
    )


def ran(*words):
    """Run heatlens to its end. Raises RuntimeError with what it says where it refuses."""
    process = started(*words)
    said, _ = process.communicate()
    if process.returncode != 0:
        raise RuntimeError(said.strip().splitlines()[-1] if said.strip() else "heatlens failed")
    return said


NOT_FOUND = (
    "heatlens was not found. Name it in the preferences of this add-on: the folder of its Python "
    "environment, such as /home/me/heatlens/.venv, or a command. Or press Install heatlens there."
)
OFFLINE = (
    "Blender may not go online: allow it in Preferences, System, Network, and install again; or "
    "install heatlens yourself and name its folder."
)


# ---- install -------------------------------------------------------------------------------------


class Installation:
    """heatlens being installed: two commands one after the other, which nobody waits for.

    The preferences name the new environment only when both have succeeded.
    """

    def __init__(self):
        self.message = ""
        self._process = None
        self._commands_left = []
        self._folder = Path()

    @property
    def is_busy(self):
        """Return whether a command runs."""
        return self._process is not None

    def begin(self, folder, package):
        """Make an environment in `folder` and install `package`, a wheel or what pip knows."""
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "--quiet"]
        self._folder = folder
        self._commands_left = [
            [sys.executable, "-m", "venv", "--clear", str(folder)],
            [*pip, package],
        ]
        self._start_next()

    def poll(self):
        """Start the next command when one has ended, or give up where it failed."""
        if self._process is None or self._process.poll() is None:
            return
        process, self._process = self._process, None
        said = process.communicate()[0].strip()
        if process.returncode != 0:
            reason = said.splitlines()[-1] if said else "pip failed without a word."
            self.message = f"heatlens could not be installed: {reason}"
        elif self._commands_left:
            self._start_next()
        else:
            preferences_of_addon().command = str(self._folder)
            self.message = f"heatlens is installed in {self._folder}."

    def _start_next(self):
        self.message = "Installing heatlens: this takes a minute or two ..."
        # Python's variables of Blender would lead pip to Blender's own packages.
        environment = {name: it for name, it in os.environ.items() if not name.startswith("PYTHON")}
        self._process = subprocess.Popen(
            self._commands_left.pop(0),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=environment,
        )


INSTALL = Installation()


class HEATLENS_OT_install(bpy.types.Operator):
    """Install heatlens into a folder of this add-on, which goes when the add-on is removed"""

    bl_idname = "heatlens.install"
    bl_label = "Install heatlens"

    @classmethod
    def poll(cls, context):
        """Return whether nothing is being installed."""
        return not INSTALL.is_busy

    def execute(self, context):
        """Begin, unless Blender is to stay offline."""
        if not bpy.app.online_access:
            self.report({"ERROR"}, OFFLINE)
            return {"CANCELLED"}
        folder = bpy.utils.extension_path_user(__package__, path="environment", create=True)
        INSTALL.begin(Path(folder), preferences_of_addon().package)
        return {"FINISHED"}
