"""Test reels and edits: each clip of a cut becomes a shot with the frames that the cut shows."""

import json

import opentimelineio as otio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from opentimelineio.opentime import RationalTime, TimeRange

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import (
    EditOptions,
    Reel,
    ReelShot,
    Retime,
    shot_name,
    with_unique_names,
)
from heatlens.media.documents.edit_file import read_edit
from heatlens.media.documents.edit_out import ExportedShot, write_edit
from heatlens.media.documents.reel_file import is_reel, read_reel, write_reel
from heatlens.media.sequence.names import NameForm
from support.exports import shot_of, write_plate

GRADE = Grade((1.1, 1.0, 0.9), (0.0, 0.01, -0.02), (1.0, 1.1, 0.9), 0.8)
schema = otio.schema
RATE = 24


def time_range(first: float, count: float, rate: float = RATE) -> TimeRange:
    return TimeRange(RationalTime(first, rate), RationalTime(count, rate))


def write_plates(folder, name: str, frames=range(1001, 1005), **header):
    (folder / name).mkdir(parents=True)
    for frame in frames:
        write_plate(folder / name / f"{name}.{frame}.exr", **header)
    return folder / name


def clip_of_url(name: str, url: str, available, source) -> otio.schema.Clip:
    return schema.Clip(name, schema.ExternalReference(url, available), source)


def write_cut(path, *items, start=None, tracks=()):
    """Write an edit of one picture track, with `tracks` above it."""
    timeline = schema.Timeline("cut", global_start_time=start)
    for content in (items, *tracks):
        track = schema.Track(kind=schema.TrackKind.Video)
        track.extend(content)
        timeline.tracks.append(track)
    otio.adapters.write_to_file(timeline, str(path))
    return path


def read_cut(path, *folders, rate=None) -> Reel:
    return read_edit(path, EditOptions(tuple(folders), rate))


RETIMED = {"name": "a", "source": "x", "frames": "1-4"}
URLS = ("{url}/sh010.%04d.exr", "{url}/sh010.####.exr", "{url}/sh010.1001.exr", "sh010/sh010.#.exr")


@pytest.mark.parametrize("form", URLS)
def test_read_edit_clip_has_frames_of_the_cut(tmp_path, form):
    """The media's clock may begin anywhere; its first time is the first frame."""
    folder = write_plates(tmp_path, "sh010")
    clip = clip_of_url(
        "sh010", form.format(url=folder.as_uri()), time_range(86400, 4), time_range(86401, 2)
    )
    (shot,) = read_cut(write_cut(tmp_path / "a.otio", clip)).shots
    assert (shot.source, shot.frames) == (str(folder / "sh010.####.exr"), FrameRange(1002, 1003))
    assert not shot.notes


def test_read_edit_image_sequence_reference_counts_from_its_first_frame(tmp_path):
    folder = write_plates(tmp_path, "sh010")
    media = schema.ImageSequenceReference(
        f"{folder}/", "sh010.", ".exr", 1001, 1, RATE, 4, available_range=time_range(0, 4)
    )
    (shot,) = read_cut(
        write_cut(tmp_path / "a.otio", schema.Clip("x", media, time_range(1, 3)))
    ).shots
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
def test_read_edit_media_without_range_uses_frame_number_then_timecode(
    tmp_path, header, start, first, is_doubted
):
    folder = write_plates(tmp_path, "sh010", **header)
    clip = clip_of_url("sh010", f"{folder}/sh010.####.exr", None, time_range(start, 2))
    (shot,) = read_cut(write_cut(tmp_path / "a.otio", clip)).shots
    assert shot.frames == FrameRange(first, first + 1)
    assert bool(shot.notes) == is_doubted


def test_read_edit_searches_media_of_edl_in_folders(tmp_path):
    folder = write_plates(tmp_path / "show", "sh010")
    clip = clip_of_url("sh010", "sh010.mov", None, time_range(1002, 2))
    path = write_cut(tmp_path / "a.edl", clip)
    assert read_cut(path).missing_shots
    (shot,) = read_cut(path, tmp_path / "show").shots
    assert (shot.source, shot.frames) == (str(folder / "sh010.####.exr"), FrameRange(1002, 1003))


@pytest.mark.parametrize("suffix", [".otio", ".edl", ".xml"])
def test_read_edit_gives_same_shots_for_otio_edl_and_xml(tmp_path, suffix):
    folder = write_plates(tmp_path, "sh010")
    clips = [
        clip_of_url(
            "sh010", (folder / "sh010.1001.exr").as_uri(), time_range(1001, 4), time_range(at, 2)
        )
        for at in (1001, 1003)
    ]
    for clip in clips:
        clip.media_reference.name = "sh010"
    reel = read_cut(write_cut(tmp_path / f"a{suffix}", *clips, start=RationalTime(0, RATE)))
    assert [shot.name for shot in reel.shots] == ["sh010", "sh010_2"]
    assert [str(shot.frames) for shot in reel.shots] == ["1001-1002", "1003-1004"]
    assert {shot.source for shot in reel.shots} == {str(folder / "sh010.####.exr")}


