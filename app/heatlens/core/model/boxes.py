"""Half-open integer boxes: windows and regions of a picture in memory."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Box:
    """Pixels x0 <= x < x1, y0 <= y < y1; y grows downwards. Coordinates may be negative.

    A box without pixels, with a width or height of zero or less, is valid: a damaged header can
    hold one, and its reader decides how to report it.
    """

    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def width(self) -> int:
        """Pixels across."""
        return self.x1 - self.x0

    @property
    def height(self) -> int:
        """Pixels down."""
        return self.y1 - self.y0

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width), as NumPy orders them."""
        return self.height, self.width

    @property
    def corners(self) -> tuple[int, int, int, int]:
        """(x0, y0, x1, y1), half-open."""
        return self.x0, self.y0, self.x1, self.y1

    @property
    def corner(self) -> tuple[int, int]:
        """(x, y) of the first pixel."""
        return self.x0, self.y0

    @property
    def slices(self) -> tuple[slice, slice]:
        """The rows and columns of an array whose first pixel is at (0, 0)."""
        return slice(self.y0, self.y1), slice(self.x0, self.x1)

    @property
    def is_empty(self) -> bool:
        """True if there is no pixel inside."""
        return self.width <= 0 or self.height <= 0

    def contains(self, x: float, y: float) -> bool:
        """Return True for a point inside; the first edge counts as inside, the last does not."""
        return self.x0 <= x < self.x1 and self.y0 <= y < self.y1

    def relative_to(self, window: "Box") -> "Box":
        """Return the same pixels, counted from the first pixel of `window`."""
        return Box(
            self.x0 - window.x0, self.y0 - window.y0, self.x1 - window.x0, self.y1 - window.y0
        )

    def intersection(self, other: "Box") -> "Box":
        """Return the pixels in both; its width or height is 0 if they do not meet."""
        x0, y0 = max(self.x0, other.x0), max(self.y0, other.y0)
        x1, y1 = min(self.x1, other.x1), min(self.y1, other.y1)
        return Box(x0, y0, max(x0, x1), max(y0, y1))

    def union(self, other: "Box") -> "Box":
        """Return the smallest box around both; neither may be empty."""
        x0, y0 = min(self.x0, other.x0), min(self.y0, other.y0)
        return Box(x0, y0, max(self.x1, other.x1), max(self.y1, other.y1))
