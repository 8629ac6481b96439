"""Lift the highlights of display-referred pictures, whose light is clipped at white.

A lamp that a camera clipped to white is as bright as a sheet of paper, and its disc out of focus is
a dull gray. Its true brightness is not in the file, so the user gives the number of stops.
"""

import numpy as np

from heatlens.media.plate.plate import FloatImage

LIFT_FROM = 0.9  # light of the brightest channel up to which a pixel stays as it is
PROPOSED_STOPS = 3.0
_WHITE = 0.99  # light from which a pixel counts as clipped
_WHITE_LEAST = 0.0002  # share of clipped pixels from which lifting is proposed


def lift_highlights(color: FloatImage, stops: float) -> FloatImage:
    """Return `color` (H, W, C) of linear light 0..1 with its highlights lifted, alpha unchanged.

    An inverse shoulder: pixels whose brightest channel is up to LIFT_FROM stay, one at 1 becomes
    2^`stops`, and between them brightness grows smoothly and monotonically. All channels of a pixel
    are scaled alike, which keeps its hue.
    """
    brightest = color[..., :3].max(axis=-1, keepdims=True)
    gain = _inverse_shoulder(np.clip((brightest - LIFT_FROM) / (1.0 - LIFT_FROM), 0.0, 1.0), stops)
    is_lifted = brightest > LIFT_FROM
    lifted_color = color.copy()
    lifted_color[..., :3] *= np.where(
        is_lifted, gain * LIFT_FROM / np.maximum(brightest, LIFT_FROM), 1.0
    )
    return lifted_color


# A quadratic in the logarithm has the three parameters that are needed: the value and the slope
# where lifting begins, without which an edge would show there, and the value at white. It increases
# all the way, so no highlight becomes darker than its surroundings.
def _inverse_shoulder(position: FloatImage, stops: float) -> FloatImage:
    """Return the lifted brightness as a multiple of LIFT_FROM.

    `position` runs from 0 at LIFT_FROM to 1 at white. The logarithm of the result is a quadratic
    that begins with the slope of unchanged light.
    """
    slope = (1.0 - LIFT_FROM) / LIFT_FROM
    bend = stops * np.log(2.0) - np.log(LIFT_FROM) - slope
    gain: FloatImage = np.exp(slope * position + bend * position * position).astype(np.float32)
    return gain


def clipped_note(color: FloatImage, label: str) -> tuple[str, ...]:
    """Return a proposal to lift the highlights of `color` (H, W, C), if enough pixels are white."""
    share = float((color[..., :3].max(axis=-1) >= _WHITE).mean())
    if share < _WHITE_LEAST:
        return ()
    return (
        f"{label}: {100 * share:.2g} % of the pixels are clipped at white, so lamps become dull "
        f"discs. --lift-highlights {PROPOSED_STOPS:g} makes them {2**PROPOSED_STOPS:g} times as "
        "bright as white.",
    )
