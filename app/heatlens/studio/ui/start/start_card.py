"""Draw a card of the start screen: picture, name, a line under it, and its digit key.

The layout of the start screen is computed for the size of the window.
"""

import math
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.base.paths import data_dir, read_file_bytes
from heatlens.media.files.opened_by_ending import open_embedded_picture
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Sampling, Texture
from heatlens.studio.settings.cards import Card
from heatlens.studio.ui import theme
from heatlens.studio.ui.texts import fit_text

_ROUNDING_EM, _PAD_EM, _TEXT_GAP_EM = 0.25, 0.5, 1.0
_BAR_EM, _PLUS_EM, _DIGIT_EM = 0.2, 0.45, 1.5
_MIN_COLUMN_EM = 4.8  # smallest width of the picture column; fits the kind of a recent file


@dataclass(frozen=True)
class CardArea:
    """The area of a card and the width of its picture column, in screen units."""

    corner: ImVec2
    end: ImVec2
    column_width: float

    @property
    def middle_y(self) -> float:
        """The height of the card's middle, between its two lines of text."""
        return (self.corner.y + self.end.y) / 2


def column_width(card_height: float, em: float) -> float:
    """Return the width of a 16:9 picture on a card of this height."""
    return max((card_height - 2 * _PAD_EM * em) * 16 / 9, _MIN_COLUMN_EM * em)


class CardPictures:
    """The card pictures of assets/ as textures, loaded when first drawn."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._textures: dict[str, Texture] = {}

    def texture(self, name: str) -> Texture:
        """Return a picture of assets/ as a texture; the first frame of an animation."""
        if name not in self._textures:
            with open_embedded_picture(read_file_bytes(data_dir("assets") / name)) as file:
                picture = file.convert("RGBA")
            texture = self._ctx.texture(picture.size, 4, picture.tobytes())
            texture.build_mipmaps()
            texture.sampling = Sampling.MIPMAPPED
            self._textures[name] = texture
        return self._textures[name]


def draw_card(
    card: Card,
    digit: int,
    area: CardArea,
    pictures: CardPictures,
    is_selected: bool,
    is_opening: bool,
) -> None:
    """Draw a card in its area; `is_opening` writes "Opening ..." under its name."""
    em = imgui.get_font_size()
    _draw_background(area, is_selected, is_flat=bool(card.kind))
    left = area.corner.x + (_BAR_EM + _PAD_EM) * em
    if card.kind:
        text_corner = ImVec2(left, area.middle_y - 1.1 * em)
        imgui.get_window_draw_list().add_text(text_corner, theme.colors.text_dim, card.kind)
    else:
        _draw_emblem(card, ImVec2(left, area.corner.y + _PAD_EM * em), area, pictures)
    _draw_text(card, left + area.column_width + _TEXT_GAP_EM * em, area, is_opening)
    text_corner = ImVec2(area.end.x - _DIGIT_EM * em, area.middle_y - 0.5 * em)
    color = theme.colors.handle if is_selected else theme.colors.text_dim
    imgui.get_window_draw_list().add_text(text_corner, color, str(digit))


def _draw_background(area: CardArea, is_selected: bool, is_flat: bool) -> None:
    """Draw the background of a card, and a bar at its left if it is selected."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    rounding = _ROUNDING_EM * em
    if is_selected or not is_flat:
        slot = imgui.Col_.frame_bg if is_selected else imgui.Col_.window_bg
        draw.add_rect_filled(area.corner, area.end, imgui.get_color_u32(slot), rounding)
    if is_selected:
        bar_corner = ImVec2(area.corner.x, area.corner.y + _PAD_EM * em)
        bar_end = ImVec2(bar_corner.x + _BAR_EM * em, area.end.y - _PAD_EM * em)
        draw.add_rect_filled(bar_corner, bar_end, theme.colors.handle, _BAR_EM * em / 2)


