"""Read written pictures as arrays of numbers."""

import numpy as np
from PIL import Image


def pixels(path) -> np.ndarray:
    """Return the pixels (H, W, 3) of an RGB picture as signed integers, for differences."""
    with Image.open(path) as image:
        assert image.mode == "RGB"
        return np.asarray(image).astype(int)
