"""A renderer without a GPU: it takes plates, and its pictures hold nothing but their size."""

from collections.abc import Iterator
from types import SimpleNamespace

from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.plate_passes import proxy_size

STEPS = 3  # that a picture takes


class FakeContext:
    """The part of a device that the session asks for, without OpenGL."""

    def __init__(self) -> None:
        self.name, self.is_software = "llvmpipe", True

    def finish(self) -> None:
        """Do nothing, because all is done."""


class FakeRenderer:
    """Stands in for FrameRenderer where plates are looked at, and writes down what it was asked."""

    def __init__(self) -> None:
        self.ctx = FakeContext()
        self.scene = None
        self.has_many_views = False
        self.rendered: list[tuple[Shot, int]] = []  # finished pictures
        self._loaded: SimpleNamespace | None = None

    @property
    def loaded(self) -> SimpleNamespace:
        """Return the plate as it would lie on the GPU."""
        assert self._loaded is not None
        return self._loaded

    def load(self, plate: Plate) -> None:
        """Take a plate."""
        window = plate.data_window
        color = SimpleNamespace(size=(window.width, window.height))
        self._loaded = SimpleNamespace(plate=plate, bins=plate.bins, color=color)

    def steps(self, shot: Shot, frame: int, slot: int) -> Iterator[None]:
        """Render a picture in a few steps; it ends with the texture, as the renderer's do."""
        for _ in range(STEPS):
            yield
        self.rendered.append((shot, frame))
        return SimpleNamespace(size=proxy_size(self.loaded.color.size, shot.defocus.proxy))
