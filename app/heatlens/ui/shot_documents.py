"""Shots as documents: how one begins with a plate."""

from heatlens.model.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.model.lens import Lens
from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot
from heatlens.ui.plate_source import Opened


def started_shot(opened: Opened, lens: Lens, defocus: DefocusSettings) -> Shot:
    """A shot of what was opened, without keys; the rate is that of its header."""
    sequence = opened.cache.sequence
    return Shot(
        lens,
        defocus,
        opened.text,
        opened.options,
        frames=None if sequence.is_single else FrameRange(sequence.first, sequence.last),
        frames_per_second=_rate(opened),
    )


def _rate(opened: Opened) -> float:
    """The attribute is a fraction; OpenEXR says which rate holds without it, or with nonsense."""
    rate = float(opened.plate.attributes.get("framesPerSecond", FRAMES_PER_SECOND))
    return rate if 1.0 <= rate <= 1000.0 else FRAMES_PER_SECOND
