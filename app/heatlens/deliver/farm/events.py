"""Read the events that `heatlens export --progress json` prints while it works."""

import json
from typing import Any

_EVENTS = ("begin", "frame", "end", "failed")
Event = dict[str, Any]


def event_in(line: str | bytes) -> Event | None:
    """Return the event in a printed line; None for any other line, such as one of a driver."""
    try:
        event = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return event if isinstance(event, dict) and event.get("event") in _EVENTS else None
