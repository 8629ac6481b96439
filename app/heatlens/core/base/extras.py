"""Import on first use: packages that may be missing, and modules that few commands need.

Each optional part of heatlens is one record here, and an extra of the same name in pyproject.toml.
"""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any

from heatlens.core.base.errors import MissingPackageError
from heatlens.core.base.own_command import is_frozen
from heatlens.core.base.system_packages import opengl_advice, quoted


@dataclass(frozen=True)
class Extra:
    """A part of heatlens that works where its packages are installed.

    name      the extra of pyproject.toml; "" for the packages that every installation has
    gives     what is not there without it: begins a sentence
    packages  what pip calls each package -> the module that Python imports
    brings    other extras that it installs
    besides   what else is installed with it: ends a sentence
    is_drawn  it needs OpenGL, which comes from the system
    """

    name: str
    gives: str
    packages: Mapping[str, str]
    brings: tuple[str, ...] = ()
    besides: str = ""
    is_drawn: bool = False

    def install_command(self, package: str = "") -> str:
        """Return the command that installs the extra, or a package that is no part of one."""
        packages = quoted(f"heatlens[{self.name}]") if self.name else package
        opengl = f". {opengl_advice()}" if self.is_drawn else ""
        return f"pip install {packages}{self.besides if self.name else ''}{opengl}"

    @contextmanager
    def require(self, purpose: str = "", package: str = "") -> Iterator[None]:
        """Raise MissingPackageError, which begins with `purpose`, for an ImportError inside."""
        try:
            yield
        except ImportError as error:
            package_note = f"the package {package}, which cannot be imported"
            advice = (
                "This folder was made without it; install heatlens" if is_frozen() else "Install it"
            )
            raise MissingPackageError(
                f"{purpose or self.gives} needs "
                f"{package_note if package else 'more than is installed'} "
                f"({error}). {advice} with: {self.install_command(package)}"
            ) from error

    def check(self) -> None:
        """Look for all packages, those of other extras too. Raises MissingPackageError."""
        for part in (self, *map(extra, self.brings)):
            for package, module in part.packages.items():
                with self.require(package=package):
                    if find_spec(module) is None:
                        raise ModuleNotFoundError(f"No module named {module!r}")


BASE = Extra(
    name="",
    gives="heatlens",
    packages={
        "fileseq": "fileseq",
        "jinja2": "jinja2",
        "mmh3": "mmh3",
        "moderngl": "moderngl",
        "numpy": "numpy",
        "opencolorio": "PyOpenColorIO",
        "OpenEXR": "OpenEXR",
        "pillow": "PIL",
        "platformdirs": "platformdirs",
        "shtab": "shtab",
    },
)
_EDIT = {
    "asc-fdl": "fdl",
    "opentimelineio": "opentimelineio",
    "otio-aaf-adapter": "otio_aaf_adapter",
    "otio-cmx3600-adapter": "otio_cmx3600_adapter",
    "otio-fcp-adapter": "otio_fcp_adapter",
}
_SCENE = {
    "DracoPy": "DracoPy",
    "charset-normalizer": "charset_normalizer",
    "meshopt": "meshopt",
    "opengl_basisu": "opengl_basisu",
    "trimesh": "trimesh",
}
_RING = {"cbor2": "cbor2", "mido": "mido", "python-osc": "pythonosc"}
_MIDI = "; MIDI also needs python-rtmidi, and the sound library of the system"
EXTRAS = (
    Extra(name="cluster", gives="A cluster", packages={"distributed": "distributed"}),
    Extra(name="compare", gives="FLIP", packages={"flip-evaluator": "flip_evaluator"}),
    Extra(name="edit", gives="An edit", packages=_EDIT),
    Extra(name="estimate", gives="Estimating depth", packages={"onnxruntime": "onnxruntime"}),
    Extra("gui", "The window", {"glfw": "glfw", "imgui-bundle": "imgui_bundle"}, is_drawn=True),
    Extra(name="heic", gives="HEIC", packages={"pillow-heif": "pillow_heif"}),
    Extra(name="movie", gives="A movie", packages={"av": "av"}),
    Extra(name="pdf", gives="A PDF", packages={"weasyprint": "weasyprint"}),
    Extra("pictures", "A picture of 16 bits a channel", {"OpenImageIO": "OpenImageIO"}),
    Extra(name="plot", gives="A chart", packages={"matplotlib": "matplotlib"}),
    Extra(name="ring", gives="A focus ring", packages=_RING, besides=_MIDI),
    Extra(name="scene", gives="A mesh", packages=_SCENE),
    Extra(name="share", gives="Sharing", packages={"aiohttp": "aiohttp", "segno": "segno"}),
    Extra(name="study", gives="A study", packages={}, brings=("compare", "plot")),
    Extra(name="track", gives="Following a surface", packages={"opencv-python-headless": "cv2"}),
    Extra(name="usd", gives="USD", packages={"usd-core": "pxr"}),
    Extra(name="wgpu", gives="wgpu", packages={"wgpu": "wgpu"}),
)


def parts() -> tuple[Extra, ...]:
    """Return what every installation has, and all optional parts."""
    return (BASE, *EXTRAS)


def extra(name: str) -> Extra:
    """Return the record of an optional part."""
    return next(candidate for candidate in EXTRAS if candidate.name == name)


def import_extra(module: str, purpose: str = "") -> ModuleType:
    """Import a module of a package that may be missing, such as "flip_evaluator".

    `purpose` begins the sentence of the MissingPackageError, in place of what the extra gives.
    """
    package_module = module.partition(".")[0]
    owner, package = next(
        (owner, package)
        for owner in parts()
        for package, imported in owner.packages.items()
        if imported == package_module
    )
    with owner.require(purpose, package):
        return import_module_safely(module)


# Importing WeasyPrint sets this switch for the whole process: Pillow then fills the missing rest of
# a truncated picture with gray. After a pull sheet as PDF, half a PNG would be read as a whole one.
def import_module_safely(module: str) -> ModuleType:
    """Import a module, then make Pillow refuse truncated pictures again."""
    library = import_module(module)
    if (files := sys.modules.get("PIL.ImageFile")) is not None:
        vars(files)["LOAD_TRUNCATED_IMAGES"] = False
    return library


@dataclass(frozen=True)
class OnUse:
    """A function or class of another module, which is imported when it is called."""

    module: str
    name: str

    @property
    def target(self) -> Any:
        """The function or class itself."""
        return getattr(import_module(f"heatlens.{self.module}"), self.name)

    def __call__(self, *args: Any) -> Any:
        return self.target(*args)


def ocio() -> ModuleType:
    """Import PyOpenColorIO, without which pictures can still be shown with the sRGB curve.

    Raises MissingPackageError.
    """
    return import_extra("PyOpenColorIO", "A view transform")
