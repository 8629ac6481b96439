"""`heatlens addon`: the add-on for Blender, as a file that Blender installs."""

import argparse
import io
import zipfile
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import data_dir, read_file_bytes
from heatlens.fronts.commands.output.say import print_result
from heatlens.media.files.atomic_file import write_atomically

DESCRIPTION = """\
Writes the add-on for Blender 4.2 and later as an extension. To install it, drop the file onto the
window of Blender, or use Edit > Preferences > Get Extensions > Install from Disk.
"""
EPILOG = """\
example:
  heatlens addon build -o heatlens_blender.zip
"""

# The name that Blender asks for -> the name of the file among the assets.
_FILES = {
    "blender_manifest.toml": "blender_manifest.toml",
    "__init__.py": "heatlens_addon.py",
    "program.py": "program.py",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("action", choices=("build",), help="write the extension")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE.zip", help="the file to write"
    )


def run(args: argparse.Namespace) -> int:
    """Write the extension. Raises InputError for a name that Blender does not take."""
    if args.output.suffix.lower() != ".zip":
        raise InputError(f"{args.output}: Blender installs extensions from files named .zip.")
    write_atomically(args.output, extension())
    print_result(f"{args.output}: drop it onto the window of Blender")
    return 0


def extension() -> bytes:
    """Return the zip file, with the same bytes every time."""
    folder = data_dir("assets") / "blender"
    with io.BytesIO() as buffer:
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, asset in _FILES.items():
                archive.writestr(zipfile.ZipInfo(name), read_file_bytes(folder / asset))
        return buffer.getvalue()
