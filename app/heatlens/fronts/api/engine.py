"""The GPU for the Python interface: opened with the first picture, then kept."""

import os
import sys
import threading
from collections.abc import Callable
from typing import TypeVar

from heatlens.core.base.errors import GpuError
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer

Content = TypeVar("Content")


class Engine:
    """The renderer of this process, and the content that is loaded into it."""

    def __init__(self) -> None:
        self._renderer: FrameRenderer | None = None
        self._thread = 0
        self._loaded: tuple[object, object] | None = None
        self._is_forked = False
        if sys.platform != "win32":  # Windows has no fork
            os.register_at_fork(after_in_child=self._note_fork)

    def _note_fork(self) -> None:
        """Note in a child that the renderer of its parent cannot be used: its threads are gone."""
        # Rendering in such a process does not fail by itself: it waits for ever.
        self._is_forked = self._renderer is not None

    def renderer(self) -> FrameRenderer:
        """Return the renderer with its context current.

        Raises GpuError in every thread but the first, after a fork, and where nothing can draw.
        """
        if self._is_forked:
            raise GpuError(
                "this process was forked from one in which heatlens has drawn already, and its "
                "renderer does not outlive a fork. Start processes with "
                'multiprocessing.get_context("spawn").'
            )
        if self._renderer is None:
            self._renderer = headless_renderer()
            self._thread = threading.get_ident()
        if threading.get_ident() != self._thread:
            raise GpuError(
                "heatlens draws in the thread that rendered first. Render there, or use processes."
            )
        self._renderer.ctx.make_current()
        return self._renderer

    def load(
        self, owner: object, content: Content, load_content: Callable[[Content], None]
    ) -> None:
        """Load `content` into the renderer for `owner` with `load_content`, unless it is loaded."""
        if self._loaded is not None and self._loaded[1] is content:
            return
        self._loaded = None
        load_content(content)
        self._loaded = (owner, content)

    def unload_all(self) -> None:
        """Forget what is loaded, because other work loads content of its own."""
        self._loaded = None

    def unload(self, owner: object) -> None:
        """Forget the content that `owner` has loaded."""
        if self._loaded is not None and self._loaded[0] is owner:
            self._loaded = None


ENGINE = Engine()
