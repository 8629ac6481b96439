"""OpenGL for callers from Python: started by the first picture, and kept."""

import threading

from heatlens.defocus.solver_choice import settled_solver
from heatlens.errors import GpuError
from heatlens.gpu.context import headless_context
from heatlens.plate.plate import Plate
from heatlens.render import FrameRenderer
from heatlens.scene.scene import Scene


class Engine:
    """OpenGL of this process: started once, and told what is loaded already."""

    def __init__(self) -> None:
        self._renderer: FrameRenderer | None = None
        self._thread = 0
        self._loaded: tuple[object, object] | None = None

    def renderer(self) -> FrameRenderer:
        """Return the renderer with its context current.

        Raises GpuError from another thread than the first, and without OpenGL.
        """
        if self._renderer is None:
            ctx = headless_context()
            self._renderer = FrameRenderer(ctx, settled_solver(ctx))
            self._thread = threading.get_ident()
        if threading.get_ident() != self._thread:
            raise GpuError(
                "heatlens draws in the thread that rendered first. Render there, or use processes."
            )
        self._renderer.ctx.__enter__()  # type: ignore[no-untyped-call]
        return self._renderer

    def load(self, source: object, content: Plate | Scene) -> None:
        """Take a plate or a scene to the GPU, unless it lies there."""
        renderer = self._renderer
        assert renderer is not None
        if self._loaded is not None and self._loaded[1] is content:
            return
        self._loaded = None
        if isinstance(content, Plate):
            renderer.load(content)
        else:
            renderer.load_scene(content)
        self._loaded = (source, content)

    def forget(self, source: object) -> None:
        """Let go of what `source` holds."""
        if self._loaded is not None and self._loaded[0] is source:
            self._loaded = None


ENGINE = Engine()
