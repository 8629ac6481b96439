"""From what a shot names as its source to a scene."""

import os
from pathlib import Path

from heatlens.scene.scene import Scene

DEMO = "demo"  # the scene that comes with the program; a file of that name goes before it
SCENE_SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl", ".usd", ".usda", ".usdc", ".usdz")


def is_scene_source(text: str) -> bool:
    """Whether `text` names a scene rather than plates."""
    return is_demo(text) or Path(text).suffix.lower() in SCENE_SUFFIXES


def is_demo(text: str) -> bool:
    """Whether `text` means the scene that comes with the program."""
    return text == DEMO and not os.path.exists(text)


def open_scene(text: str) -> Scene:
    """The scene. Raises InputError naming the file where it cannot be read.

    What reads it is loaded here: plates do without.
    """
    if is_demo(text):
        from heatlens.scene.demo import demo_scene

        return demo_scene()
    from heatlens.scene.scene_read import read_scene

    return read_scene(Path(text))
