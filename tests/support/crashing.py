"""A library that aborts the process which uses it, as a C library may with a damaged file."""

from pathlib import Path


def write_crashing_library(folder: Path, name: str) -> Path:
    """Write a library that can be imported and crashes; return the folder to find it in."""
    libraries = folder / "libraries"
    libraries.mkdir()
    text = "import os\ndef __getattr__(name):\n    if not name.startswith('__'): os.abort()\n"
    (libraries / f"{name}.py").write_text(text)
    return libraries
