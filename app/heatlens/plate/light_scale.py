"""The unit of a plate's light: what is bright in a picture is told from what the picture holds."""

import math

import numpy as np
import numpy.typing as npt

_BRIGHT_PERCENT = 90.0  # of the pixels are darker than what counts as bright
_BRIGHT_MOST = 4.0  # up to here the light is in units of a white surface, as renderers write it
_STEP = 16.0  # a power of two, so that scaling is exact; and coarse, so that it is steady in a shot
_SAMPLES_A_SIDE = 128


def light_scale(color: npt.NDArray[np.float32]) -> float:
    """Return what the light of a picture is multiplied by before it is blurred, a power of two.

    `color` is (H, W, 4), scene-linear. It is 1 for pictures in which a white surface is about 1,
    and less for those in physical units, such as candela per square metre: what outshines its
    surroundings, and what alike colours are, is then judged as in any other picture.
    """
    rows, columns = (max(1, side // _SAMPLES_A_SIDE) for side in color.shape[:2])
    luminance = color[::rows, ::columns, :3].mean(axis=2)
    bright = float(np.percentile(luminance, _BRIGHT_PERCENT))
    if bright <= _BRIGHT_MOST:
        return 1.0
    return float(_STEP ** -math.ceil(math.log(bright / _BRIGHT_MOST, _STEP)))
