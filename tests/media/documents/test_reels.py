"""Reels and edits: every clip of a cut becomes a shot with the frames that the cut shows."""

import json

import opentimelineio as otio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from opentimelineio.opentime import RationalTime, TimeRange

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import Reel, ReelShot, Retime, named_apart, shot_name
from heatlens.media.documents.edit_file import EditOptions, read_edit
from heatlens.media.documents.edit_out import Exported, write_edit
from heatlens.media.documents.reel_file import is_reel, read_reel, write_reel
from heatlens.media.sequence.names import NameForm
from support.exports import shot_of, write_plate

GRADE = Grade((1.1, 1.0, 0.9), (0.0, 0.01, -0.02), (1.0, 1.1, 0.9), 0.8)
schema = otio.schema
RATE = 24


def times(first: float, count: float, rate: float = RATE) -> TimeRange:
    return TimeRange(RationalTime(first, rate), RationalTime(count, rate))


def plates(folder, name: str, frames=range(1001, 1005), **header):
    (folder / name).mkdir(parents=True)
    for frame in frames:
        write_plate(folder / name / f"{name}.{frame}.exr", **header)
    return folder / name


def by_url(name: str, url: str, available, source) -> otio.schema.Clip:
    return schema.Clip(name, schema.ExternalReference(url, available), source)


def cut_of(path, *items, start=None, tracks=()):
    """Write an edit of one picture track, with `tracks` above it."""
    timeline = schema.Timeline("cut", global_start_time=start)
    for content in (items, *tracks):
        track = schema.Track(kind=schema.TrackKind.Video)
        track.extend(content)
        timeline.tracks.append(track)
    otio.adapters.write_to_file(timeline, str(path))
    return path


def read(path, *folders, rate=None) -> Reel:
    return read_edit(path, EditOptions(tuple(folders), rate))


RETIMED = {"name": "a", "source": "x", "frames": "1-4"}
URLS = ("{url}/sh010.%04d.exr", "{url}/sh010.####.exr", "{url}/sh010.1001.exr", "sh010/sh010.#.exr")


@pytest.mark.parametrize("form", URLS)
def test_a_clip_shows_the_frames_of_the_cut(tmp_path, form):
    """The clock of the media begins anywhere; its first time is the first frame."""
    folder = plates(tmp_path, "sh010")
    clip = by_url("sh010", form.format(url=folder.as_uri()), times(86400, 4), times(86401, 2))
    (shot,) = read(cut_of(tmp_path / "a.otio", clip)).shots
    assert (shot.source, shot.frames) == (str(folder / "sh010.####.exr"), FrameRange(1002, 1003))
    assert not shot.notes


def test_a_reference_to_numbered_pictures_counts_from_its_first(tmp_path):
    folder = plates(tmp_path, "sh010")
    media = schema.ImageSequenceReference(
        f"{folder}/", "sh010.", ".exr", 1001, 1, RATE, 4, available_range=times(0, 4)
    )
    (shot,) = read(cut_of(tmp_path / "a.otio", schema.Clip("x", media, times(1, 3)))).shots
    assert (shot.source, shot.frames) == (str(folder / "sh010.####.exr"), FrameRange(1002, 1004))


@pytest.mark.parametrize(
    ("header", "start", "first", "is_doubted"),
    [
        ({}, 1002, 1002, False),
        ({"timecode": "01:00:00:00"}, 86401, 1002, False),
        ({}, 86401, 1001, True),
    ],
    ids=["number", "timecode", "neither"],
)
def test_media_without_a_clock_go_by_frame_number_then_by_timecode(
    tmp_path, header, start, first, is_doubted
):
    folder = plates(tmp_path, "sh010", **header)
    clip = by_url("sh010", f"{folder}/sh010.####.exr", None, times(start, 2))
    (shot,) = read(cut_of(tmp_path / "a.otio", clip)).shots
    assert shot.frames == FrameRange(first, first + 1)
    assert bool(shot.notes) == is_doubted


