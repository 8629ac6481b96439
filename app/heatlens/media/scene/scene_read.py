"""Read 3D scene files with the reader for their extension; open a scene by its name."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.core.base.paths import unreadable_error
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene.kept_scene import kept_files, read_or_kept

if TYPE_CHECKING:  # the readers make it
    from heatlens.media.scene.scene import Scene


_GLTF = OnUse("media.scene.gltf.read", "read_gltf")
_MESH = OnUse("media.scene.mesh_read", "read_mesh")
_USD = OnUse("media.scene.usd.read", "read_usd")
_GLTF_FILES = OnUse("media.scene.gltf.file", "named_files")
_USD_FILES = OnUse("media.scene.usd.files", "files_of_usd")
_READERS = {
    **dict.fromkeys((".glb", ".gltf"), _GLTF),
    **dict.fromkeys((".obj", ".ply", ".stl"), _MESH),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _USD),
}
_FILE_FINDERS: dict[str, Callable[[Path], tuple[Path, ...]]] = {
    **dict.fromkeys((".glb", ".gltf"), _GLTF_FILES),
    ".obj": OnUse("media.scene.obj_files", "files_of_obj"),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _USD_FILES),
}

SCENE_SUFFIXES = tuple(_READERS)


def is_scene_file(text: str | os.PathLike[str]) -> bool:
    """Return whether a path has the suffix of a scene, without opening it."""
    return Path(text).suffix.lower() in _READERS


def files_of_scene(path: Path) -> tuple[Path, ...]:
    """Return the scene's file, then the files that it names.

    PLY and STL files name no others. Raises InputError if a file that may name others cannot be
    read.
    """
    return kept_files(path) or (path, *_named_files(path))


def _named_files(path: Path) -> tuple[Path, ...]:
    """Return the files that a scene's file names."""
    find_files = _FILE_FINDERS.get(path.suffix.lower())
    return () if find_files is None else find_files(path)


def check_scene_files_exist(text: str) -> None:
    """Raise InputError if a file of the scene `text` is missing."""
    for path in () if is_demo(text) else files_of_scene(Path(text)):
        if not os.path.isfile(path):
            raise unreadable_error(path)


def read_scene(path: str | os.PathLike[str], timing: SceneTiming | None = None) -> "Scene":
    """Read meshes, materials, cameras, lights and motion, which `timing` converts to frames.

    Raises InputError that names the file if it is missing, damaged, empty or of an unknown kind,
    or if a timing is given for a file that defines its frames itself. If a library is missing, the
    error says what to install.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        suffix_list = ", ".join(SCENE_SUFFIXES)
        raise InputError(f"{path} is not a scene that heatlens reads; it reads {suffix_list}.")
    if not os.path.isfile(path):
        raise unreadable_error(path)
    if timing is None:
        scene: "Scene" = reader(path)
        return scene
    if reader is not _GLTF:
        raise InputError(
            f"{path}: clips, frame rate and first frame can be chosen only for glTF; other scenes "
            "define their frames or do not move."
        )
    timed_scene: "Scene" = reader(path, timing)
    return timed_scene


DEMO = "demo"  # the scene that comes with the program, unless a file has that name


def is_scene_name(text: str) -> bool:
    """Return True if `text` names a scene rather than plates."""
    return is_demo(text) or is_scene_file(text)


def is_demo(text: str) -> bool:
    """Return True if `text` means the scene that comes with the program."""
    return text == DEMO and not os.path.exists(text)


def open_scene(text: str, timing: SceneTiming | None = None) -> "Scene":
    """Return the scene, with its seconds converted to frames; it is read only if needed.

    Raises InputError that names the file if it cannot be read, or if a timing is given for a file
    that defines its frames itself.
    """
    if is_demo(text):
        if timing is not None:
            raise InputError(
                "The demo has one clip and its own frames: leave --clip, --fps and "
                "--first-frame out."
            )
        from heatlens.media.scene.demo import demo_scene

        return demo_scene()
    return read_or_kept(Path(text), timing, read_scene, _files_named_by)


def _files_named_by(scene: "Scene") -> tuple[Path, ...]:
    """Return the files that the file of a scene names."""
    return _named_files(scene.path) if scene.named_files is None else scene.named_files
