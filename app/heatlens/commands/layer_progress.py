"""How far a picture has come, on a terminal: one line that is rewritten and then wiped."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from heatlens.render import FrameRenderer

_SILENT_S = 1.0  # a picture that is done sooner needs no news
_WIPE = "\r\x1b[K"


@contextmanager
def layer_progress(renderer: FrameRenderer, stream: TextIO | None = None) -> Iterator[None]:
    """Say on `stream` (stderr) which layer is worked on; nothing if it is no terminal."""
    out = stream or sys.stderr
    if not out.isatty():
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
