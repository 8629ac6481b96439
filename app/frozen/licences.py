"""Write down the licences of all that lies in the frozen folder."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution, distributions
from pathlib import Path

BUILDING = {"pip", "setuptools", "altgraph", "pyinstaller-hooks-contrib"}  # not in the folder
# Packages whose wheels hold libraries of others without their texts: FFmpeg (LGPL 3), x264 and x265
# (GPL 2 or later), libheif (LGPL 3). LGPL 3 adds permissions to GPL 3, so both texts are needed.
_TEXTS = {
    "av": ("GPL-2.0", "LGPL-3.0", "GPL-3.0"),
    "opencv-python-headless": ("LGPL-3.0", "GPL-3.0"),
    "pillow-heif": ("GPL-2.0", "LGPL-3.0", "GPL-3.0"),
}
_IS_LICENCE = re.compile(r"(licen[cs]e|copying|notice|authors)", re.IGNORECASE)


def packages() -> list[Distribution]:
    """Return the installed packages that the folder may hold, in the order of their names."""
    named = {it.name: it for it in distributions() if it.name not in BUILDING}
    return sorted(named.values(), key=lambda it: it.name.lower())


def licences_text(binaries: Iterable[tuple[str, str, str]], checkout: Path) -> str:
    """Return the licences of heatlens, of Python, of its packages and of libraries of the system.

    `binaries` are PyInstaller's: name in the folder, file on this machine, kind.
    """
    _, _, section = (checkout / "README.md").read_text(encoding="utf-8").partition("\n## Licence\n")
    texts = [
        ("heatlens", f"{section.strip()}\n\n{_text(checkout / 'LICENSE')}"),
        (f"Python {sys.version.split()[0]}", _python_licence()),
        *((f"{it.name} {it.version}", _licence_of(it)) for it in packages()),
        *_licences_of_system({Path(file) for _, file, _ in binaries}),
        *_texts_of_libraries({it.name for it in packages()}),
    ]
    return "\n\n".join(f"{'=' * 80}\n{title}\n{'=' * 80}\n\n{text}" for title, text in texts)


def _licence_of(distribution: Distribution) -> str:
    """Return what the metadata of a package call its licence, and its licence files."""
    metadata = distribution.metadata
    classifiers = [it for it in metadata.get_all("Classifier") or [] if it.startswith("License")]
    facts = [metadata["License-Expression"], *classifiers, metadata["License"]]
    files = [
        Path(str(file.locate()))
        for file in distribution.files or ()
        if _IS_LICENCE.match(file.name) and file.suffix not in (".py", ".pyc")
    ]
    return "\n\n".join([*filter(None, facts), *map(_text, files)])


def _python_licence() -> str:
    """Return Python's licence, which lies beside its library."""
    return _text(Path(os.__file__).with_name("LICENSE.txt"))


def _licences_of_system(files: set[Path]) -> Iterator[tuple[str, str]]:
    """Yield the packages of Debian that hold some of the files, with their copyright."""
    dpkg = shutil.which("dpkg")
    places = sorted(str(file) for file in files if str(file).startswith(("/lib", "/usr/lib")))
    if dpkg is None or not places:
        return
    found = subprocess.run([dpkg, "-S", *places], capture_output=True, text=True, check=False)
    for package in sorted({line.partition(":")[0] for line in found.stdout.splitlines()}):
        copyright_file = Path("/usr/share/doc") / package / "copyright"
        yield f"{package} (Debian)", _text(copyright_file)


def _texts_of_libraries(names: set[str]) -> Iterator[tuple[str, str]]:
    """Yield the licences of libraries that lie in the wheels of the named packages."""
    for text in sorted({text for name in names for text in _TEXTS.get(name, ())}):
        holders = ", ".join(
            name for name, texts in _TEXTS.items() if name in names and text in texts
        )
        title = f"{text.replace('-', ' ')} (libraries in {holders})"
        yield title, _text(Path(__file__).with_name("texts") / f"{text}.txt")


def _text(file: Path) -> str:
    return file.read_text(encoding="utf-8", errors="replace").strip() if file.is_file() else ""
