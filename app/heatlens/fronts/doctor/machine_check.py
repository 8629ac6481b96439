"""Check the machine, the packages, and whether a second start finds its shaders compiled.

Fonts and display are checked for the window, which needs them besides OpenGL.
"""

import importlib.metadata
import os
import platform
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import heatlens
from heatlens.core.base.errors import GpuError, MissingPackageError
from heatlens.core.base.extras import extra, import_module_safely, parts
from heatlens.core.base.memory import total_memory_bytes
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.own_command import module_command, own_command
from heatlens.core.base.paths import data_dir
from heatlens.core.base.stopping import temporary_folder
from heatlens.core.model.boxes import Box
from heatlens.fronts.doctor.finding import Finding
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_write import write_exr

MOST_NEW_SHARE = (
    0.05  # bytes that a second start may add to the cache, as a share of those of the first
)
# The variables of Mesa and NVIDIA.
_CACHE_VARIABLES = ("MESA_SHADER_CACHE_DIR", "__GL_SHADER_DISK_CACHE_PATH")
_WINDOW_TIMEOUT_S = 60.0


def system() -> Iterator[Finding]:
    """Report program, Python, operating system, processor and memory."""
    details = {
        "heatlens": heatlens.__version__,
        "python": platform.python_version(),
        "system": _system_name(),
        "processors": os.cpu_count(),
        "memory_gb": None if (total := total_memory_bytes()) is None else round(total / 1e9, 1),
    }
    message = (
        f"heatlens {details['heatlens']}, Python {details['python']}, {details['system']}, "
        f"{details['processors']} processors, {details['memory_gb']} GB"
    )
    yield Finding(name="machine", state="ok", said=message, details=details)


def packages() -> Iterator[Finding]:
    """Report the version of every package, or why it cannot be imported."""
    versions: dict[str, str] = {}
    for part in parts():
        for name, module in part.packages.items():
            reason = _import_error(module)
            if reason is None:
                versions[name] = _version(name)
                continue
            message = (
                f"{name} cannot be imported ({reason}). {part.gives} needs it: "
                f"{part.install_command(name)}"
            )
            yield Finding("packages", "note" if part.name else "fault", message, {"missing": name})
    version_texts = ", ".join(f"{name} {version}" for name, version in versions.items())
    yield Finding(name="packages", state="ok", said=version_texts, details=versions)


def files() -> Iterator[Finding]:
    """Write an EXR, read it again and compare every value."""
    values = np.linspace(-4.0, 4.0, 12, dtype=np.float32).reshape(3, 4)
    window = Box(0, 0, 4, 3)
    with temporary_folder() as folder:
        path = folder / "doctor.exr"
        write_exr(path, {"Z": values}, window, window)
        ((_, channels),) = read_parts(path)
    is_equal = np.array_equal(channels["Z"], values)
    message = "written and read again" if is_equal else "the data read differ from the data written"
    yield Finding(name="EXR", state="ok" if is_equal else "fault", said=message)


def _import_error(module: str) -> str | None:
    """Return why `module` cannot be imported, or None where it can."""
    try:
        import_module_safely(module)
    except Exception as error:  # a library that lacks another may raise anything
        return str(error) or type(error).__name__
    return None


def _version(distribution: str) -> str:
    """Return the version of an installed distribution, in words if it states none."""
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return "of unknown version"


def _system_name() -> str:
    """Return the operating system, its kernel and the processor's architecture."""
    try:
        name = platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        name = platform.system()
    return f"{name}, kernel {platform.release()}, {platform.machine()}"


def second_start() -> Iterator[Finding]:
    """Report the share of the shader cache that a second start has to compile again."""
    # The driver's cache is useless if the text of a shader changes from start to start, for example
    # in the order of its #defines. Nothing else shows that: a second command took 4.0 s, not 1.3.
    with tempfile.TemporaryDirectory(prefix="heatlens-") as folder:
        first = _shader_cache_bytes(Path(folder))
        second = _shader_cache_bytes(Path(folder)) if first else 0
    new_share = (second - first) / first if first else 1.0
    message = f"finds {100 * (1 - new_share):.0f} % of its shaders compiled by the first"
    if not first:
        message = (
            "compiles every shader again: the driver has no shader cache, or keeps it elsewhere"
        )
    details = {"kept_bytes": first, "share_new": new_share}
    yield Finding("second start", "ok" if new_share <= MOST_NEW_SHARE else "note", message, details)


def _shader_cache_bytes(folder: Path) -> int:
    """Render the still life in a process of its own; return the size of the driver's cache."""
    cache = folder / "cache"
    cache.mkdir(exist_ok=True)  # NVIDIA's driver keeps nothing in a folder that does not exist
    plate, picture = data_dir("assets") / "still_life.exr", folder / "picture.exr"
    command = own_command("render", str(plate), "-o", str(picture))
    environment = os.environ | dict.fromkeys(_CACHE_VARIABLES, str(cache))
    process = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if process.returncode != 0:
        raise GpuError(
            f"`heatlens render`, started as a process, failed: {one_line(process.stderr, 400)}"
        )
    return sum(path.stat().st_size for path in cache.rglob("*") if path.is_file())


def fonts() -> Iterator[Finding]:
    """Look for the fonts that come with the library of the window."""
    try:
        with extra("gui").require():
            from heatlens.studio.ui.window_try import check_fonts
    except MissingPackageError as error:
        yield Finding(name="fonts", state="note", said=str(error))
        return
    yield Finding(name="fonts", state="ok", said=check_fonts())


def display() -> Iterator[Finding]:
    """Open an invisible window, and close it again."""
    try:
        with extra("gui").require():
            from heatlens.studio.ui import window_try
    except MissingPackageError as error:
        yield Finding(name="display", state="note", said=str(error))
        return
    display_name = window_try.display_variable()
    if display_name is None:
        yield Finding("display", "note", "none here; `heatlens render` works without")
        return
    details = {"display": display_name, "renderer": _window_renderer(window_try.__name__)}
    yield Finding("display", "ok", f"{display_name}, drawn by {details['renderer']}", details)


def _window_renderer(module: str) -> str:
    """Return the OpenGL renderer of a window in a separate process. Raises GpuError if that fails.

    X kills a process on errors, and with Mesa no window can draw on a thread that also has a
    context without a window.
    """
    command = module_command(module)
    try:
        process = subprocess.run(command, capture_output=True, text=True, timeout=_WINDOW_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise GpuError(
            f"No window opened within {_WINDOW_TIMEOUT_S:g} s: is the display reachable, and not "
            "locked?"
        ) from None
    if process.returncode:
        reason = " ".join(process.stderr.split()) or f"exit code {process.returncode}"
        raise GpuError(f"No window can be opened: {reason}")
    return process.stdout.strip()
