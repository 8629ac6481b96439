"""Hypothesis strategies of curves with random keys, and helpers to build and sample curves."""

import numpy as np
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale

HOLD, LINEAR, SMOOTH, BEZIER = Interpolation
UNBENT = (HOLD, LINEAR, SMOOTH)  # those that stay between their keys whatever the handles say
FRAMES = st.lists(st.integers(900, 1200), min_size=1, max_size=7, unique=True).map(sorted)
VALUES = st.floats(0.05, 500.0)
EASES = st.builds(Ease, st.floats(0, 100), st.floats(-0.01, 0.01))
PARTS = st.floats(0, 1)


@st.composite
def curves(draw, interpolations=tuple(Interpolation), least=1, scales=tuple(Scale), values=VALUES):
    frames = draw(FRAMES.filter(lambda key_frames: len(key_frames) >= least))
    keys = [
        Key(frame, draw(values), draw(st.sampled_from(interpolations)), draw(EASES), draw(EASES))
        for frame in frames
    ]
    return Curve(tuple(keys), draw(st.sampled_from(scales)))


def curve_of(*frames_and_values, interpolation=SMOOTH, scale=Scale.LINEAR):
    keys = (Key(frame, value, interpolation) for frame, value in frames_and_values)
    return Curve(tuple(keys), scale)


def sampled_values(curve: Curve, count: int = 201) -> list[float]:
    first, last = curve.keys[0].frame, curve.keys[-1].frame
    return [curve.value_at(float(frame)) for frame in np.linspace(first, last, count)]
