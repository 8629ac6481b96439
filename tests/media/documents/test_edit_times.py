"""Compare the times of an edit (nesting, rates, steps, speeds) with OpenTimelineIO itself."""

from pathlib import Path

import opentimelineio as otio
import pytest
from hypothesis import assume, given, settings
from opentimelineio.opentime import RationalTime

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import EditOptions, Reel
from heatlens.media.documents.edit_file import read_edit, reel_of_timeline
from heatlens.media.documents.edit_out import ExportedShot, write_edit
from heatlens.media.sequence.names import NameForm
from support.exports import shot_of
from support.timelines import expected_frame, schema, span, timelines


def reel_of(timeline) -> Reel:
    return reel_of_timeline(Path("/nowhere/cut.otio"), timeline, EditOptions())


def timeline_of_track(*items, source_range=None):
    """Return a timeline with one picture track of these items."""
    timeline = schema.Timeline("cut")
    track = schema.Track("V1", kind=schema.TrackKind.Video)
    track.extend(items)
    track.source_range = source_range
    timeline.tracks.append(track)
    return timeline


def clip(first, count, rate=24, *, start=1001, available=1001, media_rate=24, step=1, speed=None):
    media = schema.ImageSequenceReference(
        "p/", "s.", ".exr", start, step, media_rate, 4, available_range=span(available, 400, 24)
    )
    new_clip = schema.Clip("sh", media, span(first, count, rate))
    if speed is not None:
        effect = schema.LinearTimeWarp(time_scalar=speed) if speed else schema.FreezeFrame()
        new_clip.effects.append(effect)
    return new_clip


def shown_frames(reel: Reel) -> list[int | None]:
    """Return the source frame for each frame of the cut; None where the cut is empty."""
    gaps, frames = dict(reel.gaps), list[int | None]()
    for number, shot in enumerate(reel.shots):
        frames += [None] * gaps.get(number, 0) + list(shot.source_frames)
    return frames + [None] * gaps.get(len(reel.shots), 0)


@settings(max_examples=150)
@given(timelines())
def test_reel_frames_match_opentimelineio_for_any_timeline(timeline):
    try:
        reel = reel_of(timeline)
    except InputError as error:
        assert "no clip" in str(error) or "no shot" in str(error)  # none lasts a frame
        assume(False)
    for number, frame in enumerate(shown_frames(reel)):
        time = RationalTime(number + 1e-5, reel.frames_per_second)  # beyond errors of rounding
        expected = expected_frame(timeline.tracks, time)
        if frame is None or expected is None:
            assert frame is expected, number
        else:
            assert 0 <= expected - frame < 3, number  # a step: the picture that is there


@pytest.mark.parametrize(
    ("item", "expected_range", "expected_shown"),
    [
        (clip(5, 5, 12, start=1, available=0, step=2), "11-19x2", [11, 13, 15, 17, 19]),
        (clip(10, 10, 30, start=1, available=0), "9-16", [9, 9, 10, 11, 12, 13, 13, 14, 15, 16]),
        (clip(1005, 3, speed=2.0), "1005-1010", [1005, 1007, 1009]),
        (clip(1005, 4, speed=0.5), "1005-1006", [1005, 1005, 1006, 1006]),
        (clip(1005, 3, speed=0.0), "1005-1005", [1005, 1005, 1005]),
        (clip(1005, 3, speed=-1.0), "1005-1007", [1007, 1006, 1005]),
    ],
    ids=["step", "rate", "fast", "slow", "held", "backwards"],
)
def test_reel_shot_renders_each_frame_once_and_edit_repeats_or_drops_it(
    tmp_path, item, expected_range, expected_shown
):
    """The edit that is written is as long as the cut and plays the same frames."""
    reel = reel_of(
        timeline_of_track(item, schema.Gap(source_range=span(0, 4, item.duration().rate)))
    )
    (shot,) = reel.shots
    assert (shot.exported_frames, list(shot.source_frames)) == (expected_range, expected_shown)
    assert dict(reel.gaps) == {1: 4}
    exported = ExportedShot(
        shot=shot_of("x"),
        folder=tmp_path,
        form=NameForm(prefix="s.", padding=4, suffix=".exr"),
        frames=shot.frames,
        cut=shot.frames,
        retime=shot.retime,
    )
    write_edit(tmp_path / "out.otio", reel, {shot.name: exported})
    read_back = otio.adapters.read_from_file(str(tmp_path / "out.otio"))
    assert read_back.duration().value == len(expected_shown) + 4
    assert shown_frames(reel_of(read_back)) == [*expected_shown, None, None, None, None]


