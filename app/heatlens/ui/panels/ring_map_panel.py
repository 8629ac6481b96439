"""Draw the mapping of a controller's channels to the rings of the lens, chosen or learnt."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from heatlens.base.errors import InputError
from heatlens.base.printable import printable
from heatlens.live.ring.channel_map import ChannelMap, Ring, channels_of, maps_for, usual_map
from heatlens.model.units import format_distance, parse_distance_m
from heatlens.session.live.ring_hand import RingHand
from heatlens.session.loop.messages import Problem
from heatlens.ui import probe, widgets

Say = Callable[[str], None]

_NONE = "nothing"
_FROM_CAMERA = "as sent by the camera"  # sent in metres, stops or mm, so no channel is needed
_LEARN_EM, _END_EM = 4.0, 5.0
_BEND_TIP = "Above 1 the ring turns slowly at its first end, below 1 slowly at its last."
_ENDS_TIP = "The lens value at both ends of the control, with what the control sends there."


def ring_map_panel(hand: RingHand, unit: str, say: Say) -> None:
    """Draw a row for each ring; nothing until a channel was received."""
    heard = hand.heard
    channels = {} if heard is None or heard.sample is None else channels_of(heard.sample)
    if heard is None or heard.sample is None or not channels:
        return
    imgui.text_disabled("What turns which ring")
    by_ring = {found.ring: found for found in maps_for(heard.sample, hand.maps)}
    for ring in Ring:
        unmapped = _NONE if getattr(heard.sample, str(ring)) is None else _FROM_CAMERA
        _row(hand, ring, by_ring.get(ring), channels, unmapped)
        if ring in by_ring and imgui.tree_node(f"{ring.words}: ends and curve"):
            _range(hand, by_ring[ring], unit, say)
            imgui.tree_pop()


def _row(
    hand: RingHand,
    ring: Ring,
    found: ChannelMap | None,
    channels: dict[str, float],
    unmapped: str,
) -> None:
    """Draw the channel of a ring, and the button to learn it."""
    now = unmapped if found is None else found.channel
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


def _range(hand: RingHand, found: ChannelMap, unit: str, say: Say) -> None:
    """Draw the lens values at the ends of a channel, and the curve between them."""
    try:
        at_low = _end(found, "first end", found.at_low, unit, say)
        at_high = _end(found, "last end", found.at_high, unit, say)
        name = f"bend of {found.ring.words}"
        bend = widgets.slider(name, found.bend, 0.2, 5.0, "%.2f", _BEND_TIP)
        changed = replace(found, at_low=at_low, at_high=at_high, bend=bend)
    except InputError as error:
        say(Problem(error))
        return
    if changed != found:
        hand.map(found.ring, changed)


def _end(found: ChannelMap, words: str, value: float, unit: str, say: Say) -> float:
    sent = found.low if words == "first end" else found.high
    widgets.label(words, f"{_ENDS_TIP} The control sends {sent:.3g} here.")
    if found.ring is Ring.FOCUS:
        shown = format_distance(value, unit)
        return widgets.text_field(f"{words} of focus", shown, value, parse_distance_m, say)
    parse: Callable[[str], float] = lambda text: widgets.parse_number(  # noqa: E731
        text, 0.5, 2000.0, found.ring.words
    )
    return widgets.text_field(f"{words} of {found.ring.words}", f"{value:.4g}", value, parse, say)
