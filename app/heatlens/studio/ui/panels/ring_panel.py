"""Draw the state of the lens ring input, and which channels of a controller turn which rings."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from uuid import UUID

from imgui_bundle import imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.units import format_distance, parse_distance_m
from heatlens.media.live.ring.channel_map import ChannelMap, Ring, channels_of, maps_for, usual_map
from heatlens.media.live.ring.sources import Heard, RingInput
from heatlens.studio.session.live.ring_hand import RingHand
from heatlens.studio.session.messages import reported
from heatlens.studio.ui import probe, texts, theme, widgets

Say = Callable[[str], None]
_LETTERS = 8  # shown characters of a sender's number
_FIRST_HEARD = "first one heard"
_NONE = "nothing"
_FROM_CAMERA = "as sent by the camera"  # sent in metres, stops or mm, so no channel is needed
_LEARN_EM = 4.0
_BEND_TIP = "Above 1 the ring turns slowly at its first end, below 1 slowly at its last."
_ENDS_TIP = "The lens value at each end of the control, and the value that the control sends there."


def ring_panel(hand: RingHand, unit: str, say: Say) -> None:
    """Draw sender, rate and maps, and whether the lens follows; nothing without an input."""
    receiver, heard = hand.receiver, hand.heard
    if receiver is None or heard is None:
        return
    imgui.separator_text("Ring")
    _status(hand, receiver, heard)
    hand.is_followed = widgets.check("the lens follows it", hand.is_followed, "follow ring")
    source = hand.source
    if len(heard.sources) > 1 or source is not None:
        words = {name: _words(name) for name in (*heard.sources, *([source] if source else []))}
        picked = widgets.pick("source", source, {None: _FIRST_HEARD} | words)
        if picked != source:
            hand.listen_to(picked)
    _maps(hand, unit, say)


def _words(name: str) -> str:
    """Return the name of a sender; of one that has only a number of 36 digits, its beginning."""
    try:
        return f"sender {str(UUID(name))[:_LETTERS]}"
    except ValueError:
        return printable(name) or "without a name"


def _status(hand: RingHand, receiver: RingInput, heard: Heard) -> None:
    if heard.sample is None:
        imgui.text_wrapped(f"Listening at {receiver.address}; nothing was heard yet.")
    elif heard.is_silent:
        text = f"Silent for {heard.age_s:.0f} s; the lens keeps the values sent last."
        texts.colored_text(text, theme.colors.bad)
    elif math.isinf(heard.silent_after_s):  # a controller, which sends nothing while unmoved
        imgui.text(f"Turned {heard.age_s:.1f} s ago.")
    else:
        age_ms = 1e3 * heard.age_s
        imgui.text(f"{heard.rate_hz:.0f} samples a second, the last {age_ms:.0f} ms ago")
    if hand.to_picture_s is not None:
        imgui.text(f"{1e3 * hand.to_picture_s:.0f} ms from the ring to the picture")
    refused, lost = receiver.refused, receiver.lost
    if refused or lost:
        imgui.text_disabled(f"{refused} datagrams refused, {lost} samples incomplete")
        texts.tooltip(f"The last one: {receiver.fault}." if receiver.fault else "")


def _maps(hand: RingHand, unit: str, say: Say) -> None:
    """Draw a row for each ring; nothing until a channel was received."""
    heard = hand.heard
    channels = {} if heard is None or heard.sample is None else channels_of(heard.sample)
    if heard is None or heard.sample is None or not channels:
        return
    imgui.text_disabled("What turns which ring")
    by_ring = {entry.ring: entry for entry in maps_for(heard.sample, hand.maps)}
    for ring in Ring:
        unmapped = _NONE if getattr(heard.sample, str(ring)) is None else _FROM_CAMERA
        _row(hand, ring, by_ring.get(ring), channels, unmapped)
        if ring in by_ring and imgui.tree_node(f"{ring.words}: ends and curve"):
            _range(hand, by_ring[ring], unit, say)
            imgui.tree_pop()


def _row(
    hand: RingHand, ring: Ring, entry: ChannelMap | None, channels: dict[str, float], unmapped: str
) -> None:
    """Draw the channel of a ring, and the button to learn it."""
    now = unmapped if entry is None else entry.channel
    width = imgui.get_content_region_avail().x - (_LEARN_EM + 0.5) * imgui.get_font_size()
    widgets.label(ring.words)
    imgui.set_next_item_width(width - widgets.LABEL_EM * imgui.get_font_size())
    names = [unmapped, *dict.fromkeys([*channels, now])]
    if imgui.begin_combo(f"##channel of {ring.words}", printable(now)):
        for index, name in enumerate(dict.fromkeys(names)):
            value = f"  {channels[name]:.3g}" if name in channels else ""
            if imgui.selectable(f"{printable(name)}{value}##{index}", name == now)[0]:
                hand.map(ring, None if name == unmapped else usual_map(name, ring))
        imgui.end_combo()
    probe.note(f"channel of {ring.words}")
    imgui.same_line()
    is_learning = hand.learning is not None and hand.learning.ring is ring
    # The button extends to the right edge, like the fields above and below.
    words = f"{'done' if is_learning else 'learn'}##{ring.words}"
    if widgets.button(words, f"learn {ring.words}", width=-1):
        if is_learning:
            hand.end_learning()
        else:
            hand.learn(ring)


def _range(hand: RingHand, entry: ChannelMap, unit: str, say: Say) -> None:
    """Draw the lens values at the ends of a channel, and the curve between them."""
    with reported(say):
        at_low = _end(entry, "first end", entry.at_low, unit, say)
        at_high = _end(entry, "last end", entry.at_high, unit, say)
        name = f"bend of {entry.ring.words}"
        bend = widgets.slider(name, entry.bend, 0.2, 5.0, "%.2f", _BEND_TIP)
        changed = replace(entry, at_low=at_low, at_high=at_high, bend=bend)
        if changed != entry:
            hand.map(entry.ring, changed)


def _end(entry: ChannelMap, words: str, value: float, unit: str, say: Say) -> float:
    sent = entry.low if words == "first end" else entry.high
    widgets.label(words, f"{_ENDS_TIP} The control sends {sent:.3g} here.")
    if entry.ring is Ring.FOCUS:
        shown = format_distance(value, unit)
        return widgets.text_field(f"{words} of focus", shown, value, parse_distance_m, say)
    parse = partial(widgets.parse_number, low=0.5, high=2000.0, what=entry.ring.words)
    return widgets.text_field(f"{words} of {entry.ring.words}", f"{value:.4g}", value, parse, say)
