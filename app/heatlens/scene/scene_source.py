"""From what a shot names as its source to a scene."""

import os
from pathlib import Path

from heatlens.scene.scene import Scene
from heatlens.scene.scene_read import is_scene_file, read_scene

DEMO = "demo"  # the scene that comes with the program; a file of that name goes before it


def is_scene_source(text: str) -> bool:
    """Whether `text` names a scene rather than plates."""
    return is_demo(text) or is_scene_file(text)


def is_demo(text: str) -> bool:
    """Whether `text` means the scene that comes with the program."""
    return text == DEMO and not os.path.exists(text)


def open_scene(text: str) -> Scene:
    """The scene. Raises InputError naming the file where it cannot be read.

    The demo is made only where it is asked for.
    """
    if is_demo(text):
        from heatlens.scene.demo.demo import demo_scene

        return demo_scene()
    return read_scene(Path(text))
