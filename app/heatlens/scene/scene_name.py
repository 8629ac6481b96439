"""From the name of a scene, in a shot file or on a command line, to the scene."""

import os
from pathlib import Path

from heatlens.scene.scene import Scene
from heatlens.scene.scene_read import is_scene_file, read_scene

DEMO = "demo"  # the scene that comes with the program, unless a file has that name


def names_scene(text: str) -> bool:
    """Return True where `text` names a scene rather than plates."""
    return is_demo(text) or is_scene_file(text)


def is_demo(text: str) -> bool:
    """Return True where `text` means the scene that comes with the program."""
    return text == DEMO and not os.path.exists(text)


def open_scene(text: str) -> Scene:
    """Return the scene; the demo is built only where it is asked for.

    Raises InputError naming the file where it cannot be read.
    """
    if is_demo(text):
        from heatlens.scene.demo.demo import demo_scene

        return demo_scene()
    return read_scene(Path(text))
