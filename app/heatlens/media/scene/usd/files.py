"""The files that a USD stage names, as OpenUSD follows them."""

from pathlib import Path

from heatlens.core.base.paths import unreadable_error
from heatlens.media.files.quiet import quiet_library
from heatlens.media.files.usd_library import read_usd_in_process, report_usd_failures, usd_module


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
