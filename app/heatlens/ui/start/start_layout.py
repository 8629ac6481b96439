"""Compute the layout of the start screen for the size of the window."""

import math
from dataclasses import dataclass

_WIDTH_EM, _MARGIN_EM = 38.0, 1.2
_ABOVE = 0.4  # share of the free height above the cards; less than half looks centred


@dataclass(frozen=True)
class _Heights:
    """The heights of the parts of the start screen, in em.

    These are the heading, a card, the gap after it, the hints, the line over the recent files and
    one recent file.
    """

    head: float
    card: float
    gap: float
    hint: float
    recent_head: float
    row: float

    def of(self, cards: int) -> float:
        """Return the height of everything but the recent files, in em."""
        return self.head + cards * (self.card + self.gap) + self.hint


_ROOMY = _Heights(5.2, 5.8, 0.6, 4.2, 1.2, 3.0)
_CLOSE = _Heights(3.6, 3.4, 0.4, 2.4, 0.6, 2.7)
_ROOMY_FROM_EM = 42.0


@dataclass(frozen=True)
class Band:
    """A horizontal strip of the screen that begins at `y`."""

    y: float
    height: float

    @property
    def end(self) -> float:
        """The y position of its lower edge."""
        return self.y + self.height


@dataclass(frozen=True)
class StartLayout:
    """The layout of the start screen, in screen units from the corner of the available area.

    x, width  of all parts
    head      the name of the program and a line under it
    cards     `fixed` permanent cards, then as many recent files as fit
    hint      the hint under the permanent cards; `is_roomy` gives it two lines
    """

    x: float
    width: float
    head: Band
    cards: tuple[Band, ...]
    fixed: int
    hint: Band
    is_roomy: bool


def lay_out(cards: int, recent: int, room: tuple[float, float], em: float) -> StartLayout:
    """Lay out `cards` permanent cards and up to `recent` files; `room` and `em` in screen units.

    If the area is too small for the permanent cards, the last ones extend beyond it.
    """
    width, height = room[0] / em, room[1] / em
    is_roomy = height >= _ROOMY_FROM_EM
    sizes = _ROOMY if is_roomy else _CLOSE
    left = height - 2 * _MARGIN_EM - sizes.of(cards)
    rows = min(recent, max(math.floor((left - sizes.recent_head) / sizes.row), 0))
    left -= rows * sizes.row + (sizes.recent_head if rows else 0.0)
    top = _MARGIN_EM + max(left * _ABOVE, 0.0)
    wide = min(max(width - 2 * _MARGIN_EM, 1.0), _WIDTH_EM)
    head = Band(top, sizes.head)
    first = [Band(head.end + i * (sizes.card + sizes.gap), sizes.card) for i in range(cards)]
    hint = Band(head.end + cards * (sizes.card + sizes.gap), sizes.hint)
    start = hint.end + sizes.recent_head
    others = [Band(start + i * sizes.row, sizes.row) for i in range(rows)]
    bands = tuple(_scaled(band, em) for band in (*first, *others))
    x = max((width - wide) / 2, 0.0) * em
    return StartLayout(x, wide * em, _scaled(head, em), bands, cards, _scaled(hint, em), is_roomy)


def _scaled(band: Band, em: float) -> Band:
    return Band(band.y * em, band.height * em)
