"""Draw the state of the lens ring input, and which channels of a controller turn which rings."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from uuid import UUID

from imgui_bundle import imgui

from heatlens.core.base.messages import report_errors
from heatlens.core.base.outside_text import printable
from heatlens.core.model.units import format_distance, parse_distance_m
from heatlens.media.live.ring.channel_map import (
    ChannelMap,
    Ring,
    channels_of,
    default_map,
    maps_for,
)
from heatlens.media.live.ring.sources import RingInput, SourceState
from heatlens.studio.board.controls import LensControl
from heatlens.studio.ui import rects, texts, theme, widgets

Notify = Callable[[str], None]
_ID_LETTERS = 8  # shown characters of a sender's number
_FIRST_SENDER = "first one heard"
_NONE = "nothing"
_FROM_CAMERA = "as sent by the camera"  # sent in meters, stops or mm, so no channel is needed
_LEARN_EM = 4.0
_BEND_TIP = "Above 1 the ring turns slowly at its first end, below 1 slowly at its last."
_ENDS_TIP = "The lens value at each end of the control, and the value that the control sends there."


def ring_panel(control: LensControl, unit: str, notify: Notify) -> None:
    """Draw sender, rate and maps, and whether the lens follows; nothing without an input."""
    receiver, ring_state = control.ring.receiver, control.ring.heard
    if receiver is None or ring_state is None:
        return
    imgui.separator_text("Ring")
    _status_rows(control, receiver, ring_state)
    control.ring.is_followed = widgets.check(
        "the lens follows it", control.ring.is_followed, "follow ring"
    )
    source = control.ring.source
    if len(ring_state.sources) > 1 or source is not None:
        sender_names = {
            name: _sender_name(name)
            for name in (*ring_state.sources, *([source] if source else []))
        }
        picked_source = widgets.pick("source", source, {None: _FIRST_SENDER} | sender_names)
        if picked_source != source:
            control.ring.listen_to(picked_source)
    _map_rows(control, unit, notify)


def _sender_name(name: str) -> str:
    """Return the name of a sender; only the beginning of a name that is a UUID."""
    try:
        return f"sender {str(UUID(name))[:_ID_LETTERS]}"
    except ValueError:
        return printable(name) or "without a name"


def _status_rows(control: LensControl, receiver: RingInput, ring_state: SourceState) -> None:
    """Draw the rate and age of the samples, the latency, and how many samples were lost."""
    if ring_state.sample is None:
        imgui.text_wrapped(f"Listening at {receiver.address}; nothing was heard yet.")
    elif ring_state.is_silent:
        text = f"Silent for {ring_state.age_s:.0f} s; the lens keeps the values sent last."
        texts.colored_text(text, theme.colors.bad)
    elif math.isinf(ring_state.silent_after_s):  # a controller, which sends nothing while unmoved
        imgui.text(f"Turned {ring_state.age_s:.1f} s ago.")
    else:
        age_ms = 1e3 * ring_state.age_s
        imgui.text(f"{ring_state.rate_hz:.0f} samples a second, the last {age_ms:.0f} ms ago")
    if control.ring.median_latency_s is not None:
        imgui.text(f"{1e3 * control.ring.median_latency_s:.0f} ms from the ring to the picture")
    refused_count, lost_count = receiver.refused, receiver.lost
    if refused_count or lost_count:
        imgui.text_disabled(f"{refused_count} datagrams refused, {lost_count} samples incomplete")
        texts.tooltip(f"The last one: {receiver.fault}." if receiver.fault else "")


def _map_rows(control: LensControl, unit: str, notify: Notify) -> None:
    """Draw a row for each ring; nothing until a channel was received."""
    ring_state = control.ring.heard
    channels = (
        {} if ring_state is None or ring_state.sample is None else channels_of(ring_state.sample)
    )
    if ring_state is None or ring_state.sample is None or not channels:
        return
    imgui.text_disabled("What turns which ring")
    by_ring = {entry.ring: entry for entry in maps_for(ring_state.sample, control.ring.maps)}
    for ring in Ring:
        unmapped_words = _NONE if getattr(ring_state.sample, str(ring)) is None else _FROM_CAMERA
        _channel_row(control, ring, by_ring.get(ring), channels, unmapped_words)
        if ring in by_ring and imgui.tree_node(f"{ring.words}: ends and curve"):
            _range_rows(control, by_ring[ring], unit, notify)
            imgui.tree_pop()


def _channel_row(
    control: LensControl,
    ring: Ring,
    entry: ChannelMap | None,
    channels: dict[str, float],
    unmapped_words: str,
) -> None:
    """Draw the channel of a ring, and the button to learn it."""
    current = unmapped_words if entry is None else entry.channel
    width = imgui.get_content_region_avail().x - (_LEARN_EM + 0.5) * imgui.get_font_size()
    widgets.label(ring.words)
    imgui.set_next_item_width(width - widgets.LABEL_EM * imgui.get_font_size())
    names = [unmapped_words, *dict.fromkeys([*channels, current])]
    if imgui.begin_combo(f"##channel of {ring.words}", printable(current)):
        for index, name in enumerate(dict.fromkeys(names)):
            value = f"  {channels[name]:.3g}" if name in channels else ""
            if imgui.selectable(f"{printable(name)}{value}##{index}", name == current)[0]:
                control.ring.set_map(
                    ring, None if name == unmapped_words else default_map(name, ring)
                )
        imgui.end_combo()
    rects.note(f"channel of {ring.words}")
    imgui.same_line()
    is_learning = control.ring.learning is not None and control.ring.learning.ring is ring
    # The button extends to the right edge, like the fields above and below.
    words = f"{'done' if is_learning else 'learn'}##{ring.words}"
    if widgets.button(words, f"learn {ring.words}", width=-1):
        if is_learning:
            control.ring.end_learning()
        else:
            control.ring.learn(ring)


def _range_rows(control: LensControl, entry: ChannelMap, unit: str, notify: Notify) -> None:
    """Draw the lens values at the ends of a channel, and the curve between them."""
    with report_errors(notify):
        at_low = _end_field(entry, "first end", entry.at_low, unit, notify)
        at_high = _end_field(entry, "last end", entry.at_high, unit, notify)
        name = f"bend of {entry.ring.words}"
        bend = widgets.slider(name, entry.bend, 0.2, 5.0, "%.2f", _BEND_TIP)
        new_entry = replace(entry, at_low=at_low, at_high=at_high, bend=bend)
        if new_entry != entry:
            control.ring.set_map(entry.ring, new_entry)


def _end_field(entry: ChannelMap, words: str, value: float, unit: str, notify: Notify) -> float:
    """Draw the field for the lens value at an end of a channel; return the changed value."""
    sent_value = entry.low if words == "first end" else entry.high
    widgets.label(words, f"{_ENDS_TIP} The control sends {sent_value:.3g} here.")
    if entry.ring is Ring.FOCUS:
        value_text = format_distance(value, unit)
        return widgets.text_field(f"{words} of focus", value_text, value, parse_distance_m, notify)
    parse = partial(widgets.parse_number, low=0.5, high=2000.0, quantity=entry.ring.words)
    return widgets.text_field(
        f"{words} of {entry.ring.words}", f"{value:.4g}", value, parse, notify
    )
