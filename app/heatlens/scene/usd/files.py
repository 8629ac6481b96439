"""The layers and pictures that a USD file refers to."""

from pathlib import Path
from typing import Any

from heatlens.base.paths import unreadable
from heatlens.files.quiet import quiet_library
from heatlens.files.usd_library import read_usd_apart, usd_failures_reported, usd_module


def files_of_usd(path: Path) -> tuple[Path, ...]:
    """Return files of sublayers, references, payloads and pictures as OpenUSD follows them.

    The files need not exist. Files packed in a .usdz count as the package. This runs in a process
    of its own, which takes half a second. Raises InputError if the file cannot be read.
    """
    if not path.is_file():
        raise unreadable(path)
    return read_usd_apart(named_by_usd, str(path), path)


def named_by_usd(text: str) -> tuple[Path, ...]:
    """Return what `files_of_usd` does, in this process."""
    own = Path(text).resolve()
    with quiet_library(), usd_failures_reported(text):
        layers, pictures, missing = usd_module("UsdUtils").ComputeAllDependencies(str(own))
    listed = (*(layer.realPath for layer in layers), *pictures, *missing)
    found = (Path(_file_of(name)) for name in listed)
    return tuple(dict.fromkeys(path for path in found if path.is_absolute() and path != own))


def _file_of(name: Any) -> str:
    """Return the file itself, or the package that contains it."""
    resolver = usd_module("Ar")
    is_packed = resolver.IsPackageRelativePath(name)
    return str(resolver.SplitPackageRelativePathOuter(name)[0] if is_packed else name)
