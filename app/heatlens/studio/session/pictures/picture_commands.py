"""Save the picture to a file or copy it as soon as it is complete; a thread writes it.

A program of the operating system copies it to the clipboard.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.messages import Worker
from heatlens.core.base.paths import open_regular_file
from heatlens.core.base.system_packages import install_advice
from heatlens.core.model.lens.lens import Lens
from heatlens.media.files.marks import blurred_mark
from heatlens.media.files.picture_formats import format_of, suffixes_written
from heatlens.media.plate.picture.picture_write import (
    check_output,
    convert_to_display_values,
    write_display_values,
    write_picture,
)
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.scene.scene_read import files_of_scene
from heatlens.render.display.display_values import DisplayValues
from heatlens.render.gpu.textures import download
from heatlens.render.preview.shown import ShownPicture
from heatlens.studio.session.pictures.live_picture import LivePicture
from heatlens.studio.session.pictures.picture_view import PictureDisplay
from heatlens.studio.session.shared import Commands, Shared

_TIMEOUT_S = 20.0
CLIPBOARD_SUFFIX = ".png"


@dataclass(frozen=True)
class Tool:
    """A program that puts a PNG on the clipboard."""

    argv: tuple[str, ...]
    reads_stdin: bool = False  # the picture; otherwise `argv` names its file


def clipboard_tools(path: Path, platform: str, environ: Mapping[str, str]) -> tuple[Tool, ...]:
    """Return the tools that may work on `platform` (as sys.platform), the likeliest first."""
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
    linux_tools = ((wayland, "WAYLAND_DISPLAY"), (x11, "DISPLAY"))
    return tuple(tool for tool, variable in linux_tools if environ.get(variable))


def copy_png(
    path: Path, platform: str, environ: Mapping[str, str], which: Callable[[str], str | None]
) -> None:
    """Put the PNG at `path` on the clipboard; `which` finds programs, as shutil.which does.

    Raises InputError with what to install, or with the output of the tool.
    """
    usable_tools = [
        tool for tool in clipboard_tools(path, platform, environ) if which(tool.argv[0])
    ]
    if not usable_tools:
        raise InputError(_missing_tool_message(platform, environ))
    problems = []
    for tool in usable_tools:
        problem = _run_tool(tool, path)
        if not problem:
            return
        problems.append(problem)
    raise InputError(f"The picture was not copied: {problems[0]}")


def _run_tool(tool: Tool, path: Path) -> str:
    """Run a tool. Return "" if it worked, otherwise a message with the problem.

    The tools keep running to serve the clipboard, and keep inherited pipes open. Their output
    therefore goes to a file: a pipe would never end.
    """
    with tempfile.TemporaryFile() as output_file, open_regular_file(path) as picture:
        stdin = picture if tool.reads_stdin else subprocess.DEVNULL
        try:
            process = subprocess.run(
                tool.argv,
                stdin=stdin,
                stdout=output_file,
                stderr=output_file,
                timeout=_TIMEOUT_S,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"{tool.argv[0]}: {error}."
        output_file.seek(0)
        output = output_file.read().decode(errors="replace").strip()
    return (
        f"{tool.argv[0]}: {output or f'exit code {process.returncode}'}"
        if process.returncode
        else ""
    )


def _missing_tool_message(platform: str, environ: Mapping[str, str]) -> str:
    """Return the message about the tool that has to be installed."""
    if platform == "darwin":
        return "The picture was not copied: macOS's osascript is not in PATH."
    if platform == "win32":
        return "The picture was not copied: Windows's powershell is not in PATH."
    if environ.get("WAYLAND_DISPLAY"):
        return f"The picture was not copied: {install_advice('wl-clipboard')}."
    if environ.get("DISPLAY"):
        return f"The picture was not copied: {install_advice('xclip')}."
    return "The picture was not copied: there is no desktop here that has a clipboard."


@dataclass(frozen=True)
class _Request:
    """The requested picture and its destination: a file, or None for the clipboard."""

    source: str | None
    frame: int
    path: Path | None

    @property
    def words(self) -> str:
        return "copying it" if self.path is None else f"saving {self.path.name}"


class PictureCommands(Commands, Worker):
    """Saves or copies one picture at a time, with the look that the screen gives it."""

    def __init__(self, shared: Shared, display: PictureDisplay, live: LivePicture) -> None:
        super().__init__(shared)
        self._display = display
        self._live = live
        self._request: _Request | None = None
        self._writer: Background[str] = Background(self._wake)

    @property
    def is_busy(self) -> bool:
        """True while a picture is awaited or written."""
        return self._request is not None or self._writer.is_busy

    def copy(self) -> None:
        """Put the picture on the clipboard once it is complete, and notify the user."""
        if self._source.plate is None:
            self._notify("Nothing is open to copy.")
        else:
            self.save(None)

    def save(self, path: Path | None) -> None:
        """Write the picture of the frame to `path` once it is complete; None copies it."""
        if self._writer.is_busy:
            self._notify("The previous picture is still being written: try again in a moment.")
            return
        self._request = _Request(self._editing.shot.source, self._editing.frame, path)
        self._notify(f"Waiting for the whole picture before {self._request.words} ...")

    def poll(self) -> None:
        """Begin to write a requested picture once it is whole; report how writing ended."""
        request, current = self._request, (self._editing.seen_shot.source, self._editing.frame)
        if request is not None and (request.source, request.frame) != current:
            self._request = None
            self._notify(
                f"The frame changed before its picture was complete: {request.words} was cancelled."
            )
        elif request is not None and (picture := self._whole_picture()) is not None:
            self._request = None
            self._notify(f"{request.words.capitalize()} ...")
            self._begin_writing(picture, request.path)
        try:
            message = self._writer.poll()
        except HeatlensError as error:
            message = str(error)
        if message is not None:
            self._notify(message)

    def _whole_picture(self) -> ShownPicture | None:
        """Return the complete picture of the current frame; None until it is rendered."""
        picture, source, frame = self._live.output, self._source, self._editing.frame
        if source.plate is None or not (source.feed.is_whole and source.is_settled_at(frame)):
            return None
        cache = None if source.opened is None else source.opened.cache
        if cache is not None and source.plate.path != cache.sequence.resolve(frame):
            return None  # the plate of the frame is still being read
        shot_and_frame = (self._editing.seen_shot, frame)
        is_current = picture is not None and (picture.shot, picture.frame) == shot_and_frame
        return picture if is_current and not self._live.is_working else None

    def _begin_writing(self, picture: ShownPicture, path: Path | None) -> None:
        """Begin to write or copy a complete picture on the thread."""
        plate = self._source.plate
        assert plate is not None  # the picture is whole
        self._writer.start(
            partial(write_or_copy, take_snapshot(picture, plate, self._display_values, path), path)
        )

    def _display_values(self) -> DisplayValues:
        return self._display.values(self._live.device)

    def close(self) -> None:
        """Wait until a file that is being written is finished."""
        self._writer.wait()


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A complete picture, the same as from `heatlens render`.

    display_values  what the window shows, for every file but an EXR
    """

    pixels: FloatImage
    plate: Plate
    lens: Lens
    proxy: float
    display_values: FloatImage | None


