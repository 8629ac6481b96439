"""Prepare the text of an EDL for OpenTimelineIO, which reads some lists differently from editors.

A list does not state its frame rate. Timecodes with frames beyond the assumed rate are refused with
a sentence of heatlens. A line M2 states the speed of the event before it. The adapter uses it only
if source and record have different lengths, but Resolve writes equal ones. Therefore the source of
such an event gets the length that follows from the speed.
"""

import re
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra

_TIME = r"(\d\d:\d\d:\d\d[:;]\d\d)"
_EVENT = re.compile(rf"^\s*\d+\s+.*?{_TIME}\s+{_TIME}\s+{_TIME}\s+{_TIME}\s*$")
_SPEED = re.compile(rf"^\s*M2\s+.*?(-?\d+(?:\.\d+)?)\s+{_TIME}\s*$")
_FRAMES = re.compile(r"\b\d\d:\d\d:\d\d[:;](\d\d)\b")
_SAME_SPEED = 1e-3  # relative difference from normal speed that counts as none


def prepare_edl(path: Path, text: str, rate: float) -> str:
    """Return the text of the EDL at `path` for the adapter, at `rate` frames a second.

    Raises InputError if its timecodes have frames beyond the rate.
    """
    highest_frame = max((int(digits) for digits in _FRAMES.findall(text)), default=0)
    if highest_frame >= round(rate):
        likely_rate = next(
            (
                rate_candidate
                for rate_candidate in (25, 30, 50, 60)
                if highest_frame < rate_candidate
            ),
            None,
        )
        help_ = (
            "no rate has so many"
            if likely_rate is None
            else f"give its rate, as --edit-fps {likely_rate}"
        )
        raise InputError(
            f"{path} has timecodes with frames up to {highest_frame}, so its rate is above "
            f"{rate:g} frames a second. An EDL does not hold its rate: {help_}."
        )
    lines, event = text.splitlines(), None
    for number, line in enumerate(lines):
        if _EVENT.match(line):
            event = number
        speed = _SPEED.match(line)
        if speed is not None and event is not None:
            lines[event] = _stretch_source(lines[event], float(speed[1]), rate)
    return "\n".join(lines) + "\n"


def _stretch_source(event: str, speed: float, rate: float) -> str:
    """Return the line of an event, with the end of its source as its speed requires.

    An event whose source and record already differ in length, a freeze and an event at normal speed
    are returned unchanged. `speed` is in frames of the source per second.
    """
    time = import_extra("opentimelineio").opentime
    match = _EVENT.match(event)
    assert match is not None
    source_start, source_stop, record_start, record_stop = (
        time.from_timecode(timecode, round(rate)) for timecode in match.groups()
    )
    has_own_length = source_stop - source_start != record_stop - record_start
    if has_own_length or abs(speed / rate - 1) < _SAME_SPEED or speed == 0:
        return event
    count = max(1, round((source_stop - source_start).value * abs(speed) / rate))
    new_source_stop = source_start + time.RationalTime(count, round(rate))
    source_end: str = time.to_timecode(new_source_stop, round(rate))
    return event[: match.start(2)] + source_end + event[match.end(2) :]
