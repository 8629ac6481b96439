"""How a surface looks: a small picture of it, and where that is found again."""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.plate import FloatImage
from heatlens.plate.tracking.crops import ByteImage, Crop, opencv

_LIKE_LEAST = 0.7  # correlation from which a place shows the surface
_SEEN_LEAST = 0.6  # share of the surface that must have a possible depth
_SURE, _SURE_OCTAVES = 0.9, 0.5  # the same where it looks different, and for how long
_PLAIN_LEVELS = 2.0  # spread below which a surface has no pattern to look for
Place = NDArray[np.float64]


@dataclass(frozen=True)
class Look:
    """A picture (h, w, 2) of light and colour around the place, and what of it is the surface.

    `offset` is from the corner of the picture to the place, in pixels (x, y).
    """

    image: ByteImage
    mask: FloatImage
    offset: Place

    @property
    def has_pattern(self) -> bool:
        """Return True if it can be told from a plain surface."""
        return bool(self.image[self.mask > 0].astype(np.float32).std(axis=0).max() > _PLAIN_LEVELS)

    def likeness(self, crop: Crop, at: Place) -> float:
        """Return how much a place of a crop looks like this, 0 to 1; 0 where it is cut off."""
        x, y = np.rint(at - (crop.x0, crop.y0) - self.offset).astype(int)
        height, width = self.mask.shape
        part = crop.image[max(y, 0) : y + height, max(x, 0) : x + width, :2]
        if part.shape != self.image.shape:
            return 0.0
        return min(max(float(self._matches(part)[0, 0]), 0.0), 1.0) if self.has_pattern else 1.0

    def found(
        self, crop: Crop, expected: Place, dioptres: float, octaves: float
    ) -> tuple[Place, float, float] | None:
        """Return place, dioptres and likeness where the surface is seen again; None if nowhere.

        Its depth may differ by some octaves. Of a plain surface the nearest part is taken, and so
        of one that looks different, soon after it was seen and close to where it should be.
        """
        height, width = self.mask.shape
        rows, columns = crop.dioptres.shape[0] - height + 1, crop.dioptres.shape[1] - width + 1
        if rows <= 0 or columns <= 0:
            return None
        near = np.abs(np.log2(crop.dioptres / dioptres)) < octaves
        cv2 = opencv()
        covered = cv2.matchTemplate(near.astype(np.float32), self.mask, cv2.TM_CCORR)
        share = covered / self.mask.sum()
        y, x = np.mgrid[:rows, :columns]
        corner = expected - (crop.x0, crop.y0) - self.offset
        away = np.hypot(x - corner[0], y - corner[1]) / (rows + columns)
        like = self._matches(crop.image[..., :2]) if self.has_pattern else 1.0 - 0.2 * away
        like = np.where(share >= _SEEN_LEAST, like, -1.0)
        row, column = (int(it) for it in np.unravel_index(np.argmax(like), like.shape))
        if like[row, column] < _LIKE_LEAST:
            close = np.where((share >= _SURE) & (away * (rows + columns) <= width / 2), away, 2.0)
            row, column = (int(it) for it in np.unravel_index(np.argmin(close), close.shape))
            if close[row, column] == 2.0 or octaves > _SURE_OCTAVES:
                return None
        seen = near[row : row + height, column : column + width] & (self.mask > 0)
        depths = crop.dioptres[row : row + height, column : column + width][seen]
        place = np.array([crop.x0 + column, crop.y0 + row], np.float64) + self.offset
        return place, float(np.median(depths)), max(float(like[row, column]), 0.0)

    def _matches(self, image: ByteImage) -> FloatImage:
        """Return the correlation with every place of an image, -1 to 1."""
        cv2 = opencv()
        mask = np.repeat(self.mask[..., None], 2, -1)
        part = np.ascontiguousarray(image, np.float32)
        found = cv2.matchTemplate(
            part, self.image.astype(np.float32), cv2.TM_CCOEFF_NORMED, mask=mask
        )
        return np.where(np.isfinite(found), found, np.float32(-1.0))


def look_at(crop: Crop, at: Place, radius: int, dioptres: float, octaves: float) -> Look:
    """Return the look of the surface at a place; what lies farther in depth is left out."""
    column, row = np.rint(at - (crop.x0, crop.y0)).astype(int)
    x0, y0 = max(column - radius, 0), max(row - radius, 0)
    part = np.s_[y0 : row + radius + 1, x0 : column + radius + 1]
    assert isfinite(dioptres)
    near = np.abs(np.log2(crop.dioptres[part] / dioptres)) < octaves
    offset = at - (crop.x0, crop.y0) - (x0, y0)
    return Look(crop.image[part][..., :2].copy(), near.astype(np.float32), offset)
