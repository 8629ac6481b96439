"""The times of an edit: nestings, rates, steps and speeds, beside OpenTimelineIO itself."""

from pathlib import Path

import opentimelineio as otio
import pytest
from hypothesis import assume, given, settings
from opentimelineio.opentime import RationalTime

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import Reel
from heatlens.media.documents.edit_file import EditOptions, read_edit, reel_of_timeline
from heatlens.media.documents.edit_out import Exported, write_edit
from heatlens.media.sequence.names import NameForm
from support.exports import shot_of
from support.timelines import frame_shown, schema, span, timelines


def reel_of(timeline) -> Reel:
    return reel_of_timeline(Path("/nowhere/cut.otio"), timeline, EditOptions())


def of_track(*items, source_range=None):
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
    made = schema.Clip("sh", media, span(first, count, rate))
    if speed is not None:
        effect = schema.LinearTimeWarp(time_scalar=speed) if speed else schema.FreezeFrame()
        made.effects.append(effect)
    return made


def shown_in(reel: Reel) -> list[int | None]:
    """Return the frame for each frame of the cut; None where it is empty."""
    gaps, found = dict(reel.gaps), list[int | None]()
    for number, shot in enumerate(reel.shots):
        found += [None] * gaps.get(number, 0) + list(shot.shown)
    return found + [None] * gaps.get(len(reel.shots), 0)


@settings(max_examples=150)
@given(timelines())
def test_every_frame_of_a_cut_is_that_of_opentimelineio(timeline):
    try:
        reel = reel_of(timeline)
    except InputError as error:
        assert "no clip" in str(error) or "no shot" in str(error)  # none lasts a frame
        assume(False)
    for number, frame in enumerate(shown_in(reel)):
        time = RationalTime(number + 1e-5, reel.frames_per_second)  # beyond errors of rounding
        expected = frame_shown(timeline.tracks, time)
        if frame is None or expected is None:
            assert frame is expected, number
        else:
            assert 0 <= expected - frame < 3, number  # a step: the picture that is there


@pytest.mark.parametrize(
    ("item", "made", "shown"),
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
def test_files_are_made_once_and_the_cut_holds_or_drops_them(tmp_path, item, made, shown):
    """What is written for the editor is as long as the cut, and plays the same frames."""
    reel = reel_of(of_track(item, schema.Gap(source_range=span(0, 4, item.duration().rate))))
    (shot,) = reel.shots
    assert (shot.made, list(shot.shown)) == (made, shown)
    assert dict(reel.gaps) == {1: 4}
    exported = Exported(
        shot_of("x"), tmp_path, NameForm("s.", 4, ".exr"), shot.frames, shot.frames, shot.retime
    )
    write_edit(tmp_path / "out.otio", reel, {shot.name: exported})
    back = otio.adapters.read_from_file(str(tmp_path / "out.otio"))
    assert back.duration().value == len(shown) + 4
    assert shown_in(reel_of(back)) == [*shown, None, None, None, None]


def test_a_range_of_a_track_and_of_a_stack_are_heeded():
    item = clip(1005, 20)
    (shot,) = reel_of(of_track(item, source_range=span(4, 5, 24))).shots
    assert shot.frames == FrameRange(1009, 1013)
    inner = schema.Track("in", kind=schema.TrackKind.Video)
    inner.append(clip(1005, 20))
    (shot,) = reel_of(of_track(schema.Stack("n", [inner], span(3, 6, 24)))).shots
    assert shot.frames == FrameRange(1008, 1013)


def test_a_speed_of_a_stack_is_that_of_what_it_holds():
    """Backwards too, where the last item is seen first."""
    stack = schema.Stack("n", [clip(1001, 8)], span(0, 4, 24))
    stack.effects.append(schema.LinearTimeWarp(time_scalar=2.0))
    assert shown_in(reel_of(of_track(stack))) == [1001, 1003, 1005, 1007]
    inner = schema.Track("in", kind=schema.TrackKind.Video)
    inner.extend([clip(1001, 2), clip(1101, 2)])
    back = schema.Stack("n", [inner])
    back.effects.append(schema.LinearTimeWarp(time_scalar=-1.0))
    assert shown_in(reel_of(of_track(back))) == [1102, 1101, 1002, 1001]


def test_longer_sound_and_what_is_switched_off_are_not_seen():
    timeline = of_track(clip(1001, 4))
    sound = schema.Track("A1", kind=schema.TrackKind.Audio)
    sound.append(clip(1, 40))
    off = schema.Track("V2", kind=schema.TrackKind.Video)
    off.append(clip(1201, 4))
    off[0].enabled = False
    timeline.tracks.extend([sound, off])
    assert shown_in(reel_of(timeline)) == [1001, 1002, 1003, 1004]


@pytest.mark.parametrize("count", [10**9, 10**12])
def test_a_cut_that_is_too_long_is_refused_before_it_is_laid_out(tmp_path, count):
    path = tmp_path / "a.otio"
    gap = schema.Gap(source_range=span(0, count, 24))
    otio.adapters.write_to_file(of_track(gap, clip(1, 4)), str(path))
    with pytest.raises(InputError, match=r"at most 1,000,000"):
        read_edit(path, EditOptions())


def test_whatever_the_library_raises_is_one_sentence(tmp_path):
    """A reference that is not there, a clip without any range, a rate of zero."""
    wrong = clip(1, 4)
    bare = schema.Clip("bare", schema.ExternalReference("x.####.exr"))
    still = clip(1, 4, rate=0)
    for number, item in enumerate((wrong, bare, still)):
        path = tmp_path / f"{number}.otio"
        otio.adapters.write_to_file(of_track(item), str(path))
        key = '"active_media_reference_key": "DEFAULT_MEDIA"'
        text = path.read_text()
        assert key in text
        if item is wrong:
            path.write_text(text.replace(key, '"active_media_reference_key": "%9d"'))
        try:
            read_edit(path, EditOptions())
        except InputError as error:
            assert str(path) in str(error) and "\n" not in str(error)
