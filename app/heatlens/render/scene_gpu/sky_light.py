"""The sky's light as in lib/shading.lib.glsl, and how a matt surface reflects it."""

import numpy as np

from heatlens.media.scene.scene import Array, Daylight

_GROUND_BAND = 0.1  # height below the horizon over which the ground begins; as in the shader
_PARTS = 4096  # bands of height over which the light of the sky is summed


def sky_radiance(daylight: Daylight, y: Array) -> Array:
    """Return the light of the sky (..., 3) from directions of height `y` (...,), -1 to 1.

    The height is the vertical coordinate of a unit vector. The light is the same all around.
    """
    up = np.maximum(y, 0.0)[..., None]
    high = up * (2 - up)
    above = (1 - high) * np.array(daylight.horizon) + high * np.array(daylight.zenith)
    t = np.clip((y[..., None] + _GROUND_BAND) / _GROUND_BAND, 0, 1)
    above_share = t * t * (3 - 2 * t)
    return np.asarray((1 - above_share) * np.array(daylight.ground) + above_share * above)


def diffuse_polynomial(daylight: Daylight) -> Array:
    """Return the polynomial of the mean light that a surface receives from the sky, (3, 3).

    The rows of the result are the colors a, b and c: a surface whose normal has the height y, -1 to
    1, receives a + b y + c y^2. The mean is weighted by the cosine. These are the first three zonal
    harmonics, exact for an even sky; Ramamoorthi and Hanrahan 2001 find about a hundredth in the
    rest.
    """
    y = (np.arange(_PARTS) + 0.5) * 2 / _PARTS - 1
    sky = sky_radiance(daylight, y)
    legendre = np.stack([np.ones_like(y), y, 1.5 * y * y - 0.5])
    even, first, second = (
        (2 * order + 1) / 2 * (2 / _PARTS) * (legendre[order] @ sky) for order in range(3)
    )
    # Weights 1, 2/3 and 1/4 of the cosine lobe; the second polynomial is split into its terms.
    return np.stack([even - second / 8, 2 / 3 * first, 3 / 8 * second])
