"""Add heatlens to the desktop of this user, so that a double click opens its files; or remove it.

Desktops of Linux read three files in the user's data folder: a desktop file, an icon, and the types
of files. Nothing else on the machine is changed.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.own_command import own_command
from heatlens.core.base.paths import home_dir
from heatlens.media.documents.reel_file import REEL_SUFFIX
from heatlens.media.documents.shot_file import SHOT_SUFFIX
from heatlens.media.files.atomic_file import write_atomically
from heatlens.studio.ui.icon import icon_svg

# type -> ending of the names, and what a file manager calls such a file
_TYPES = {
    "application/x-heatlens-shot": (SHOT_SUFFIX, "heatlens shot"),
    "application/x-heatlens-reel": (REEL_SUFFIX, "heatlens reel"),
}
_OPENED_TOO = ("image/x-exr",)  # offered under "Open with"; another program may stay the usual one
_DESKTOP_FILE = """\
[Desktop Entry]
Type=Application
Name=heatlens
GenericName=Depth of field
Comment=Put a real lens in front of a pinhole render or a 3D scene
Exec={command} %f
Icon=heatlens
Categories=Graphics;3DGraphics;
MimeType={types};
StartupWMClass=heatlens
Terminal=false
"""
# Of two patterns that fit a name, desktops take the longer one: *.heatlens.json before *.json.
_MIME_FILE = """\
<?xml version="1.0" encoding="UTF-8"?>
<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">
{types}
</mime-info>
"""
_MIME_TYPE = """\
  <mime-type type="{name}">
    <comment>{comment}</comment>
    <sub-class-of type="application/json"/>
    <icon name="heatlens"/>
    <glob pattern="*{suffix}"/>
  </mime-type>"""


def install() -> str:
    """Write the files; return what was done. Raises InputError on systems other than Linux."""
    data_home = _data_home()
    for path, content in _files(data_home).items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, content)
    _update_databases(data_home)
    return f"heatlens is on the desktop of this user: three files in {data_home}."


def uninstall() -> str:
    """Remove the files; return what was done. Raises InputError on systems other than Linux."""
    data_home = _data_home()
    removed = [path for path in _files(data_home) if path.is_file()]
    for path in removed:
        path.unlink()
    _update_databases(data_home)
    return f"{len(removed)} files of heatlens were removed from {data_home}."


def _data_home() -> Path:
    """Return the data folder of the user. Raises InputError on systems other than Linux."""
    if not sys.platform.startswith("linux"):
        raise InputError("Desktop files are for Linux. Pin heatlens in the menu of this system.")
    named = Path(os.environ.get("XDG_DATA_HOME", ""))
    return named if named.is_absolute() else home_dir() / ".local" / "share"


def _files(data_home: Path) -> dict[Path, bytes]:
    """Return the files with their contents."""
    command = " ".join(map(_exec_word, own_command("view")))
    types = ";".join((*_TYPES, *_OPENED_TOO))
    mime_types = "\n".join(
        _MIME_TYPE.format(name=name, comment=comment, suffix=suffix)
        for name, (suffix, comment) in _TYPES.items()
    )
    return {
        data_home / "applications" / "heatlens.desktop": _DESKTOP_FILE.format(
            command=command, types=types
        ).encode(),
        data_home / "icons/hicolor/scalable/apps" / "heatlens.svg": icon_svg(),
        data_home / "mime/packages" / "heatlens.xml": _MIME_FILE.format(types=mime_types).encode(),
    }


def _exec_word(word: str) -> str:
    """Return a word of a command as a desktop file writes it: in quotes, two levels of escapes."""
    word = word.replace("%", "%%")
    if re.fullmatch(r"[\w%./-]+", word):
        return word
    quoted_word = re.sub(r'(["`$\\])', r"\\\1", word)
    return '"' + quoted_word.replace("\\", "\\\\") + '"'


def _update_databases(data_home: Path) -> None:
    """Let the desktop read its files again, where the programs that do that are installed."""
    for program, folder in (
        ("update-mime-database", "mime"),
        ("update-desktop-database", "applications"),
    ):
        if (found := shutil.which(program)) and (data_home / folder).is_dir():
            subprocess.run([found, str(data_home / folder)], capture_output=True, check=False)
