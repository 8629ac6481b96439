"""Prepare the text of an EDL for OpenTimelineIO, which takes some lists otherwise than editors do.

A list does not tell its rate. Where its timecodes have frames that the rate has not, the sentence
says so in our words. A line M2 tells the speed of the event before it; the adapter uses it only if
source and record have different lengths, while Resolve writes equal ones. There the source gets the
length that the speed makes.
"""

import re
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra

_TIME = r"(\d\d:\d\d:\d\d[:;]\d\d)"
_EVENT = re.compile(rf"^\s*\d+\s+.*?{_TIME}\s+{_TIME}\s+{_TIME}\s+{_TIME}\s*$")
_SPEED = re.compile(rf"^\s*M2\s+.*?(-?\d+(?:\.\d+)?)\s+{_TIME}\s*$")
_FRAMES = re.compile(r"\b\d\d:\d\d:\d\d[:;](\d\d)\b")
_SAME_SPEED = 1e-3


def prepared(path: Path, text: str, rate: float) -> str:
    """Return the text of the EDL at `path` for the adapter, at `rate` frames a second.

    Raises InputError if its timecodes have frames beyond the rate.
    """
    most = max((int(digits) for digits in _FRAMES.findall(text)), default=0)
    if most >= round(rate):
        usual = next((it for it in (25, 30, 50, 60) if most < it), None)
        help_ = "no rate has so many" if usual is None else f"give its rate, as --edit-fps {usual}"
        raise InputError(
            f"{path} has timecodes with frames up to {most}, so it has more than {rate:g} frames a "
            f"second, which an EDL does not tell: {help_}."
        )
    lines, event = text.splitlines(), None
    for number, line in enumerate(lines):
        if _EVENT.match(line):
            event = number
        speed = _SPEED.match(line)
        if speed is not None and event is not None:
            lines[event] = _at_speed(lines[event], float(speed[1]), rate)
    return "\n".join(lines) + "\n"


def _at_speed(event: str, speed: float, rate: float) -> str:
    """Return an event whose source is as long as its speed makes it, where a list tells no length.

    `speed` is in frames of the source a second.
    """
    time = import_extra("opentimelineio").opentime
    match = _EVENT.match(event)
    assert match is not None
    begin, end, recorded, recorded_end = (
        time.from_timecode(it, round(rate)) for it in match.groups()
    )
    is_told = end - begin != recorded_end - recorded
    if is_told or abs(speed / rate - 1) < _SAME_SPEED or speed == 0:
        return event
    count = max(1, round((end - begin).value * abs(speed) / rate))
    other = begin + time.RationalTime(count, round(rate))
    source_end: str = time.to_timecode(other, round(rate))
    return event[: match.start(2)] + source_end + event[match.end(2) :]
