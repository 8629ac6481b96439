"""A library that ends the process which uses it, as one in C may with a damaged file."""

from pathlib import Path


def crashing(folder: Path, name: str) -> Path:
    """Write a library that can be imported and crashes; return the folder to find it in."""
    found = folder / "libraries"
    found.mkdir()
    text = "import os\ndef __getattr__(name):\n    if not name.startswith('__'): os.abort()\n"
    (found / f"{name}.py").write_text(text)
    return found