def test_an_edl_names_media_that_are_searched(tmp_path):
    folder = plates(tmp_path / "show", "sh010")
    clip = by_url("sh010", "sh010.mov", None, times(1002, 2))
    path = cut_of(tmp_path / "a.edl", clip)
    assert read(path).missing
    (shot,) = read(path, tmp_path / "show").shots
    assert (shot.source, shot.frames) == (str(folder / "sh010.####.exr"), FrameRange(1002, 1003))


@pytest.mark.parametrize("suffix", [".otio", ".edl", ".xml"])
def test_every_kind_of_edit_gives_the_same_shots(tmp_path, suffix):
    folder = plates(tmp_path, "sh010")
    clips = [
        by_url("sh010", (folder / "sh010.1001.exr").as_uri(), times(1001, 4), times(at, 2))
        for at in (1001, 1003)
    ]
    for clip in clips:
        clip.media_reference.name = "sh010"
    reel = read(cut_of(tmp_path / f"a{suffix}", *clips, start=RationalTime(0, RATE)))
    assert [shot.name for shot in reel.shots] == ["sh010", "sh010_2"]
    assert [str(shot.frames) for shot in reel.shots] == ["1001-1002", "1003-1004"]
    assert {shot.source for shot in reel.shots} == {str(folder / "sh010.####.exr")}


def test_what_a_reel_cannot_hold_is_told(tmp_path):
    folder = plates(tmp_path, "sh010")
    url = f"{folder}/sh010.####.exr"

    def clip(name, *effects):
        made = by_url(name, url, times(1001, 4), times(1001, 2))
        made.effects.extend(effects)
        return made

    fast = clip("fast", schema.LinearTimeWarp(time_scalar=2.0))
    held = clip("held", schema.FreezeFrame())
    marked = clip("marked")
    for text in ("A=2.4m", "B = 6'3\"", "x=y", "eyes"):
        marked.markers.append(schema.Marker(text, times(1001, 1)))
    fade = schema.Transition(in_offset=RationalTime(1, RATE), out_offset=RationalTime(1, RATE))
    gone = by_url("gone", "/nowhere/x.####.exr", times(1, 9), times(1, 2))
    nest = schema.Stack("nest", children=[clip("inner")], source_range=times(0, 2))
    gap = schema.Gap(source_range=times(0, 5))
    path = cut_of(tmp_path / "a.otio", fast, gap, held, fade, marked, gone, nest)
    reel = read(path)
    by_name = {shot.name: shot for shot in reel.shots}
    assert (
        by_name["fast"].frames == FrameRange(1001, 1004) and "2 times" in by_name["fast"].notes[0]
    )
    assert by_name["held"].frames == FrameRange(1001, 1001) and "holds" in by_name["held"].notes[0]
    assert "--handles 1" in by_name["held"].notes[1] and "--handles 1" in by_name["marked"].notes[0]
    assert by_name["marked"].marks == ("A=2.4m", "B=6'3\"")
    assert by_name["marked"].notes[1:] == ("marker: x=y", "marker: eyes")
    assert [shot.name for shot in reel.missing] == ["gone"]
    assert by_name["inner"].frames == FrameRange(1001, 1002)
    assert "/nowhere/x.####.exr" in by_name["gone"].notes[0]
    assert reel.gaps == ((1, 5),)


def test_the_tracks_of_an_edl_begin_where_they_were_recorded(tmp_path):
    path = tmp_path / "a.edl"
    event = "{}  sh010  {}  C  00:00:41:17 00:00:41:22 01:00:{}:00 01:00:{}:05\n"
    events = (("001", "V", "02", "02"), ("002", "V2", "03", "03"))
    path.write_text("TITLE: cut\n" + "".join(event.format(*words) for words in events))
    reel = read(path)
    assert (reel.start_timecode, reel.gaps) == ("01:00:02:00", ((1, 19),))
    assert [shot.count for shot in reel.shots] == [5, 5]


