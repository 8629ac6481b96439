"""Open a scene by its name in a shot file or on a command line."""

import os
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.model.shot.framing import SceneTiming
from heatlens.scene.scene import Scene
from heatlens.scene.scene_read import is_scene_file, read_scene

DEMO = "demo"  # the scene that comes with the program, unless a file has that name


def names_scene(text: str) -> bool:
    """Return True if `text` names a scene rather than plates."""
    return is_demo(text) or is_scene_file(text)


def is_demo(text: str) -> bool:
    """Return True if `text` means the scene that comes with the program."""
    return text == DEMO and not os.path.exists(text)


def open_scene(text: str, timing: SceneTiming | None = None) -> Scene:
    """Return the scene, with its seconds converted to frames; the demo is read only if needed.

    Raises InputError that names the file if it cannot be read, or if a timing is given for a file
    that defines its frames itself.
    """
    if is_demo(text):
        if timing is not None:
            raise InputError("The demo has one clip, and frames of its own.")
        from heatlens.scene.demo import demo_scene

        return demo_scene()
    return read_scene(Path(text), timing)