def test_reel_respects_source_range_of_track_and_stack():
    item = clip(1005, 20)
    (shot,) = reel_of(timeline_of_track(item, source_range=span(4, 5, 24))).shots
    assert shot.frames == FrameRange(1009, 1013)
    inner = schema.Track("in", kind=schema.TrackKind.Video)
    inner.append(clip(1005, 20))
    (shot,) = reel_of(timeline_of_track(schema.Stack("n", [inner], span(3, 6, 24)))).shots
    assert shot.frames == FrameRange(1008, 1013)


def test_reel_applies_speed_of_stack_to_its_items():
    """A negative speed shows the last item first."""
    stack = schema.Stack("n", [clip(1001, 8)], span(0, 4, 24))
    stack.effects.append(schema.LinearTimeWarp(time_scalar=2.0))
    assert shown_frames(reel_of(timeline_of_track(stack))) == [1001, 1003, 1005, 1007]
    inner = schema.Track("in", kind=schema.TrackKind.Video)
    inner.extend([clip(1001, 2), clip(1101, 2)])
    reversed_stack = schema.Stack("n", [inner])
    reversed_stack.effects.append(schema.LinearTimeWarp(time_scalar=-1.0))
    assert shown_frames(reel_of(timeline_of_track(reversed_stack))) == [1102, 1101, 1002, 1001]


def test_reel_ignores_longer_sound_and_disabled_clips():
    timeline = timeline_of_track(clip(1001, 4))
    sound = schema.Track("A1", kind=schema.TrackKind.Audio)
    sound.append(clip(1, 40))
    off = schema.Track("V2", kind=schema.TrackKind.Video)
    off.append(clip(1201, 4))
    off[0].enabled = False
    timeline.tracks.extend([sound, off])
    assert shown_frames(reel_of(timeline)) == [1001, 1002, 1003, 1004]


@pytest.mark.parametrize("count", [10**9, 10**12])
def test_read_edit_rejects_too_long_cut_before_building_it(tmp_path, count):
    path = tmp_path / "a.otio"
    gap = schema.Gap(source_range=span(0, count, 24))
    otio.adapters.write_to_file(timeline_of_track(gap, clip(1, 4)), str(path))
    with pytest.raises(InputError, match=r"at most 1,000,000"):
        read_edit(path, EditOptions())


def test_read_edit_reports_any_library_error_in_one_sentence(tmp_path):
    """The edits have a missing reference, a clip without any range and a rate of zero."""
    wrong = clip(1, 4)
    bare = schema.Clip("bare", schema.ExternalReference("x.####.exr"))
    still = clip(1, 4, rate=0)
    for number, item in enumerate((wrong, bare, still)):
        path = tmp_path / f"{number}.otio"
        otio.adapters.write_to_file(timeline_of_track(item), str(path))
        key = '"active_media_reference_key": "DEFAULT_MEDIA"'
        text = path.read_text()
        assert key in text
        if item is wrong:
            path.write_text(text.replace(key, '"active_media_reference_key": "%9d"'))
        try:
            read_edit(path, EditOptions())
        except InputError as error:
            assert str(path) in str(error) and "\n" not in str(error)