def test_read_edit_notes_speeds_transitions_markers_and_missing_media(tmp_path):
    folder = write_plates(tmp_path, "sh010")
    url = f"{folder}/sh010.####.exr"

    def clip(name, *effects):
        new_clip = clip_of_url(name, url, time_range(1001, 4), time_range(1001, 2))
        new_clip.effects.extend(effects)
        return new_clip

    fast_clip = clip("fast", schema.LinearTimeWarp(time_scalar=2.0))
    frozen_clip = clip("held", schema.FreezeFrame())
    marked_clip = clip("marked")
    for text in ("A=2.4m", "B = 6'3\"", "x=y", "eyes"):
        marked_clip.markers.append(schema.Marker(text, time_range(1001, 1)))
    fade = schema.Transition(in_offset=RationalTime(1, RATE), out_offset=RationalTime(1, RATE))
    missing_clip = clip_of_url("gone", "/nowhere/x.####.exr", time_range(1, 9), time_range(1, 2))
    nest = schema.Stack("nest", children=[clip("inner")], source_range=time_range(0, 2))
    gap = schema.Gap(source_range=time_range(0, 5))
    path = write_cut(
        tmp_path / "a.otio", fast_clip, gap, frozen_clip, fade, marked_clip, missing_clip, nest
    )
    reel = read_cut(path)
    by_name = {shot.name: shot for shot in reel.shots}
    assert (
        by_name["fast"].frames == FrameRange(1001, 1004) and "2 times" in by_name["fast"].notes[0]
    )
    assert by_name["held"].frames == FrameRange(1001, 1001) and "holds" in by_name["held"].notes[0]
    assert "--handles 1" in by_name["held"].notes[1] and "--handles 1" in by_name["marked"].notes[0]
    assert by_name["marked"].marks == ("A=2.4m", "B=6'3\"")
    assert by_name["marked"].notes[1:] == ("marker: x=y", "marker: eyes")
    assert [shot.name for shot in reel.missing_shots] == ["gone"]
    assert by_name["inner"].frames == FrameRange(1001, 1002)
    assert "/nowhere/x.####.exr" in by_name["gone"].notes[0]
    assert reel.gaps == ((1, 5),)


def test_read_edit_of_edl_places_tracks_at_their_record_times(tmp_path):
    path = tmp_path / "a.edl"
    event = "{}  sh010  {}  C  00:00:41:17 00:00:41:22 01:00:{}:00 01:00:{}:05\n"
    events = (("001", "V", "02", "02"), ("002", "V2", "03", "03"))
    path.write_text("TITLE: cut\n" + "".join(event.format(*words) for words in events))
    reel = read_cut(path)
    assert (reel.start_timecode, reel.gaps) == ("01:00:02:00", ((1, 19),))
    assert [shot.count for shot in reel.shots] == [5, 5]


@pytest.mark.parametrize("suffix", [".otio", ".edl"])
def test_read_edit_takes_cdl_grade_of_clip(tmp_path, suffix):
    """In an EDL it is written as *ASC_SOP and *ASC_SAT."""
    folder = write_plates(tmp_path, "sh010")
    clip = clip_of_url("sh010", f"{folder}/sh010.####.exr", None, time_range(1001, 2))
    sop = {"slope": [1.1, 1.0, 0.9], "offset": [0.0, 0.01, -0.02], "power": [1.0, 1.1, 0.9]}
    clip.metadata["cdl"] = {"asc_sat": 0.8, "asc_sop": sop}
    (shot,) = read_cut(write_cut(tmp_path / f"a{suffix}", clip), tmp_path).shots
    assert shot.grade == GRADE
    assert not any("CDL" in note for note in shot.notes)


@pytest.mark.parametrize("cdl_line", [3, {"asc_sop": {"slope": "abc"}}, {"asc_sat": -1}])
def test_read_edit_notes_invalid_cdl_grade(tmp_path, cdl_line):
    folder = write_plates(tmp_path, "sh010")
    clip = clip_of_url("sh010", f"{folder}/sh010.####.exr", None, time_range(1001, 2))
    clip.metadata["cdl"] = cdl_line
    (shot,) = read_cut(write_cut(tmp_path / "a.otio", clip)).shots
    assert shot.grade is None and any("CDL" in note for note in shot.notes)


def test_read_edit_takes_clip_of_topmost_track(tmp_path):
    folder = write_plates(tmp_path, "sh010")
    url = f"{folder}/sh010.####.exr"
    low, high = (
        clip_of_url(n, url, time_range(1001, 4), time_range(1001, 2)) for n in ("low", "high")
    )
    assert [
        s.name for s in read_cut(write_cut(tmp_path / "a.otio", low, tracks=[[high]])).shots
    ] == ["high"]


