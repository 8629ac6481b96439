"""A shot file brings back the shot it was written from, or says in one sentence why it cannot."""

import json
import math
import os
import string
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.errors import InputError
from heatlens.image.shot_file import (
    autosave_path,
    newer_autosave,
    read_shot,
    write_autosave,
    write_shot,
)
from heatlens.model.curve import Curve, Key
from heatlens.model.frames import FrameRange
from heatlens.model.interpolation import Ease, Interpolation, Scale
from heatlens.model.lens import Lens
from heatlens.model.marks import DistanceMark, PointMark
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.model.shot import LensCurves, Shot

FIFTY = Lens(50.0, 1.3, 0.94, 36.0)
FULL = Shot(
    replace(FIFTY, t_stop=1.5, close_focus_m=0.45),
    DefocusSettings(Bokeh.HEAT, Quality.DRAFT, 3, 0.5, Method.SCATTER),
    "/shots/s1/plate.####.exr",
    PlateOptions("Z", "", "normalized", "radial", 0.01, 0.1, 100.0, 50.0, 36.0),
    LensCurves(
        Curve(
            (
                Key(1001, 0.94, Interpolation.BEZIER, Ease(80.0, -0.01), Ease()),
                Key(1012.5, 1.0, Interpolation.HOLD),
                Key(1024, math.inf),
            ),
            Scale.RECIPROCAL,
        ),
        f_stop=Curve((Key(1010, 2.8, Interpolation.LINEAR),), Scale.LOGARITHMIC),
    ),
    (DistanceMark("A", 0.94), DistanceMark("Ä", math.inf), PointMark("B", 960.5, 540.0, 5)),
    FrameRange(1001, 1024),
    FrameRange(1005, 1020),
    24000 / 1001,
)

# Names that a file system takes; the path that a shot brings back is an absolute one.
NAMES = st.text(string.ascii_letters + "#%._- é日", min_size=1, max_size=8).filter(
    lambda name: name.strip(". ")
)
# So slow that no handle reaches far beyond a key, to where there is no lens.
EASES = st.builds(Ease, st.floats(0, 100), st.floats(-1e-6, 1e-6))


def curves_of(values, scale: Scale):
    keys = st.builds(
        Key, st.floats(-1e4, 1e4), values, st.sampled_from(Interpolation), EASES, EASES
    )
    ordered = st.lists(keys, max_size=4, unique_by=lambda key: round(key.frame)).map(
        lambda found: tuple(sorted(found, key=lambda key: key.frame))
    )
    apart = ordered.filter(lambda keys: all(b.frame - a.frame > 0.01 for a, b in pairwise(keys)))
    return st.builds(Curve, apart, st.just(scale))


FOCUS_DISTANCES = st.floats(0.5, 1e6) | st.just(math.inf)
# Focal lengths stay below every focus distance, so that any two keys make a lens.
LENSES = st.builds(
    Lens,
    st.floats(1, 400),
    st.floats(0.5, 64),
    FOCUS_DISTANCES,
    st.floats(1, 100),
    st.floats(1, 2),
    st.none() | st.floats(0.5, 64),
    st.none() | st.floats(0.001, 1),
    st.none() | st.floats(0.1, 5),
)
MARK_NAMES = st.text(string.ascii_letters + "äß日", min_size=1, max_size=4)
MARKS = st.builds(DistanceMark, MARK_NAMES, FOCUS_DISTANCES) | st.builds(
    PointMark, MARK_NAMES, st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.integers(1, 99)
)
FRAME_RANGES = st.builds(
    lambda first, count: FrameRange(first, first + count),
    st.integers(-10_000, 2_000_000),
    st.integers(0, 5000),
)
SHOTS = st.builds(
    Shot,
    LENSES,
    st.builds(
        DefocusSettings,
        st.sampled_from(Bokeh),
        st.sampled_from(Quality),
        st.none() | st.integers(1, 7),
        st.floats(1 / 16, 1),
        st.sampled_from(Method),
    ),
    st.none() | st.lists(NAMES, min_size=1, max_size=3).map(lambda names: "/" + "/".join(names)),
    st.builds(
        PlateOptions,
        st.none() | NAMES,
        st.none() | st.just("") | NAMES,
        st.sampled_from(["auto", "inverse", "coc"]),
        st.sampled_from(["planar", "radial"]),
        st.floats(1e-3, 1e3),
        st.none() | st.floats(0, 10),
    ),
    st.builds(
        LensCurves,
        curves_of(FOCUS_DISTANCES, Scale.RECIPROCAL) | curves_of(st.floats(0.5, 9), Scale.LINEAR),
        curves_of(st.floats(0.5, 64), Scale.LOGARITHMIC),
        curves_of(st.floats(1, 400), Scale.LOGARITHMIC),
        st.just(Curve()) | st.builds(lambda v: Curve((Key(5.5, v),)), st.floats(1, 2)),
    ),
    st.lists(MARKS, max_size=3, unique_by=lambda mark: mark.name).map(tuple),
    st.none() | FRAME_RANGES,
    st.none() | FRAME_RANGES,
    st.floats(1, 1000),
)


