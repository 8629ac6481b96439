"""The layers and pictures that a USD file is made of besides itself."""

from pathlib import Path
from typing import Any

from heatlens.files.quiet import quiet_library
from heatlens.files.usd_library import read_usd_apart, usd_failures_told, usd_module
from heatlens.paths import unreadable


def files_of_usd(path: Path) -> tuple[Path, ...]:
    """Files of sublayers, references, payloads and pictures, as OpenUSD follows them, there or not.

    In a process of its own, which takes half a second. What lies within a .usdz is that file.
    Raises InputError where the file cannot be read.
    """
    if not path.is_file():
        raise unreadable(path)
    return read_usd_apart(named_by_usd, str(path), path)


def named_by_usd(text: str) -> tuple[Path, ...]:
    """`files_of_usd` in this process."""
    own = Path(text).resolve()
    with quiet_library(), usd_failures_told(text):
        layers, pictures, missing = usd_module("UsdUtils").ComputeAllDependencies(str(own))
    listed = (*(layer.realPath for layer in layers), *pictures, *missing)
    found = (Path(_file_of(name)) for name in listed)
    return tuple(dict.fromkeys(path for path in found if path.is_absolute() and path != own))


def _file_of(name: Any) -> str:
    """The package, of what is packed in one."""
    resolver = usd_module("Ar")
    is_packed = resolver.IsPackageRelativePath(name)
    return str(resolver.SplitPackageRelativePathOuter(name)[0] if is_packed else name)
