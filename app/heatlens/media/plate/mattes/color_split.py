"""Split the colors of a picture into a thing and what is behind it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.mattes.mattes import SURE_COVERAGE
from heatlens.media.plate.plate import Cutout, FloatImage, Pixels, read_pixels

_DEPTH_RATIO = 0.95  # distances within this ratio are those of one surface
_JUMP_PX = 3.0  # circles of confusion within this difference are those of one surface
Mask = NDArray[np.bool_]
# Kept shares from which the background of a pixel is guessed in part, and guessed alone; below the
# first, it is computed from the pixel.
_GUESS_FROM, _GUESS_ONLY_FROM = 0.3, 0.7
_CONTINUES_FROM = (
    0.5  # mean share around a nearer surface, from which the thing continues behind it
)


@dataclass(frozen=True, eq=False)
class NearnessPicture:
    """Pixels with their nearness, which is larger for nearer surfaces.

    It is in dioptres, or the circle of confusion in pixels with the sign reversed if `is_coc`.
    """

    color: FloatImage
    nearness: FloatImage
    is_coc: bool

    @staticmethod
    def from_pixels(pixels: Pixels) -> "NearnessPicture":
        """Return the pixels of a plate with their nearness."""
        if pixels.coc_px is not None:
            return NearnessPicture(pixels.color, -pixels.coc_px, is_coc=True)
        assert pixels.depth_m is not None
        return NearnessPicture(pixels.color, np.float32(1) / pixels.depth_m, is_coc=False)

    def convert_to_depth(self, nearness: FloatImage) -> FloatImage:
        """Return depths in meters, or circles of confusion in pixels, for a nearness (H, W)."""
        if self.is_coc:
            return -nearness
        with np.errstate(divide="ignore"):
            return np.float32(1) / nearness

    def mask_in_front(self, other_nearness: FloatImage, nearness: FloatImage | None = None) -> Mask:
        """Return a mask where `nearness` lies clearly in front of `other_nearness`.

        Without `nearness`, that of the picture is compared.
        """
        own_nearness = self.nearness if nearness is None else nearness
        is_front: Mask = (
            own_nearness - other_nearness > _JUMP_PX
            if self.is_coc
            else own_nearness * _DEPTH_RATIO > other_nearness
        )
        return is_front

    def fill_farthest(self, known: Mask) -> FloatImage:
        """Return the nearness (H, W); unknown pixels get that of the farthest known one nearby."""
        return _fill_unknown(self.nearness[..., None], known, is_mean=False)[..., 0]

    def fill_nearest(self, known: Mask) -> FloatImage:
        """Return the nearness (H, W); unknown pixels get that of the nearest known one nearby."""
        return -_fill_unknown(-self.nearness[..., None], known, is_mean=False)[..., 0]

    def fill_mean_color(self, known: Mask) -> FloatImage:
        """Return the color (H, W, C); unknown pixels get the mean of the known ones nearby."""
        return _fill_unknown(self.color, known)


# A pyramid fills holes of any size in a few passes without seams; repeating a filter of one pixel
# would need as many passes as the hole is wide. Unknown colors become the mean of their
# neighbors. Unknown depths become the least, because the mean of two depths lies on no surface.
def _fill_unknown(values: FloatImage, known: Mask, is_mean: bool = True) -> FloatImage:
    """Return values (H, W, C) in which unknown pixels are the mean of the known ones nearby.

    The means come from the known pixels of pictures of half the size, a quarter, and so on. Without
    `is_mean`, unknown pixels get the least of the known values instead. Where nothing is known
    they are 0, or infinity without `is_mean`.
    """
    values = np.where(known[..., None], values, np.float32(0 if is_mean else np.inf))
    if known.all() or max(known.shape) == 1:
        return values
    padding = [(0, side % 2) for side in known.shape]
    count = _group_in_fours(np.pad(known, padding)[..., None].astype(np.float32)).sum(axis=(1, 3))
    fours = _group_in_fours(
        np.pad(values, [*padding, (0, 0)], constant_values=0 if is_mean else np.inf)
    )
    half_size = fours.sum(axis=(1, 3)) / np.maximum(count, 1) if is_mean else fours.min(axis=(1, 3))
    full_size = _fill_unknown(half_size, count[..., 0] > 0, is_mean)
    for axis in (0, 1):
        full_size = _double_size(full_size, axis) if is_mean else np.repeat(full_size, 2, axis)
    return np.where(known[..., None], values, full_size[: known.shape[0], : known.shape[1]])


@dataclass(frozen=True, eq=False)
class SplitPicture:
    """A picture split into the kept thing, which stays sharp, and its surroundings.

    share                  part of each pixel that the thing covers
    nearness               that of the thing; elsewhere that of its nearest pixels
    is_front               pixels without the thing, which lie in front of it
    is_back                pixels without the thing, which lie behind it or next to it
    is_open                pixels of the thing behind which the surroundings may continue
    surroundings           their colors, without the thing where `is_open`
    surroundings_nearness  their nearness
    """

    picture: NearnessPicture
    share: FloatImage
    nearness: FloatImage
    is_front: Mask
    is_back: Mask
    is_open: Mask
    surroundings: FloatImage
    surroundings_nearness: FloatImage

    @staticmethod
    def split(picture: NearnessPicture, share: FloatImage) -> "SplitPicture":
        """Split a picture by the share of the thing in each pixel."""
        is_sure = (share == 1) | ((share >= SURE_COVERAGE) & ~_grow_mask(share == 1))
        nearness = picture.fill_farthest(is_sure)
        nearness = np.where(np.isinf(nearness), picture.nearness, nearness)
        is_front = (share == 0) & picture.mask_in_front(nearness)
        is_back = (share == 0) & ~picture.mask_in_front(picture.fill_nearest(is_sure))
        behind_nearness = picture.fill_farthest(is_back)
        is_open = (
            (share > 0)
            & np.isfinite(behind_nearness)
            & ~picture.mask_in_front(nearness, behind_nearness)
        )
        background = _unmix_background(
            picture.color, share, _kept_color(picture, share), picture.fill_mean_color(is_back)
        )
        surroundings = np.where(is_open[..., None], background, picture.color)
        surroundings_nearness = np.where(is_open, behind_nearness, picture.nearness)
        return SplitPicture(
            picture=picture,
            share=share,
            nearness=nearness,
            is_front=is_front,
            is_back=is_back,
            is_open=is_open,
            surroundings=surroundings,
            surroundings_nearness=surroundings_nearness,
        )

    def cut_out_kept(self) -> Cutout:
        """Return the cutout of the thing, continued behind nearer surfaces, and of the rest."""
        share = self.share
        kept_color = _kept_color(self.picture, self.share)
        color = self.picture.color
        is_mixed = (share > 0) & (share < 1) & _grow_mask(self.is_front)
        continued_share = np.where(self.is_front, _share_nearby(share, ~self.is_front), is_mixed)
        continued_share = continued_share.astype(np.float32)
        light = np.maximum(color - (1 - share[..., None]) * self.surroundings, 0)
        light = np.where(
            continued_share[..., None] > 0, continued_share[..., None] * kept_color, light
        )
        # In a mixed pixel at a nearer surface, replace the light of the thing by the background.
        behind_color = self.picture.fill_mean_color(self.is_back)
        surroundings_under = np.maximum(color + share[..., None] * (behind_color - kept_color), 0)
        is_surroundings_under = is_mixed & self.is_open
        surroundings = np.where(
            is_surroundings_under[..., None], surroundings_under, self.surroundings
        )
        nearness = np.where(
            is_surroundings_under, self.picture.nearness, self.surroundings_nearness
        )
        return self._make_cutout(light, np.maximum(continued_share, share), surroundings, nearness)

    def cut_out_with_backdrop(self) -> Cutout:
        """Return the cutout of the thing before its surroundings, which have a backdrop."""
        color, share, is_open = self.picture.color, self.share[..., None], self.is_open[..., None]
        is_backdrop = (self.share == 1) & ~self.is_open
        backdrop = np.where(share == 1, color, self.picture.fill_mean_color(is_backdrop))
        continued_share = _share_nearby(1 - self.share, ~self.is_open)[..., None]
        surroundings = np.where(
            is_open, continued_share * self.surroundings, np.maximum(color - share * backdrop, 0)
        )
        light = np.where(is_open, np.maximum(color - (1 - share) * self.surroundings, 0), 0)
        kept_share = np.where(self.is_open, self.share, np.float32(0))
        return replace(
            self._make_cutout(light, kept_share, surroundings, self.surroundings_nearness),
            backdrop=backdrop,
        )

    def _make_cutout(
        self, light: FloatImage, share: FloatImage, surroundings: FloatImage, nearness: FloatImage
    ) -> Cutout:
        """Return the cutout of this light and share, and the surroundings with its nearness."""
        picture = self.picture
        pixels = read_pixels(
            surroundings.astype(np.float32), picture.convert_to_depth(nearness), picture.is_coc
        )
        return Cutout(
            light.astype(np.float32), share, picture.convert_to_depth(self.nearness), pixels
        )


def _kept_color(picture: NearnessPicture, share: FloatImage) -> FloatImage:
    """Return the color of the kept thing, continued over the pixels around it."""
    return picture.fill_mean_color(share == 1 if (share == 1).any() else share > 0)


# The background is the remaining light divided by the remaining share. This division amplifies
# noise and the error of the guessed color without bound as the divisor goes to 0. So from a kept
# share of 0.3 on, the guessed background is mixed in, and from 0.7 on it is used alone.
def _unmix_background(
    color: FloatImage, share: FloatImage, kept_color: FloatImage, guessed_background: FloatImage
) -> FloatImage:
    """Return the color of the background in mixed pixels.

    The background never gives more light than the whole pixel has.
    """
    kept_share = share[..., None]
    background_share = np.maximum(kept_share.dtype.type(1) - kept_share, np.float32(1e-3))
    background = np.maximum(color - kept_share * kept_color, 0) / background_share
    guess_weight = np.clip((kept_share - _GUESS_FROM) / (_GUESS_ONLY_FROM - _GUESS_FROM), 0, 1)
    blended = np.minimum(
        background + guess_weight * (guessed_background - background), color / background_share
    )
    return np.where(kept_share == 1, guessed_background, np.maximum(blended, 0))


def _share_nearby(share: FloatImage, known: Mask) -> FloatImage:
    """Return how close each pixel (H, W) is to known pixels with a share of 1: 0 to 1.

    `known` marks the pixels whose share counts.
    """
    level = _fill_unknown(share[..., None], known)[..., 0]
    nearness_share: FloatImage = np.clip((level - _CONTINUES_FROM) / (1 - _CONTINUES_FROM), 0, 1)
    return nearness_share


def _grow_mask(mask: Mask) -> Mask:
    """Return the mask grown by one pixel in all directions."""
    rows, columns = mask.shape
    padded = np.pad(mask, 1)
    grown: Mask = np.logical_or.reduce(
        [padded[y : y + rows, x : x + columns] for y in range(3) for x in range(3)]
    )
    return grown


def _group_in_fours(values: FloatImage) -> FloatImage:
    """Return a view (H / 2, 2, W / 2, 2, C) of values (H, W, C), in groups of 2 x 2 pixels."""
    rows, columns, channels = values.shape
    return values.reshape(rows // 2, 2, columns // 2, 2, channels)


def _double_size(values: FloatImage, axis: int) -> FloatImage:
    """Return values twice as long along an axis, interpolated between the middles of pixels."""
    last_index = values.shape[axis] - 1
    neighbour_index = np.arange(2 * last_index + 2) // 2 + np.tile([-1, 1], last_index + 1)
    neighbours = np.take(values, np.clip(neighbour_index, 0, last_index), axis)
    doubled: FloatImage = (
        np.float32(0.75) * np.repeat(values, 2, axis) + np.float32(0.25) * neighbours
    )
    return doubled