def _draw_emblem(card: Card, corner: ImVec2, area: CardArea, pictures: CardPictures) -> None:
    """Draw the picture, cropped to fill its column, or an empty frame if there is none."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    width, height = area.column_width, area.end.y - area.corner.y - 2 * _PAD_EM * em
    end = ImVec2(corner.x + width, corner.y + height)
    if card.picture is None:
        draw.add_rect(corner, end, theme.colors.on_disk, _ROUNDING_EM * em)
        _draw_plus(ImVec2(corner.x + width / 2, corner.y + height / 2), _PLUS_EM * em)
        return
    texture = pictures.texture(card.picture)
    wider = width * texture.height / (height * texture.width)
    u, v = min(wider, 1.0) / 2, min(1.0 / wider, 1.0) / 2
    first, last = ImVec2(0.5 - u, 0.5 - v), ImVec2(0.5 + u, 0.5 + v)
    picture = imgui.ImTextureRef(texture.handle)
    draw.add_image_rounded(picture, corner, end, first, last, theme.UNTINTED, _ROUNDING_EM * em)


def _draw_plus(center: ImVec2, arm: float) -> None:
    """Draw a plus sign."""
    draw, (x, y) = imgui.get_window_draw_list(), (center.x, center.y)
    draw.add_line(ImVec2(x - arm, y), ImVec2(x + arm, y), theme.colors.text_dim)
    draw.add_line(ImVec2(x, y - arm), ImVec2(x, y + arm), theme.colors.text_dim)


def _draw_text(card: Card, x: float, area: CardArea, is_opening: bool) -> None:
    """Draw the name of a card and the line under it, cut to fit."""
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    width = area.end.x - (_DIGIT_EM + 0.5) * em - x
    title_color, y = imgui.get_color_u32(imgui.Col_.text), area.middle_y
    draw.add_text(ImVec2(x, y - 1.1 * em), title_color, fit_text(printable(card.title), width))
    words, color = card.words, theme.colors.text_dim
    if is_opening:
        words, color = "Opening ...", theme.colors.handle
    draw.add_text(
        ImVec2(x, y + 0.1 * em), color, fit_text(printable(words), width, bool(card.kind))
    )


_WIDTH_EM, _MARGIN_EM = 38.0, 1.2
_SHARE_ABOVE = 0.4  # share of the free height above the cards; less than half looks centered


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

    def total(self, cards: int) -> float:
        """Return the height of everything but the recent files, in em."""
        return self.head + cards * (self.card + self.gap) + self.hint


_ROOMY = _Heights(head=5.2, card=5.8, gap=0.6, hint=4.2, recent_head=1.2, row=3.0)
_COMPACT = _Heights(head=3.6, card=3.4, gap=0.4, hint=2.4, recent_head=0.6, row=2.7)
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
    cards     `permanent_count` permanent cards, then as many recent files as fit
    hint      the hint under the permanent cards; `is_roomy` gives it two lines
    """

    x: float
    width: float
    head: Band
    cards: tuple[Band, ...]
    permanent_count: int
    hint: Band
    is_roomy: bool


def lay_out(
    card_count: int, recent_count: int, area: tuple[float, float], em: float
) -> StartLayout:
    """Lay out `card_count` permanent cards and up to `recent_count` recent files.

    `area` (width, height) and `em` are in screen units. If the area is too small for the permanent
    cards, the last ones extend beyond it.
    """
    width, height = area[0] / em, area[1] / em
    is_roomy = height >= _ROOMY_FROM_EM
    sizes = _ROOMY if is_roomy else _COMPACT
    free_height = height - 2 * _MARGIN_EM - sizes.total(card_count)
    row_count = min(recent_count, max(math.floor((free_height - sizes.recent_head) / sizes.row), 0))
    free_height -= row_count * sizes.row + (sizes.recent_head if row_count else 0.0)
    top = _MARGIN_EM + max(free_height * _SHARE_ABOVE, 0.0)
    content_width = min(max(width - 2 * _MARGIN_EM, 1.0), _WIDTH_EM)
    head = Band(top, sizes.head)
    card_bands = [
        Band(head.end + index * (sizes.card + sizes.gap), sizes.card) for index in range(card_count)
    ]
    hint = Band(head.end + card_count * (sizes.card + sizes.gap), sizes.hint)
    start = hint.end + sizes.recent_head
    recent_bands = [Band(start + index * sizes.row, sizes.row) for index in range(row_count)]
    bands = tuple(_scale_band(band, em) for band in (*card_bands, *recent_bands))
    x = max((width - content_width) / 2, 0.0) * em
    return StartLayout(
        x,
        width=content_width * em,
        head=_scale_band(head, em),
        cards=bands,
        permanent_count=card_count,
        hint=_scale_band(hint, em),
        is_roomy=is_roomy,
    )


def _scale_band(band: Band, em: float) -> Band:
    return Band(band.y * em, band.height * em)
