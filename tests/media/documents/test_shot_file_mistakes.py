"""Test that an error in a shot file is reported in one sentence, with its place."""

import json
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot
from support.shot_files import FIFTY, refusal, write_shot_in


def json_with_entries(path: Path, **entries) -> str:
    """Return the JSON of a file with other entries at the top."""
    return json.dumps(json.loads(path.read_text()) | entries)


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
            "keys.f_stop: Keys must be sorted by frame: 1 comes after 2.",
        ),
        (
            {"keys": {"f_stop": [{"frame": 7, "value": 2}, {"frame": 7, "value": 4}]}},
            "keys.f_stop: There are two keys at frame 7: keep one.",
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
            "use the scale of dioptres for infinity",
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
        ({"source": ""}, "named '', which cannot be a file"),
        ({"source": "a\0b"}, "cannot be a file"),
        ({"plate": {"depth_kind": "round"}}, 'plate.depth_kind: "round" should be one of auto, '),
        ({"plate": {"near_m": 10**400}}, "plate.near_m: 1000"),
        ({"defocus": {"layers": 99}}, "defocus: Layers must be 1 to 7, got 99."),
        ({"marks": [{"name": "A"}]}, "marks[0]: the entry 'x_px' is missing"),
        ({"marks": ["A"]}, 'marks[0]: "A" should be an object in braces'),
        ({"marks": [{"name": "A", "distance_m": 1}] * 2}, "Two marks are called A: rename one."),
        ({"heatlens_shot": 2}, "heatlens_shot: version 2 is not known here, only 1"),
        ({"heatlens_shot": "1"}, 'heatlens_shot: "1" should be a number'),
        ({"lense": {}}, "unknown entry 'lense'; did you mean 'lens'?"),
    ],
)
def test_read_shot_error_names_place_of_wrong_entry(tmp_path, entries, words):
    path = write_shot_in(Shot(FIFTY), tmp_path)
    message = refusal(path, json_with_entries(path, **entries))
    assert message.startswith(f"{path}: ") and words in message and "\n" not in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1, column 1"),
        ("[]", "this is no shot of heatlens"),
        ("{}", "this is no shot of heatlens"),
        ('{"heatlens_shot": 1}', "the entry 'lens' is missing"),
        ('{"heatlens_shot": 1, "heatlens_shot": 1}', "'heatlens_shot' occurs twice"),
        ('{"heatlens_shot": NaN}', "NaN is not a JSON number"),
        ('{"heatlens_shot": 1e999}', 'too large; infinity is written "inf"'),
        ("9" * 5000, "is damaged"),
        ("[" * 100_000, "is damaged"),
        (b"\xff\xfe{}", "is not a text file"),
        (b"\x76\x2f\x31\x01", "is damaged"),
    ],
)
def test_read_shot_rejects_file_that_is_no_shot(tmp_path, text, words):
    assert words in refusal(tmp_path / "s.heatlens.json", text)


@pytest.mark.parametrize(
    ("make", "words"), [(lambda path: None, "is not there"), (Path.mkdir, "is a folder")]
)
def test_read_shot_names_unreadable_file(tmp_path, make, words):
    path = tmp_path / "s.heatlens.json"
    make(path)
    with pytest.raises(InputError, match=rf"s\.heatlens\.json {words}"):
        read_shot(path)
