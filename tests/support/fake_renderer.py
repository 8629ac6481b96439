"""A renderer without a GPU, which accepts plates and returns pictures that have only a size."""

from collections.abc import Iterator
from types import SimpleNamespace

from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.gpu.known_programs import KnownPrograms

STEPS = 3  # steps of rendering one picture


class FakeContext:
    """The few members of a device that the session uses, without OpenGL."""

    def __init__(self) -> None:
        self.name, self.is_software = "llvmpipe", True
        self.known_programs = KnownPrograms()

    def finish(self) -> None:
        """Do nothing, as there is no GPU to wait for."""


def optics_of_widest(widest_px: float) -> SimpleNamespace:
    """Return what a choice of the first picture asks of optics whose largest disc is this wide."""
    disc = SimpleNamespace(spreads=(1.0, 1.0))
    return SimpleNamespace(nearest_px=-widest_px, farthest_px=0.0, disc=disc)


class FakeRenderer:
    """A replacement of FrameRenderer that records the rendered shots and frames."""

    def __init__(self) -> None:
        self.ctx = FakeContext()
        self.scene = None
        self.has_many_views = False
        self.rendered: list[tuple[Shot, int]] = []  # finished pictures
        self._loaded: SimpleNamespace | None = None

    @property
    def loaded(self) -> SimpleNamespace:
        """Return the loaded plate with its bins and the size of its color texture."""
        assert self._loaded is not None
        return self._loaded

    def load(self, plate: Plate) -> None:
        """Load a plate."""
        window = plate.data_window
        color = SimpleNamespace(size=(window.width, window.height))
        self._loaded = SimpleNamespace(plate=plate, bins=plate.bins, color=color)

    def optics(self, shot: Shot, frame: int) -> SimpleNamespace:
        """Return the optics of a lens that blurs nothing."""
        return optics_of_widest(0.0)

    def light_without_highlights(self, slot: int) -> None:
        """Return None: no picture has highlights."""
        return None

    def steps(self, shot: Shot, frame: int, slot: int, enlarges: bool = False) -> Iterator[None]:
        """Render a picture in `STEPS` steps; the generator returns the texture at its end."""
        for _ in range(STEPS):
            yield
        self.rendered.append((shot, frame))
        return SimpleNamespace(size=proxy_size(self.loaded.color.size, shot.defocus.proxy))
