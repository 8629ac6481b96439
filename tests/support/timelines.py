"""Strategies of OpenTimelineIO timelines with random nesting, rates and steps."""

import opentimelineio as otio
from hypothesis import strategies as st
from opentimelineio.opentime import RationalTime, TimeRange

schema = otio.schema
RATES = (12.0, 24.0, 25.0, 30.0, 48.0)


def span(first: float, count: float, rate: float) -> TimeRange:
    return TimeRange(RationalTime(first, rate), RationalTime(count, rate))


@st.composite
def clips(draw):
    """Draw a clip of numbered pictures that are there at any of its times."""
    media_rate, rate = draw(st.sampled_from(RATES)), draw(st.sampled_from(RATES))
    start, step = draw(st.integers(0, 2000)), draw(st.integers(1, 3))
    available = span(draw(st.integers(0, 90_000)), 5000, media_rate)
    media = schema.ImageSequenceReference(
        "p/", "s.", ".exr", start, step, media_rate, 4, available_range=available
    )
    begin = available.start_time.rescaled_to(rate).ceil()
    first = RationalTime(begin.value + draw(st.integers(1, 20)), rate)
    return schema.Clip("c", media, TimeRange(first, RationalTime(draw(st.integers(1, 30)), rate)))


@st.composite
def gaps(draw):
    return schema.Gap(source_range=span(0, draw(st.integers(1, 12)), draw(st.sampled_from(RATES))))


def trim_randomly(draw, item):
    """Give an item a random source range within its available range, or none. Return the item."""
    full_duration = item.available_range().duration
    frames = int(full_duration.value)
    if frames > 2 and draw(st.booleans()):
        first = draw(st.integers(0, frames - 2))
        item.source_range = span(first, draw(st.integers(1, frames - first)), full_duration.rate)
    return item


@st.composite
def tracks(draw, items):
    track = schema.Track("t", kind=schema.TrackKind.Video)
    track.extend(draw(st.lists(items, min_size=1, max_size=4)))
    return trim_randomly(draw, track)


@st.composite
def stacks(draw, items):
    stack = schema.Stack("n")
    stack.extend(draw(st.lists(tracks(items) | clips(), min_size=1, max_size=3)))
    return trim_randomly(draw, stack)


nested = st.recursive(clips() | gaps(), stacks, max_leaves=6)


@st.composite
def timelines(draw):
    """Draw a timeline of up to three tracks, with clips, gaps and stacks in one another."""
    timeline = schema.Timeline("cut")
    timeline.tracks.extend(draw(st.lists(tracks(nested), min_size=1, max_size=3)))
    return timeline


def expected_frame(item, time: RationalTime) -> int | None:
    """Return the frame that an item shows at one of its times, by OpenTimelineIO; None if none."""
    if not item.trimmed_range().contains(time) or isinstance(item, schema.Gap):
        return None
    if isinstance(item, schema.Clip):
        return item.media_reference.frame_for_time(time)
    for child in reversed(item):
        if item.range_of_child(child).contains(time):
            child_frame = expected_frame(child, item.transformed_time(time, child))
            if child_frame is not None:
                return child_frame
    return None