def take_snapshot(
    picture: ShownPicture, plate: Plate, make_values: Callable[[], DisplayValues], path: Path | None
) -> Snapshot:
    """Read the picture back for `path`, or the clipboard; call this on the thread of OpenGL."""
    shot = picture.shot
    pixels, proxy, lens = download(picture.texture), shot.defocus.proxy, shot.lens_at(picture.frame)
    file_name = path or Path(f"clipboard{CLIPBOARD_SUFFIX}")
    if format_of(file_name) is None or file_name.suffix.lower() not in suffixes_written():
        return Snapshot(pixels, plate, lens, proxy, None)
    values = make_values()
    try:
        display_values = convert_to_display_values(pixels, plate, proxy, values.encode, file_name)
    finally:
        values.release()
    return Snapshot(pixels, plate, lens, proxy, display_values)


def write_or_copy(picture: Snapshot, path: Path | None) -> str:
    """Write the picture to `path`, or copy it if None; on a thread. Return the message."""
    if path is None:
        _copy_to_clipboard(picture)
        return "The picture is on the clipboard."
    check_output(path, *_source_files(picture.plate.path))
    _write_file(picture, path)
    return f"Saved {path}."


def _source_files(path: Path) -> tuple[Path, ...]:
    """Return the files of a plate or a scene, with the files that it refers to."""
    try:
        return files_of_scene(path)
    except InputError:  # deleted or rewritten since it was read: its other files are unknown now
        return (path,)


def _write_file(picture: Snapshot, path: Path) -> None:
    """Write a complete picture to a file, scene-linear or as the window shows it."""
    if picture.display_values is None:
        write_picture(path, picture.pixels, picture.plate, picture.lens, picture.proxy)
    else:
        write_display_values(path, picture.display_values, blurred_mark(is_blurred=True))


def _copy_to_clipboard(picture: Snapshot) -> None:
    """Put a complete picture on the clipboard."""
    with tempfile.TemporaryDirectory(prefix="heatlens-") as folder:
        path = Path(folder) / f"picture{CLIPBOARD_SUFFIX}"
        _write_file(picture, path)
        copy_png(path, sys.platform, os.environ, shutil.which)
