"""Draw the state of the lens ring input: the sender, its rate, and whether the lens follows."""

import math
from dataclasses import dataclass
from uuid import UUID

from imgui_bundle import imgui

from heatlens.base.printable import printable
from heatlens.live.ring.sources import Heard
from heatlens.ui import theme, widgets

_LETTERS = 8  # of the number of a sender
_FIRST_HEARD = "first one heard"


@dataclass(frozen=True)
class RingState:
    """The user's choice: whether the lens follows, and the source (None for the first one)."""

    is_followed: bool
    source: str | None


@dataclass(frozen=True, eq=False)
class RingFacts:
    """What the panel shows: address, received samples, and data that could not be used."""

    address: str
    heard: Heard
    refused: int
    lost: int
    to_picture_s: float | None = None  # latency from a sample to its picture
    fault: str | None = None  # why the last refused datagram was refused


def ring_panel(state: RingState, facts: RingFacts) -> RingState:
    """Draw the panel; return the user's choice."""
    imgui.separator_text("Ring")
    _status(facts)
    is_followed = widgets.check("the lens follows it", state.is_followed, "follow ring")
    by_words = {_FIRST_HEARD: None} | {_words(name): name for name in facts.heard.sources}
    source = state.source
    if len(facts.heard.sources) > 1 or source is not None:
        now = _FIRST_HEARD if source is None else _words(source)
        picked = widgets.choice("source", now, list(by_words))
        source = by_words.get(picked, source)
    return RingState(is_followed, source)


def _words(name: str) -> str:
    """Return the name of a sender; of one that has only a number of 36 digits, its beginning."""
    try:
        return f"sender {str(UUID(name))[:_LETTERS]}"
    except ValueError:
        return printable(name) or "without a name"


def _status(facts: RingFacts) -> None:
    heard = facts.heard
    if heard.sample is None:
        imgui.text_wrapped(f"Listening at {facts.address}; nothing was heard yet.")
    elif heard.is_silent:
        text = f"Silent for {heard.age_s:.0f} s; the lens keeps the values sent last."
        widgets.colored_text(text, theme.colors.bad)
    elif math.isinf(heard.silent_after_s):  # a controller, which sends nothing while unmoved
        imgui.text(f"Turned {heard.age_s:.1f} s ago.")
    else:
        age_ms = 1e3 * heard.age_s
        imgui.text(f"{heard.rate_hz:.0f} samples a second, the last {age_ms:.0f} ms ago")
    if facts.to_picture_s is not None:
        imgui.text(f"{1e3 * facts.to_picture_s:.0f} ms from the ring to the picture")
    if facts.refused or facts.lost:
        imgui.text_disabled(f"{facts.refused} datagrams refused, {facts.lost} samples incomplete")
        if facts.fault and imgui.is_item_hovered():
            imgui.set_tooltip(f"The last one: {facts.fault}.")