@pytest.mark.parametrize("suffix", [".otio", ".edl"])
def test_a_grade_of_the_edit_is_that_of_the_shot(tmp_path, suffix):
    """In an EDL it stands as *ASC_SOP and *ASC_SAT."""
    folder = plates(tmp_path, "sh010")
    clip = by_url("sh010", f"{folder}/sh010.####.exr", None, times(1001, 2))
    sop = {"slope": [1.1, 1.0, 0.9], "offset": [0.0, 0.01, -0.02], "power": [1.0, 1.1, 0.9]}
    clip.metadata["cdl"] = {"asc_sat": 0.8, "asc_sop": sop}
    (shot,) = read(cut_of(tmp_path / f"a{suffix}", clip), tmp_path).shots
    assert shot.grade == GRADE
    assert not any("CDL" in note for note in shot.notes)


@pytest.mark.parametrize("told", [3, {"asc_sop": {"slope": "abc"}}, {"asc_sat": -1}])
def test_a_grade_that_cannot_be_is_told(tmp_path, told):
    folder = plates(tmp_path, "sh010")
    clip = by_url("sh010", f"{folder}/sh010.####.exr", None, times(1001, 2))
    clip.metadata["cdl"] = told
    (shot,) = read(cut_of(tmp_path / "a.otio", clip)).shots
    assert shot.grade is None and any("CDL" in note for note in shot.notes)


def test_the_topmost_clip_is_seen(tmp_path):
    folder = plates(tmp_path, "sh010")
    url = f"{folder}/sh010.####.exr"
    low, high = (by_url(n, url, times(1001, 4), times(1001, 2)) for n in ("low", "high"))
    assert [s.name for s in read(cut_of(tmp_path / "a.otio", low, tracks=[[high]])).shots] == [
        "high"
    ]


def test_a_reel_is_the_same_after_writing(tmp_path):
    """Sources are relative in the file, and the demo stays a name."""
    shots = (
        ReelShot(
            "a",
            str(tmp_path / "p" / "a.####.exr"),
            FrameRange(3, 9),
            ("note",),
            ("A=2m",),
            GRADE,
            Retime(9.0, -1.5, 5, 2),
        ),
        ReelShot("b", "demo"),
        ReelShot("c", "", None, ("its media are missing",)),
    )
    reel = Reel("cut", shots, 25.0, "01:00:00:00", ((1, 7), (3, 2)))
    path = tmp_path / "cut.heatreel.json"
    write_reel(path, reel)
    assert read_reel(path) == reel
    assert json.loads(path.read_text())["shots"][0]["source"] == "p/a.####.exr"


@pytest.mark.parametrize(
    ("entries", "place"),
    [
        ({"shots": []}, "no shot"),
        ({"shots": [{"name": "a"}]}, "'source'"),
        ({"shots": [{"name": "a/b", "source": "x"}]}, "shots[0]"),
        ({"shots": [{"name": "a", "source": "x", "frames": "9-3"}]}, "shots[0].frames"),
        ({"shots": [{"name": "a", "source": "x"}] * 2}, "called a"),
        ({"shots": [{"name": "a", "source": "x"}], "frames_per_second": 0}, "above 0"),
        ({}, "'shots'"),
        ({"shots": [{"name": "a", "source": "x", "gap_before": 10**9}]}, "at most 1,000,000"),
        ({"shots": [{"name": "a", "source": "x", "gap_before": -1}]}, "at least one"),
        (
            {"shots": [{"name": "a", "source": "x", "gap_before": 600_000}], "gap_after": 600_000},
            "at",
        ),
        ({"shots": [{"name": n, "source": "x", "frames": "1-999999"} for n in "ab"]}, "1,999,998"),
        ({"shots": [RETIMED | {"retime": {"start": 1, "speed": 1, "count": 10**9}}]}, "at most"),
    ],
)
def test_a_damaged_reel_is_refused_with_its_place(tmp_path, entries, place):
    path = tmp_path / "r.heatreel.json"
    path.write_text(json.dumps({"heatlens_reel": 1, **entries}))
    with pytest.raises(InputError) as refusal:
        read_reel(path)
    assert str(path) in str(refusal.value) and place in str(refusal.value)


