"""How far a picture has come, on a terminal: one line that is rewritten and then wiped."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from heatlens.commands.export_progress import time_text
from heatlens.commands.say import shows_progress
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer

_SILENT_S = 1.0  # a picture that is done sooner needs no news
_WIPE = "\r\x1b[K"


@contextmanager
def layer_progress(renderer: FrameRenderer, stream: TextIO | None = None) -> Iterator[None]:
    """Say on `stream` (stderr) which layer is worked on; nothing if it is no terminal."""
    out = stream or sys.stderr
    if not shows_progress(out):
        yield
        return
    start = time.perf_counter()

    def tell(done: int, layers: int) -> None:
        if time.perf_counter() - start > _SILENT_S:
            out.write(f"{_WIPE}heatlens: layer {done + 1} of {layers}")
            out.flush()

    renderer.listen(tell)
    try:
        yield
    finally:
        renderer.listen(None)
        out.write(_WIPE)
        out.flush()


@contextmanager
def view_progress(shot: Shot, stream: TextIO | None = None) -> Iterator[Callable[[str], None]]:
    """What is to be told each step of a picture, and says how many views of a scene are done."""
    out = stream or sys.stderr
    if not (shows_progress(out) and shot.defocus.method.needs_scene):
        yield lambda _: None
        return
    start, done = time.perf_counter(), 0

    def tell(name: str) -> None:
        nonlocal done
        done += name in ("view", "rays")
        seconds = time.perf_counter() - start
        if done and seconds > _SILENT_S:
            views = max(shot.defocus.views, done)
            left = time_text(seconds / done * (views - done))
            out.write(f"{_WIPE}heatlens: view {done} of {views}, {left} left")
            out.flush()

    try:
        yield tell
    finally:
        out.write(_WIPE)
        out.flush()