def written(shot: Shot, folder: Path) -> Path:
    path = folder / "s.heatlens.json"
    write_shot(path, shot)
    return path


def refusal(path: Path, text: str | bytes) -> str:
    """What is said of a file with this content."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as error:
        read_shot(path)
    return str(error.value)


def changed(path: Path, **entries) -> str:
    """The JSON of a file with other entries at the top."""
    return json.dumps(json.loads(path.read_text()) | entries)


@given(SHOTS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_a_shot_comes_back_as_it_was(tmp_path, shot):
    assert read_shot(written(shot, tmp_path)) == shot


def test_every_entry_comes_back(tmp_path):
    again = read_shot(written(FULL, tmp_path))
    assert again == FULL
    assert again.lens_at(1007.25) == FULL.lens_at(1007.25)


def test_a_plain_shot_is_short_and_comes_back(tmp_path):
    path = written(Shot(FIFTY), tmp_path)
    assert read_shot(path) == Shot(FIFTY)
    path.write_text(
        '{"heatlens_shot": 1, "lens": {"focal_length_mm": 50, "f_stop": 1.3, '
        '"focus_distance_m": 0.94, "sensor_width_mm": 36}}'
    )
    assert read_shot(path) == Shot(FIFTY)


def test_keys_and_marks_stand_one_a_line_with_units_in_the_names(tmp_path):
    lines = written(FULL, tmp_path).read_text("utf-8").splitlines()
    keys = [line.strip() for line in lines if '"frame":' in line]
    assert len(keys) == 4
    assert keys[1] == '{"frame": 1012.5, "value": 1, "interpolation": "hold"},'
    assert keys[2] == '{"frame": 1024, "value": "inf", "interpolation": "smooth"}'
    assert '    {"name": "A", "distance_m": 0.94},' in lines
    assert '    {"name": "Ä", "distance_m": "inf"},' in lines
    assert '    "focal_length_mm": 50,' in lines
    assert lines[1] == '  "heatlens_shot": 1,'


def test_the_source_moves_with_the_file(tmp_path):
    there, here = tmp_path / "there", tmp_path / "here"
    for folder in (there, here):
        folder.mkdir()
    path = written(Shot(FIFTY, source=str(tmp_path / "plates" / "p.####.exr")), there)
    assert json.loads(path.read_text())["source"] == "../plates/p.####.exr"
    (here / path.name).write_bytes(path.read_bytes())
    moved = read_shot(here / path.name)
    assert moved.source == str(tmp_path / "plates" / "p.####.exr")
    inside = written(Shot(FIFTY, source=str(there / "p.####.exr")), there)
    (here / path.name).write_bytes(inside.read_bytes())
    assert read_shot(here / path.name).source == str(here / "p.####.exr")


def test_a_source_in_the_working_folder_is_found_from_any_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_shot("s.heatlens.json", Shot(FIFTY, source="plates/p.####.exr"))
    monkeypatch.chdir(tmp_path.parent)
    found = read_shot(tmp_path / "s.heatlens.json")
    assert found.source == str(tmp_path / "plates" / "p.####.exr")


def test_a_name_that_is_no_unicode_comes_back(tmp_path):
    shot = Shot(FIFTY, source=str(tmp_path / os.fsdecode(b"pl\xe4te.exr")))
    assert read_shot(written(shot, tmp_path)) == shot


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        (
            {"keys": {"focus_distance_m": [{"frame": 1, "value": 2}, {"frame": 2, "valeu": 3}]}},
            "keys.focus_distance_m[1]: unknown entry 'valeu'; did you mean 'value'?",
        ),
        ({"keys": {"f_stop": [{"frame": 1}]}}, "keys.f_stop[0]: the entry 'value' is missing"),
        ({"keys": {"fstop": []}}, "keys: unknown entry 'fstop'; did you mean 'f_stop'?"),
        ({"keys": {"squeeze": {}}}, "keys.squeeze: {} should be a list in brackets"),
        ({"keys": []}, "keys: [] should be an object in braces"),
        (
            {"keys": {"f_stop": [{"frame": 1, "value": 2, "interpolation": "smoth"}]}},
            'keys.f_stop[0].interpolation: "smoth" should be one of hold, linear, smooth, bezier',
        ),
        (
            {"keys": {"f_stop": [{"frame": 1, "value": 2, "ease_in": {"influence_percent": 101}}]}},
            "keys.f_stop[0].ease_in: An influence is 0 to 100 %, got 101.",
        ),
        (
            {"keys": {"f_stop": [{"frame": 2, "value": 2}, {"frame": 1, "value": 2}]}},
            "keys.f_stop: Keys must follow each other: 1 comes after 2.",
        ),
        ({"keys": {"f_stop": [{"frame": 1, "value": "inf"}]}}, "keys.f_stop: A key cannot have"),
        (
            {"keys": {"focus_distance_m": [{"frame": 7, "value": 0.01}]}},
            "keys: Frame 7: The focus distance must be beyond the focal length of 50 mm",
        ),
        (
            {
                "focus_interpolation": "distance",
                "keys": {"focus_distance_m": [{"frame": 7, "value": "inf"}]},
            },
            "infinity has its place in dioptres",
        ),
        ({"focus_interpolation": "metres"}, 'focus_interpolation: "metres" should be one of diop'),
        ({"lens": {"f_stop": 2}}, "lens: the entry 'focal_length_mm' is missing"),
        ({"lens": None}, "lens: null should be an object in braces"),
        ({"frames": {"first": 2, "last": 1}}, "frames: Frames 2-1 run backwards"),
        ({"frames": {"first": 1.5, "last": 2}}, "frames.first: 1.5 should be a whole number"),
        ({"frames": {"first": True, "last": 2}}, "frames.first: true should be a number"),
        ({"frames": {"first": 1, "last": 10**9}}, "at most nine digits"),
        ({"frames_per_second": "24"}, 'frames_per_second: "24" should be a number'),
        ({"frames_per_second": -1}, "Frames per second must be above 0"),
        ({"source": 5}, "source: 5 should be a text"),
        ({"source": ""}, "'' cannot be the name of a file"),
        ({"source": "a\0b"}, "cannot be the name of a file"),
        ({"plate": {"depth_kind": "round"}}, 'plate.depth_kind: "round" should be one of planar, '),
        ({"plate": {"near_m": 10**400}}, "plate.near_m: 1000"),
        ({"defocus": {"layers": 99}}, "defocus: layers must be 1 to 7, got 99"),
        ({"marks": [{"name": "A"}]}, "marks[0]: the entry 'x_px' is missing"),
        ({"marks": ["A"]}, 'marks[0]: "A" should be an object in braces'),
        ({"marks": [{"name": "A", "distance_m": 1}] * 2}, "Two marks are called A."),
        ({"heatlens_shot": 2}, "heatlens_shot: version 2 is not known here, only 1"),
        ({"heatlens_shot": "1"}, 'heatlens_shot: "1" should be a number'),
        ({"lense": {}}, "unknown entry 'lense'; did you mean 'lens'?"),
    ],
)
def test_a_mistake_is_told_with_its_place(tmp_path, entries, words):
    path = written(Shot(FIFTY), tmp_path)
    said = refusal(path, changed(path, **entries))
    assert said.startswith(f"{path}: ") and words in said and "\n" not in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1, column 1"),
        ("[]", "this is no shot of heatlens"),
        ("{}", "this is no shot of heatlens"),
        ('{"heatlens_shot": 1}', "the entry 'lens' is missing"),
        ('{"heatlens_shot": 1, "heatlens_shot": 1}', "'heatlens_shot' stands twice"),
        ('{"heatlens_shot": NaN}', "NaN is no JSON number"),
        ('{"heatlens_shot": 1e999}', 'too large; infinity is written "inf"'),
        ("9" * 5000, "is damaged"),
        ("[" * 100_000, "is damaged"),
        (b"\xff\xfe{}", "is damaged"),
        (b"\x76\x2f\x31\x01", "is damaged"),
    ],
)
def test_what_is_no_shot(tmp_path, text, words):
    assert words in refusal(tmp_path / "s.heatlens.json", text)


def test_a_mark_of_the_byte_order_does_no_harm(tmp_path):
    path = written(FULL, tmp_path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert read_shot(path) == FULL


@pytest.mark.parametrize("make", [lambda path: None, Path.mkdir])
def test_a_file_that_cannot_be_read_is_named(tmp_path, make):
    path = tmp_path / "s.heatlens.json"
    make(path)
    with pytest.raises(InputError, match=r"s\.heatlens\.json cannot be read"):
        read_shot(path)


def read_or_refuse(path: Path, content: bytes) -> None:
    """Nothing but a shot or an InputError comes of any content."""
    path.write_bytes(content)
    try:
        assert isinstance(read_shot(path), Shot)
    except InputError as error:
        assert str(path) in str(error)


def test_every_truncation_is_refused(tmp_path):
    path = written(FULL, tmp_path)
    content = path.read_bytes().rstrip()
    for length in range(len(content)):
        assert refusal(path, content[:length])


@given(st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_a_flipped_byte_makes_another_shot_or_a_refusal(tmp_path, data):
    content = bytearray(written(FULL, tmp_path).read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    read_or_refuse(tmp_path / "s.heatlens.json", bytes(content))


ANY_JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=5)
    | st.sampled_from(["inf", "bezier", 10**400, -1, 1e308]),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


def places_of(value, place=()):
    """The way to every value inside a JSON value."""
    yield place
    if not isinstance(value, dict | list):
        return
    for name, entry in value.items() if isinstance(value, dict) else enumerate(value):
        yield from places_of(entry, (*place, name))


@given(st.data(), ANY_JSON)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
def test_another_value_anywhere_makes_another_shot_or_a_refusal(tmp_path, data, value):
    top = {"": json.loads(written(FULL, tmp_path).read_text("utf-8"))}
    *way, last = data.draw(st.sampled_from(list(places_of(top))[1:]))
    place = top
    for name in way:
        place = place[name]
    place[last] = value
    read_or_refuse(tmp_path / "s.heatlens.json", json.dumps(top[""]).encode())


def test_a_save_that_fails_leaves_the_earlier_file(tmp_path, monkeypatch):
    path = written(FULL, tmp_path)
    before = path.read_bytes()

    def full_disk(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(InputError, match="No space left on device"):
        write_shot(path, Shot(FIFTY))
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [path.name]


def test_a_save_into_no_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        write_shot(tmp_path / "none" / "s.heatlens.json", FULL)


def test_an_autosave_is_offered_while_it_is_the_newer_one(tmp_path):
    path = tmp_path / "s.heatlens.json"
    assert newer_autosave(path) is None
    write_autosave(path, FULL)
    assert newer_autosave(path) == autosave_path(path)  # never saved, yet not lost
    write_shot(path, Shot(FIFTY))
    assert newer_autosave(path) is None and not autosave_path(path).exists()
    write_autosave(path, FULL)
    for seconds, offered in ((-1, None), (0, None), (1, autosave_path(path))):
        at_ns = path.stat().st_mtime_ns + seconds * 10**9
        os.utime(autosave_path(path), ns=(at_ns, at_ns))
        assert newer_autosave(path) == offered
    assert read_shot(autosave_path(path)) == FULL
    assert read_shot(path) == Shot(FIFTY)
