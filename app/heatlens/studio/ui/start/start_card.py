"""Draw a card of the start screen: picture, name, a line under it, and its digit key.

The layout of the start screen is computed for the size of the window.
"""

import math
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.base.paths import data_dir, file_bytes
from heatlens.media.files.opened_by_ending import picture_of
from heatlens.render.gpu.device import Device, Sampling, Texture
from heatlens.studio.session.files.start_choices import Card
from heatlens.studio.ui import theme
from heatlens.studio.ui.texts import fitted

_ROUNDING_EM, _PAD_EM, _AIR_EM = 0.25, 0.5, 1.0
_BAR_EM, _PLUS_EM, _DIGIT_EM = 0.2, 0.45, 1.5
_COLUMN_LEAST_EM = 4.8  # smallest width of the picture column; fits the kind of a recent file


@dataclass(frozen=True)
class Place:
    """The corners of a card and the width of its picture column, in screen units."""

    low: ImVec2
    high: ImVec2
    column: float

    @property
    def middle_y(self) -> float:
        """The height of the card's middle, between its two lines of text."""
        return (self.low.y + self.high.y) / 2


def column_width(card_height: float, em: float) -> float:
    """Return the width of a 16:9 picture on a card of this height."""
    return max((card_height - 2 * _PAD_EM * em) * 16 / 9, _COLUMN_LEAST_EM * em)


class CardPictures:
    """The card pictures of assets/ as textures, loaded when first drawn."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._textures: dict[str, Texture] = {}

    def texture(self, name: str) -> Texture:
        """Return a picture of assets/ as a texture; the first frame of an animation."""
        if name not in self._textures:
            with picture_of(file_bytes(data_dir("assets") / name)) as file:
                picture = file.convert("RGBA")
            texture = self._ctx.texture(picture.size, 4, picture.tobytes())
            texture.build_mipmaps()
            texture.sampling = Sampling.MIPMAPPED
            self._textures[name] = texture
        return self._textures[name]


def draw_card(
    card: Card, digit: int, place: Place, pictures: CardPictures, is_chosen: bool, is_coming: bool
) -> None:
    """Draw a card; `is_chosen` marks it as selected, `is_coming` as being opened."""
    em = imgui.get_font_size()
    _ground(place, is_chosen, is_flat=bool(card.kind))
    left = place.low.x + (_BAR_EM + _PAD_EM) * em
    if card.kind:
        at = ImVec2(left, place.middle_y - 1.1 * em)
        imgui.get_window_draw_list().add_text(at, theme.colors.text_dim, card.kind)
    else:
        _emblem(card, ImVec2(left, place.low.y + _PAD_EM * em), place, pictures)
    _text(card, left + place.column + _AIR_EM * em, place, is_coming)
    at = ImVec2(place.high.x - _DIGIT_EM * em, place.middle_y - 0.5 * em)
    color = theme.colors.handle if is_chosen else theme.colors.text_dim
    imgui.get_window_draw_list().add_text(at, color, str(digit))


def _ground(place: Place, is_chosen: bool, is_flat: bool) -> None:
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    rounding = _ROUNDING_EM * em
    if is_chosen or not is_flat:
        slot = imgui.Col_.frame_bg if is_chosen else imgui.Col_.window_bg
        draw.add_rect_filled(place.low, place.high, imgui.get_color_u32(slot), rounding)
    if is_chosen:
        low = ImVec2(place.low.x, place.low.y + _PAD_EM * em)
        high = ImVec2(low.x + _BAR_EM * em, place.high.y - _PAD_EM * em)
        draw.add_rect_filled(low, high, theme.colors.handle, _BAR_EM * em / 2)


def _emblem(card: Card, low: ImVec2, place: Place, pictures: CardPictures) -> None:
    """Draw the picture, cropped to fill its column, or an empty frame if there is none."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    width, height = place.column, place.high.y - place.low.y - 2 * _PAD_EM * em
    high = ImVec2(low.x + width, low.y + height)
    if card.picture is None:
        draw.add_rect(low, high, theme.colors.on_disk, _ROUNDING_EM * em)
        _plus(ImVec2(low.x + width / 2, low.y + height / 2), _PLUS_EM * em)
        return
    texture = pictures.texture(card.picture)
    wider = width * texture.height / (height * texture.width)
    u, v = min(wider, 1.0) / 2, min(1.0 / wider, 1.0) / 2
    first, last = ImVec2(0.5 - u, 0.5 - v), ImVec2(0.5 + u, 0.5 + v)
    name = imgui.ImTextureRef(texture.handle)
    draw.add_image_rounded(name, low, high, first, last, theme.UNTINTED, _ROUNDING_EM * em)


def _plus(middle: ImVec2, arm: float) -> None:
    draw, (x, y) = imgui.get_window_draw_list(), (middle.x, middle.y)
    draw.add_line(ImVec2(x - arm, y), ImVec2(x + arm, y), theme.colors.text_dim)
    draw.add_line(ImVec2(x, y - arm), ImVec2(x, y + arm), theme.colors.text_dim)


def _text(card: Card, x: float, place: Place, is_coming: bool) -> None:
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    width = place.high.x - (_DIGIT_EM + 0.5) * em - x
    bright, y = imgui.get_color_u32(imgui.Col_.text), place.middle_y
    draw.add_text(ImVec2(x, y - 1.1 * em), bright, fitted(printable(card.title), width))
    words, color = card.words, theme.colors.text_dim
    if is_coming:
        words, color = "Opening ...", theme.colors.handle
    draw.add_text(ImVec2(x, y + 0.1 * em), color, fitted(printable(words), width, bool(card.kind)))


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
