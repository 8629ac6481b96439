"""Names that stand beside their lines and points, and clear of each other."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

SIZE_PT = 9
_LINE_PT = 1.25 * SIZE_PT
_LETTER_PT = 0.56 * SIZE_PT  # a little more than the mean width of matplotlib's own font
_PAST_LINE_PT = 14  # from the frame's right edge: room for what leads from a line to its name
_POINT_PT = 8  # half a mark, and some air


@dataclass(frozen=True, slots=True)
class Label:
    """A name for the point (x, y), in units of the axes."""

    text: str
    x: float
    y: float
    color: str


def spread(wanted: Sequence[float], gap: float) -> list[float]:
    """Places at least `gap` apart, in the order of those wanted, as near to them as can be.

    Least squares by pooling neighbours that collide: Ayer et al. 1955.
    """
    order = sorted(range(len(wanted)), key=wanted.__getitem__)
    blocks: list[list[float]] = []  # mean place of the block's first name, number of names
    for rank, at in enumerate(order):
        blocks.append([wanted[at] - gap * rank, 1])
        while len(blocks) > 1 and blocks[-2][0] >= blocks[-1][0]:
            (a, m), (b, n) = blocks[-2:]
            blocks[-2:] = [[(a * m + b * n) / (m + n), m + n]]
    flat = [place for place, count in blocks for _ in range(int(count))]
    placed = dict(zip(order, flat, strict=True))
    return [placed[at] + gap * order.index(at) for at in range(len(wanted))]


def name_lines(axes: Any, labels: Sequence[Label]) -> None:
    """Each at the right of the frame, at the height of its line's end, with a thread to it."""
    size = _settled(axes)
    ends = [_in_frame(axes, label) for label in labels]
    heights = spread([y for _, y in ends], _LINE_PT / size[1])
    for label, end, height in zip(labels, ends, heights, strict=True):
        beside = 1 + _PAST_LINE_PT / size[0]
        thread = {"transform": axes.transAxes, "color": label.color, "clip_on": False}
        xs, ys = [end[0], max(1.0, end[0]), beside], [end[1], end[1], height]
        axes.plot(xs, ys, linewidth=0.7, alpha=0.5, **thread)
        axes.text(beside, height, f" {label.text}", va="center", fontsize=SIZE_PT, **thread)


def name_points(axes: Any, labels: Sequence[Label]) -> None:
    """Each right, left, above or below its point: where it covers no point and no other name."""
    width, height = _settled(axes)
    points = [(x * width, y * height) for x, y in (_in_frame(axes, label) for label in labels)]
    boxes = [(x - 4, y - 4, x + 4, y + 4) for x, y in points]
    for label, point in zip(labels, points, strict=True):
        places = _places(point, _LETTER_PT * len(label.text))
        inside = [box for box in places if box[0] > 0 and box[2] < width and box[1] > 0]
        free = [box for box in inside if not any(_meet(box, other) for other in boxes)]
        box = (free or inside or places)[0]
        boxes.append(box)
        at = (box[0] / width, (box[1] + box[3]) / 2 / height)
        axes.text(
            *at,
            label.text,
            va="center",
            transform=axes.transAxes,
            color=label.color,
            fontsize=SIZE_PT,
            bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 0.5},
        )


Box = tuple[float, float, float, float]


def _places(point: tuple[float, float], long: float) -> list[Box]:
    """Boxes of a name around its point, the best first, in points of the page."""
    (x, y), half, off = point, _LINE_PT / 2, _POINT_PT
    middles = [(x + off, y), (x - off - long, y)]
    for away in (half + off, half + off + _LINE_PT):
        middles += [(x - long / 2, y + away), (x - long / 2, y - away)]
        middles += [(x + off, y + away), (x + off, y - away)]
    return [(left, middle - half, left + long, middle + half) for left, middle in middles]


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _settled(axes: Any) -> tuple[float, float]:
    """Width and height of the frame on the page; its limits stay what they are from now on."""
    axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim())
    box, (width, height) = axes.get_position(), axes.figure.get_size_inches()
    return 72 * width * box.width, 72 * height * box.height


def _in_frame(axes: Any, label: Label) -> tuple[float, float]:
    """Shares of the frame, from its left and its bottom."""
    x, y = axes.transAxes.inverted().transform(axes.transData.transform((label.x, label.y)))
    return float(x), float(y)
