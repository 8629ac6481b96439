"""Copy a picture to the clipboard with a program of the operating system."""

import subprocess
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from heatlens.base.errors import InputError

_TIMEOUT_S = 20.0


@dataclass(frozen=True)
class Tool:
    """A program that puts a PNG on the clipboard."""

    argv: tuple[str, ...]
    reads_stdin: bool = False  # the picture; otherwise `argv` names its file


def tools(path: Path, platform: str, environ: Mapping[str, str]) -> tuple[Tool, ...]:
    """Return the tools that may work on `platform` (a value of sys.platform), likeliest first."""
    if platform == "darwin":
        quoted = str(path).replace("\\", "\\\\").replace('"', '\\"')
        script = f'set the clipboard to (read (POSIX file "{quoted}") as «class PNGf»)'
        return (Tool(("osascript", "-e", script)),)
    if platform == "win32":
        quoted = str(path).replace("'", "''")
        script = (
            "Add-Type -AssemblyName System.Windows.Forms, System.Drawing; "
            "[System.Windows.Forms.Clipboard]::SetImage("
            f"[System.Drawing.Image]::FromFile('{quoted}'))"
        )
        return (Tool(("powershell", "-NoProfile", "-STA", "-Command", script)),)
    wayland = Tool(("wl-copy", "--type", "image/png"), reads_stdin=True)
    x11 = Tool(("xclip", "-selection", "clipboard", "-t", "image/png", "-i"), reads_stdin=True)
    wanted = ((wayland, "WAYLAND_DISPLAY"), (x11, "DISPLAY"))
    return tuple(tool for tool, variable in wanted if environ.get(variable))


def copy_png(
    path: Path, platform: str, environ: Mapping[str, str], which: Callable[[str], str | None]
) -> None:
    """Put the PNG at `path` on the clipboard; `which` finds programs, as shutil.which does.

    Raises InputError saying what to install, or what the tool said.
    """
    found = [tool for tool in tools(path, platform, environ) if which(tool.argv[0])]
    if not found:
        raise InputError(_nothing_found(platform, environ))
    problems = []
    for tool in found:
        problem = _run(tool, path)
        if not problem:
            return
        problems.append(problem)
    raise InputError(f"The picture was not copied: {problems[0]}")


def _run(tool: Tool, path: Path) -> str:
    """Run a tool. Return "" if it worked, otherwise what went wrong.

    The tools keep running to serve the clipboard, and keep inherited pipes open. Their output
    therefore goes to a file: a pipe would never end.
    """
    with tempfile.TemporaryFile() as words, path.open("rb") as picture:
        stdin = picture if tool.reads_stdin else subprocess.DEVNULL
        try:
            done = subprocess.run(
                tool.argv, stdin=stdin, stdout=words, stderr=words, timeout=_TIMEOUT_S, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"{tool.argv[0]}: {error}."
        words.seek(0)
        said = words.read().decode(errors="replace").strip()
    return f"{tool.argv[0]}: {said or f'exit code {done.returncode}'}" if done.returncode else ""


def _nothing_found(platform: str, environ: Mapping[str, str]) -> str:
    if platform == "darwin":
        return "The picture was not copied: macOS's osascript is not in PATH."
    if platform == "win32":
        return "The picture was not copied: Windows's powershell is not in PATH."
    if environ.get("WAYLAND_DISPLAY"):
        return "The picture was not copied: install wl-clipboard (apt-get install wl-clipboard)."
    if environ.get("DISPLAY"):
        return "The picture was not copied: install xclip (apt-get install xclip)."
    return "The picture was not copied: there is no desktop here that has a clipboard."
