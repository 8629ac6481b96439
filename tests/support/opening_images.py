"""Images of apertures: one without any symmetry, a heart, and random ones.

`python -m support.opening_images` in the folder `tests` writes assets/aperture_heart.png anew.
"""

from pathlib import Path

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from heatlens.core.base.paths import data_dir
from heatlens.core.model.lens.opening_image import IMAGE_SIDE, OpeningImage

HEART_SIDE = 192
_FINER = 4  # samples of a pixel, each way


def image_of(light: NDArray[np.float32], name: str = "made") -> OpeningImage:
    """Return an aperture image from a small array, whose side must divide IMAGE_SIDE."""
    times = IMAGE_SIDE // len(light)
    cells = np.kron(np.asarray(light, np.float32), np.ones((times, times), np.float32))
    return OpeningImage(path=name, digest=f"{name} {hash(cells.tobytes())}", light=cells)


def letter() -> OpeningImage:
    """Return an aperture image of the letter F, which has no symmetry."""
    dark = "........"
    rows = [dark, "..####..", "..#.....", "..###...", "..#.....", "..#.....", dark, dark]
    return image_of(np.array([[c == "#" for c in row] for row in rows], np.float32), "letter")


def opening_images() -> st.SearchStrategy[OpeningImage]:
    """Return a strategy of random aperture images that are not black, some mostly dark."""

    def made(drawn: tuple[int, int, float]) -> OpeningImage:
        seed, side, dark = drawn
        rng = np.random.default_rng(seed)
        light = rng.random((side, side)) * (rng.random((side, side)) > dark)
        light[side // 2, side // 2] = 1.0
        return image_of(light.astype(np.float32), f"random {seed} {dark}")

    sides, darks = st.sampled_from((2, 8, 64, 256)), st.sampled_from((0.0, 0.5, 0.95))
    return st.tuples(st.integers(0, 2**32 - 1), sides, darks).map(made)


def heart() -> NDArray[np.uint8]:
    """Return the heart of assets/aperture_heart.png, where (x^2 + y^2 - 1)^3 < x^2 y^3."""
    coordinates = (np.arange(HEART_SIDE * _FINER) + 0.5) / (HEART_SIDE * _FINER) * 2 - 1
    # Its light is in balance about the axis, and it just touches the circle of the lens.
    x, y = 1.29 * coordinates[None, :], 0.2935 - 1.29 * coordinates[:, None]
    inside = ((x**2 + y**2 - 1) ** 3 < x**2 * y**3).astype(np.float64)
    blocks = inside.reshape(HEART_SIDE, _FINER, HEART_SIDE, _FINER).mean(axis=(1, 3))
    return np.asarray(np.rint(blocks * 255), np.uint8)


def heart_path() -> Path:
    """Return the path of the heart that comes with the program."""
    return data_dir("assets") / "aperture_heart.png"


if __name__ == "__main__":
    Image.fromarray(heart()).save(heart_path(), optimize=True)