@pytest.mark.parametrize("name", ["a.otio", "a.edl", "a.xml", "a.aaf", "a.otioz"])
@pytest.mark.parametrize("content", [b"", b"x", b"{}", b"<a", b'{"OTIO_SCHEMA": "Timeline.1"}'])
def test_a_damaged_edit_is_refused_by_name(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert is_reel(str(path))
    with pytest.raises(InputError) as refusal:
        read(path)
    assert str(path) in str(refusal.value)


@pytest.mark.parametrize("is_moved", [False, True])
def test_a_whole_aaf_has_its_media_ranges_and_gaps(tmp_path, is_moved):
    """Written by pyaaf2, with the clock of a tape, a gap, and media that lie where --media says."""
    names = ("sh010", "sh020")
    folders = [plates(tmp_path / "media", name, range(1001, 1011)) for name in names]
    starts, shown = (86400, 0), (times(86402, 4), times(3, 5))
    clips = [
        by_url(name, (folder / f"{name}.1001.exr").as_uri(), times(start, 10), part)
        for name, folder, start, part in zip(names, folders, starts, shown, strict=True)
    ]
    track = schema.Track(kind=schema.TrackKind.Video)
    track.extend([clips[0], schema.Gap(source_range=times(0, 5)), clips[1]])
    timeline = schema.Timeline("cut", global_start_time=RationalTime(90000, RATE))
    timeline.tracks.append(track)
    path = tmp_path / "cut.aaf"
    otio.adapters.write_to_file(timeline, str(path), use_empty_mob_ids=True)
    if is_moved:
        (tmp_path / "media").rename(tmp_path / "elsewhere")
        folders = [tmp_path / "elsewhere" / name for name in names]
        assert len(read(path).missing) == 2
    reel = read(path, tmp_path / "elsewhere") if is_moved else read(path)
    assert (reel.start_timecode, reel.gaps) == ("01:02:30:00", ((1, 5),))
    assert [(shot.source, shot.frames) for shot in reel.shots] == [
        (str(folders[0] / "sh010.####.exr"), FrameRange(1003, 1006)),
        (str(folders[1] / "sh020.####.exr"), FrameRange(1004, 1008)),
    ]
    assert not any(shot.notes for shot in reel.shots)


def test_exported_frames_take_the_place_of_the_plates(tmp_path):
    """What is written reads back with the same cut, and has the pulls as markers."""
    folder = plates(tmp_path, "sh010", range(1001, 1007))
    shot = shot_of("x")
    reel = Reel("cut", (ReelShot("sh010", "x", FrameRange(1002, 1006)),), 25.0, "01:00:00:00")
    made = Exported(
        shot, folder, NameForm("sh010.", 4, ".exr"), FrameRange(1001, 1006), FrameRange(1002, 1006)
    )
    write_edit(tmp_path / "out.otio", reel, {"sh010": made})
    back = read(tmp_path / "out.otio")
    assert (back.frames_per_second, back.start_timecode) == (25.0, "01:00:00:00")
    assert [(s.source, s.frames) for s in back.shots] == [
        (str(folder / "sh010.####.exr"), FrameRange(1002, 1006))
    ]
    assert back.shots[0].notes == ("marker: focus 3 m",)


@given(st.text(max_size=30))
def test_every_name_of_a_clip_becomes_the_name_of_a_file(text):
    ReelShot(shot_name(text), "x")


@given(st.lists(st.sampled_from(["a", "a_2", "b"]), min_size=1, max_size=8))
def test_shots_of_one_name_are_told_apart(names):
    shots = named_apart(tuple(ReelShot(name, "x") for name in names))
    assert len({shot.name for shot in shots}) == len(names)
