"""Read 3D scene files with the reader for their extension; open a scene by its name."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.core.base.paths import unreadable_error
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.files.quiet import quiet_library
from heatlens.media.files.usd_library import read_usd_in_process, report_usd_failures, usd_module

if TYPE_CHECKING:  # the readers make it
    from heatlens.media.scene.scene import Scene


def files_of_usd(path: Path) -> tuple[Path, ...]:
    """Return files of sublayers, references, payloads and pictures as OpenUSD follows them.

    The files need not exist. Files packed in a .usdz count as the package. This runs in a process
    of its own, which takes half a second. Raises InputError if the file cannot be read.
    """
    if not path.is_file():
        raise unreadable_error(path)
    return read_usd_in_process(named_by_usd, str(path), path)


def named_by_usd(text: str) -> tuple[Path, ...]:
    """Return what `files_of_usd` does, in this process."""
    usd_file = Path(text).resolve()
    with quiet_library(), report_usd_failures(text):
        layers, pictures, missing = usd_module("UsdUtils").ComputeAllDependencies(str(usd_file))
    names = (*(layer.realPath for layer in layers), *pictures, *missing)
    paths = (Path(_outer_file(name)) for name in names)
    return tuple(dict.fromkeys(path for path in paths if path.is_absolute() and path != usd_file))


def _outer_file(name: object) -> str:
    """Return the file itself, or the package that contains it."""
    resolver = usd_module("Ar")
    is_packed = resolver.IsPackageRelativePath(name)
    return str(resolver.SplitPackageRelativePathOuter(name)[0] if is_packed else name)


_GLTF = OnUse("media.scene.gltf.read", "read_gltf")
_MESH = OnUse("media.scene.mesh_read", "read_mesh")
_USD = OnUse("media.scene.usd.read", "read_usd")
_GLTF_FILES = OnUse("media.scene.gltf.file", "named_files")
_READERS = {
    **dict.fromkeys((".glb", ".gltf"), _GLTF),
    **dict.fromkeys((".obj", ".ply", ".stl"), _MESH),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _USD),
}
_FILE_FINDERS: dict[str, Callable[[Path], tuple[Path, ...]]] = {
    **dict.fromkeys((".glb", ".gltf"), _GLTF_FILES),
    ".obj": OnUse("media.scene.obj_files", "files_of_obj"),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), files_of_usd),
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
    find_files = _FILE_FINDERS.get(path.suffix.lower())
    return (path,) if find_files is None else (path, *find_files(path))


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
    """Return the scene, with its seconds converted to frames; the demo is read only if needed.

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
    return read_scene(Path(text), timing)
