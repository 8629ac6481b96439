"""Have another process build the programs that pictures of the open source need.

Python holds its lock while a driver compiles, so a thread would not help: the window would stand
still for up to a second a program. The process fills the driver's cache; meanwhile the window
renders what needs no new program, and afterwards each build takes a millisecond.
"""

import hashlib
import os
import pickle
import subprocess
import sys
import time
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from pathlib import Path
from threading import Thread

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Worker
from heatlens.core.base.own_command import module_command
from heatlens.core.base.paths import read_file_bytes
from heatlens.core.base.stopping import lower_priority
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.files.atomic_file import make_folder, write_atomically
from heatlens.render.gpu.device import Device
from heatlens.render.preview import build_programs
from heatlens.render.preview.build_programs import BuildRequest, pictures_to_build
from heatlens.studio.session.pictures.elsewhere import ProcessBuilder
from heatlens.studio.session.shared import Commands, Shared

if sys.platform == "win32":
    _LOW_PRIORITY = subprocess.BELOW_NORMAL_PRIORITY_CLASS
else:
    _LOW_PRIORITY = 0  # lowered once it is started
_FOLDER = "programs"
_PATIENCE_S = 30.0  # for one picture; on a busy machine programs are then built here
_MOST_PROCESSES = 20  # in one session; later programs are built here


class ProgramsFile:
    """Keeps the digests of a device's known programs in a file, one for each driver."""

    def __init__(self, folder: Path, device: Device) -> None:
        driver = f"{device.library} {device.name} {device.version}"
        self._known = device.known_programs
        self._path = folder / f"{hashlib.sha256(driver.encode()).hexdigest()[:16]}.txt"

    def load(self) -> None:
        """Add the digests of the file to the known programs; without a file, none are added."""
        with suppress(OSError):
            words = read_file_bytes(self._path).decode("ascii", "replace")
            self._known.digests.update(words.split())

    def save(self) -> None:
        """Write the digests; a folder that cannot be written to only costs time later."""
        with suppress(OSError, HeatlensError):
            make_folder(self._path.parent, parents=True)
            write_atomically(self._path, "\n".join(sorted(self._known.digests)).encode())


class ProgramBuilder(Commands, Worker, ProcessBuilder):
    """Starts the process when a picture needs a new program; without a folder it never does."""

    def __init__(self, shared: Shared, folder: Path | None) -> None:
        """Keep the digests of known programs below `folder`."""
        super().__init__(shared)
        device = self._source.picture.renderer.ctx
        self._known = device.known_programs
        self._file = None if folder is None else ProgramsFile(folder / _FOLDER, device)
        self._process: subprocess.Popen[bytes] | None = None
        self._built: set[object] = set()  # what processes were started for
        self._pictures: tuple[Shot, ...] = ()  # that the process renders
        self._done_count = 0  # of these
        self._news_at = 0.0  # the time of its start, and then of its latest picture
        if self._file is not None:
            self._file.load()

    @property
    def progress(self) -> str:
        """The pictures that the process has rendered, as "3 of 12"; "" while none runs."""
        return f"{self._done_count} of {len(self._pictures)}" if self._is_running else ""

    # The driver of a software rasterizer compiles a program anew for textures of other sizes, so
    # that a picture may still take seconds although all its programs are known.
    def is_pending(self, settings: DefocusSettings) -> bool:
        """Return True while the process has still to render a picture with these settings."""
        pending = self._pictures[self._done_count :] if self._is_running else ()
        return any(picture.defocus == settings for picture in pending)

    @property
    def _is_running(self) -> bool:
        return self._process is not None and self._process.poll() is None

    def refuse_new(self, shot: Shot) -> AbstractContextManager[None]:
        """Refuse new programs in a block, unless no process can build those of the shot."""
        opened = self._source.opened
        can_build = (
            self._file is not None
            and opened is not None
            and opened.render_source is not None
            and len(self._built) < _MOST_PROCESSES
            and (self._is_running or self._key(shot) not in self._built)
        )
        return self._known.refuse_new(can_build)

    def request(self, shot: Shot, frame: int) -> None:
        """Begin to build the programs of a shot, unless a process is at work."""
        opened = self._source.opened
        if self._is_running or opened is None or opened.render_source is None:
            return
        source = opened.render_source.with_absolute_paths()
        self._built.add(self._key(shot))
        self._done_count, self._news_at = 0, time.monotonic()
        self._pictures = pictures_to_build(self._source.picture.renderer, shot, frame)
        self._process = subprocess.Popen(
            module_command(build_programs.__name__, str(os.getpid())),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={"LP_NUM_THREADS": "1"} | os.environ,
            creationflags=_LOW_PRIORITY,
        )
        lower_priority(self._process.pid)  # at once: its start would slow that of the window
        request = pickle.dumps(BuildRequest(source, frame, self._pictures))
        Thread(target=self._follow, args=(self._process, request), daemon=True).start()

    def poll(self) -> None:
        """End a process that takes too long for a picture."""
        is_late = time.monotonic() - self._news_at > _PATIENCE_S
        if self._process is not None and self._is_running and is_late:
            self._process.kill()

    def seconds_until_needed(self) -> float | None:
        """Return the time between two looks at the process."""
        return 1.0 if self._is_running else None

    def close(self) -> None:
        """End the process, and keep what is known."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        if self._file is not None:
            self._file.save()

    def _key(self, shot: Shot) -> object:
        """Return what decides which programs are needed: the source, the settings and the lens."""
        opened = self._source.opened
        lens = replace(shot.lens, focus_distance_m=1.0, f_stop=1.0, focal_length_mm=50.0)
        return None if opened is None else opened.text, shot.defocus, lens

    def _follow(self, process: "subprocess.Popen[bytes]", request: bytes) -> None:
        """Send the request, and note what the process builds until it ends; runs on a thread."""
        assert process.stdin is not None and process.stdout is not None
        with process, suppress(BrokenPipeError):
            process.stdin.write(request)
            process.stdin.close()
            for line in process.stdout:
                self._known.digests.update(line.decode(errors="replace").split())
                self._done_count += 1
                self._note_news()
        if process.returncode == 0 and self._file is not None:
            self._file.save()
        self._note_news()

    def _note_news(self) -> None:
        """Let the pictures try again."""
        self.version, self._news_at = self.version + 1, time.monotonic()
        self._wake()
