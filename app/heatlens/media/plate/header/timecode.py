"""Read the timecode in the header of a plate, and convert it to the attribute of EXR."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import OpenEXR

from heatlens.core.model.timecode import Timecode, try_parse_timecode

# The standard entry of EXR first, then those in which programs pass on the timecode of a clip.
_ENTRIES = (
    "timeCode",
    "nuke/input/timecode",
    "timecode",
    "smpte:TimeCode",
    "interim.clip.timecode",
)
_EXR_FRAMES_MOST = 29
_RATE_LEAST, _RATE_MOST = 1.0, 1000.0  # frames per second; headers with other rates are wrong


def timecode_of(attributes: Mapping[str, object]) -> Timecode | None:
    """Return the timecode in the header of a plate; None if it has no valid one."""
    for entry in _ENTRIES:
        value = attributes.get(entry)
        timecode = (
            try_parse_timecode(value) if isinstance(value, str) else _parse_exr_timecode(value)
        )
        if timecode is not None:
            return timecode
    return None


def exr_timecode(timecode: Timecode) -> Any | None:
    """Return the value of the EXR attribute `timeCode`; None for frames above 29, which do not fit.

    The attribute cannot hold the frame numbers of higher rates.
    """
    if timecode.frames > _EXR_FRAMES_MOST:
        return None
    value = OpenEXR.TimeCode()
    value.hours, value.minutes = timecode.hours, timecode.minutes
    value.seconds, value.frame = timecode.seconds, timecode.frames
    value.dropFrame = timecode.drop
    return value


def rate_at(attributes: Mapping[str, object]) -> float | None:
    """Return the frames per second in the header of a plate; None if it has no plausible rate."""
    value = attributes.get("framesPerSecond")
    if not isinstance(value, int | float | Fraction) or not _RATE_LEAST <= value <= _RATE_MOST:
        return None
    return float(value)


def _parse_exr_timecode(value: object) -> Timecode | None:
    """Return the timecode of a value of the EXR attribute `timeCode`; None for any other value."""
    if not isinstance(value, OpenEXR.TimeCode):
        return None
    numbers = value.hours, value.minutes, value.seconds, value.frame
    timecode = Timecode(*numbers, drop=bool(value.dropFrame))
    return timecode if timecode.is_possible else None