def test_read_reel_returns_written_reel(tmp_path):
    """Sources are relative paths in the file, and the demo stays a name."""
    shots = (
        ReelShot(
            name="a",
            source=str(tmp_path / "p" / "a.####.exr"),
            frames=FrameRange(3, 9),
            notes=("note",),
            marks=("A=2m",),
            grade=GRADE,
            retime=Retime(start=9.0, speed=-1.5, count=5, step=2),
        ),
        ReelShot("b", "demo"),
        ReelShot(name="c", source="", frames=None, notes=("its media are missing",)),
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
def test_read_reel_rejects_damaged_reel_with_its_place(tmp_path, entries, place):
    path = tmp_path / "r.heatreel.json"
    path.write_text(json.dumps({"heatlens_reel": 1, **entries}))
    with pytest.raises(InputError) as refusal:
        read_reel(path)
    assert str(path) in str(refusal.value) and place in str(refusal.value)


@pytest.mark.parametrize("name", ["a.otio", "a.edl", "a.xml", "a.aaf", "a.otioz"])
@pytest.mark.parametrize("content", [b"", b"x", b"{}", b"<a", b'{"OTIO_SCHEMA": "Timeline.1"}'])
def test_read_edit_rejects_damaged_edit_by_name(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert is_reel(str(path))
    with pytest.raises(InputError) as refusal:
        read_cut(path)
    assert str(path) in str(refusal.value)


@pytest.mark.parametrize("is_moved", [False, True])
def test_read_edit_of_aaf_has_media_ranges_and_gaps(tmp_path, is_moved):
    """The AAF is written by pyaaf2, with a tape's clock and a gap; --media finds moved media."""
    names = ("sh010", "sh020")
    folders = [write_plates(tmp_path / "media", name, range(1001, 1011)) for name in names]
    starts, source_ranges = (86400, 0), (time_range(86402, 4), time_range(3, 5))
    clips = [
        clip_of_url(name, (folder / f"{name}.1001.exr").as_uri(), time_range(start, 10), part)
        for name, folder, start, part in zip(names, folders, starts, source_ranges, strict=True)
    ]
    track = schema.Track(kind=schema.TrackKind.Video)
    track.extend([clips[0], schema.Gap(source_range=time_range(0, 5)), clips[1]])
    timeline = schema.Timeline("cut", global_start_time=RationalTime(90000, RATE))
    timeline.tracks.append(track)
    path = tmp_path / "cut.aaf"
    otio.adapters.write_to_file(timeline, str(path), use_empty_mob_ids=True)
    if is_moved:
        (tmp_path / "media").rename(tmp_path / "elsewhere")
        folders = [tmp_path / "elsewhere" / name for name in names]
        assert len(read_cut(path).missing_shots) == 2
    reel = read_cut(path, tmp_path / "elsewhere") if is_moved else read_cut(path)
    assert (reel.start_timecode, reel.gaps) == ("01:02:30:00", ((1, 5),))
    assert [(shot.source, shot.frames) for shot in reel.shots] == [
        (str(folders[0] / "sh010.####.exr"), FrameRange(1003, 1006)),
        (str(folders[1] / "sh020.####.exr"), FrameRange(1004, 1008)),
    ]
    assert not any(shot.notes for shot in reel.shots)


def test_write_edit_replaces_plates_by_exported_frames(tmp_path):
    """The edit that is written reads back as the same cut, with the focus keys as markers."""
    folder = write_plates(tmp_path, "sh010", range(1001, 1007))
    shot = shot_of("x")
    reel = Reel("cut", (ReelShot("sh010", "x", FrameRange(1002, 1006)),), 25.0, "01:00:00:00")
    exported = ExportedShot(
        shot, folder, NameForm("sh010.", 4, ".exr"), FrameRange(1001, 1006), FrameRange(1002, 1006)
    )
    write_edit(tmp_path / "out.otio", reel, {"sh010": exported})
    read_back = read_cut(tmp_path / "out.otio")
    assert (read_back.frames_per_second, read_back.start_timecode) == (25.0, "01:00:00:00")
    assert [(s.source, s.frames) for s in read_back.shots] == [
        (str(folder / "sh010.####.exr"), FrameRange(1002, 1006))
    ]
    assert read_back.shots[0].notes == ("marker: focus 3 m",)


@given(st.text(max_size=30))
def test_shot_name_of_any_text_is_a_valid_name(text):
    ReelShot(shot_name(text), "x")


@given(st.lists(st.sampled_from(["a", "a_2", "b"]), min_size=1, max_size=8))
def test_with_unique_names_makes_names_of_shots_unique(names):
    shots = with_unique_names(tuple(ReelShot(name, "x") for name in names))
    assert len({shot.name for shot in shots}) == len(names)
