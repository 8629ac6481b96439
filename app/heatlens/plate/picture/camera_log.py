"""Convert the log of cameras to scene-linear light in Rec.709, by OpenColorIO."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.base.errors import InputError
from heatlens.files.ocio_library import ocio
from heatlens.plate.plate import FloatImage

# The full name, because another version of the library could have another config.
_CONFIG = "studio-config-v2.2.0_aces-v1.3_ocio-v2.4"
_LINEAR = "Linear Rec.709 (sRGB)"


def log_light(path: Path, signal: FloatImage, color_space: str) -> FloatImage:
    """Return light (H, W, 3 or 4) of a signal of 0 to 1 in a colour space of OpenColorIO.

    Middle grey becomes 0.18; alpha stays. Raises InputError for a grey picture.
    """
    if signal.shape[2] not in (3, 4):
        raise InputError(f"{path} is grey: the log of a camera has three colours.")
    light: FloatImage = np.ascontiguousarray(signal, np.float32)
    apply = _processor(color_space).applyRGB if light.shape[2] == 3 else None
    (apply or _processor(color_space).applyRGBA)(light)
    return light


@lru_cache(maxsize=4)
def _processor(color_space: str) -> Any:
    config = ocio().Config.CreateFromBuiltinConfig(_CONFIG)
    return config.getProcessor(color_space, _LINEAR).getDefaultCPUProcessor()
