"""The abstract type of what a device draws into, and how draws change it."""

from abc import ABC, abstractmethod
from enum import Enum, auto

from heatlens.render.gpu.resources import Area, Data, Texture


class Primitive(Enum):
    """What the vertices of a draw make up."""

    TRIANGLES = auto()
    TRIANGLE_STRIP = auto()


class Blend(Enum):
    """How a draw combines its color with the one in the framebuffer."""

    NONE = auto()
    ADD = auto()
    OVER = auto()  # composited by straight alpha; the alpha of the framebuffer stays


class DepthTest(Enum):
    """Which pixels of a draw are written, by their depth and the one in the framebuffer."""

    NONE = auto()
    LESS = auto()
    EQUAL = auto()
    AT_MOST = auto()
    ALWAYS = auto()


class Framebuffer(ABC):
    """Textures that draws write into, or a window of OpenGL.

    scissor        nothing outside of it is drawn or cleared; None for no limit
    writes_color, writes_depth  False leaves the colors or the depths as they are
    """

    size: tuple[int, int]
    viewport: Area
    scissor: Area | None
    writes_color: bool
    writes_depth: bool
    color_attachments: tuple[Texture, ...]

    @abstractmethod
    def use(self) -> None:
        """Let the next draws write into it."""

    @abstractmethod
    def clear(
        self, red: float = 0.0, green: float = 0.0, blue: float = 0.0, alpha: float = 0.0
    ) -> None:
        """Fill it with a color, and its depths with the farthest."""

    @abstractmethod
    def read(self, viewport: Area | None = None, components: int = 3, dtype: str = "f1") -> bytes:
        """Return the pixels of an area, row 0 first."""

    @abstractmethod
    def read_into(self, data: Data, components: int = 3) -> None:
        """Copy the pixels, row 0 first, into `data`."""

    @abstractmethod
    def release(self) -> None:
        """Give it back, but not its textures."""
