"""Values of the model as JSON and back, and the sentence for each entry that is not as expected."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.files.json_record import JsonEntry, digest, read_json, record_to_json

FILE = Path("a.json")


class Kind(StrEnum):
    SOFT = "soft"
    HARD = "hard"


@dataclass(frozen=True)
class Part:
    size: float
    count: int = 0


@dataclass(frozen=True)
class Whole:
    name: str
    kind: Kind = Kind.SOFT
    parts: tuple[Part, ...] = ()
    pair: tuple[int, float] = (0, 0.0)
    by_name: Mapping[str, float] | None = None
    side: Literal["left", "right"] = "left"
    is_on: bool = False


NUMBERS = st.floats(-1e299, 1e299) | st.just(math.inf)
WHOLES = st.builds(
    Whole,
    st.text(),
    st.sampled_from(Kind),
    st.lists(st.builds(Part, NUMBERS, st.integers(-(2**40), 2**40))).map(tuple),
    st.tuples(st.integers(-9, 9), NUMBERS),
    st.none() | st.dictionaries(st.text(), NUMBERS),
    st.sampled_from(["left", "right"]),
    st.booleans(),
)


@given(WHOLES)
def test_record_comes_back_from_its_json(whole):
    text = json.dumps(record_to_json(whole), allow_nan=False)
    assert JsonEntry(path=FILE, place="", value=json.loads(text)).record(Whole) == whole


def test_record_writes_whole_numbers_without_a_point_and_leaves_none_out():
    written = record_to_json(Whole("a", parts=(Part(2.0), Part(math.inf), Part(2.0**53))))
    assert [part["size"] for part in written["parts"]] == [2, "inf", 2.0**53]
    assert [type(part["size"]) for part in written["parts"]] == [int, str, float]
    assert "by_name" not in written and written["kind"] == "soft"


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ([], "[] should be an object in braces"),
        ({"name": "a", "nam": 1}, "unknown entry 'nam'; did you mean 'name'?"),
        ({}, "the entry 'name' is missing"),
        ({"name": 1}, "name: 1 should be a text in quotation marks"),
        ({"name": "a", "kind": "wet"}, 'kind: "wet" should be one of soft, hard'),
        ({"name": "a", "side": "top"}, 'side: "top" should be one of left, right'),
        ({"name": "a", "parts": 3}, "parts: 3 should be a list in brackets"),
        ({"name": "a", "parts": [{"size": 1}, {}]}, "parts[1]: the entry 'size' is missing"),
        ({"name": "a", "parts": [{"size": "x"}]}, 'parts[0].size: "x" should be a number'),
        ({"name": "a", "parts": [{"size": True}]}, "parts[0].size: true should be a number"),
        ({"name": "a", "parts": [{"size": 10**301}]}, "is too large; infinity is written"),
        ({"name": "a", "pair": [1]}, "pair: there should be 2 values, not 1"),
        ({"name": "a", "pair": [1.5, 2]}, "pair[0]: 1.5 should be a whole number"),
        ({"name": "a", "by_name": {"b": None}}, "by_name.b: null should be a number"),
        ({"name": "a", "is_on": 1}, "is_on: 1 should be true or false"),
        ({"name": ["long" * 20]}, f'name: ["{("long" * 9)[:35]}... should be a text'),
    ],
)
def test_wrong_entry_is_refused_with_its_file_and_place(value, sentence):
    with pytest.raises(InputError) as error:
        JsonEntry(path=FILE, place="", value=value).record(Whole)
    assert str(error.value).startswith(f"{FILE}:") and sentence in str(error.value)


def test_version_is_that_one_alone():
    JsonEntry(path=FILE, place="", value={"kit": 2}).check_version("kit", 2, "kit of lenses")
    for value, sentence in (
        ({"kit": 3}, "kit: version 3 is not known here, only 2; a newer heatlens may have"),
        ({"kit": 1}, "version 1 is not known here, only 2"),
        ({"shot": 2}, "this is no kit of lenses of heatlens: it has no entry 'kit'"),
        ({"heatlens_reel": 2}, "this is a reel of heatlens: give the file of a kit of lenses"),
        ([2], "this is no kit of lenses of heatlens"),
    ):
        with pytest.raises(InputError) as error:
            JsonEntry(path=FILE, place="", value=value).check_version("kit", 2, "kit of lenses")
        assert sentence in str(error.value)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b'{"a": 1, "a": 2}', "the entry 'a' occurs twice"),
        (b'{"b": 0, "a": NaN}', "NaN is not a JSON number"),
        (b'{"a": ', "line 1, column 7"),
        (b"\xff\xfe\x00", "is not a text file"),
        (b"[" * 100_000, "is damaged"),
    ],
)
def test_damaged_file_is_refused(tmp_path, data, sentence):
    path = tmp_path / "a.json"
    path.write_bytes(data)
    with pytest.raises(InputError, match=sentence) as error:
        read_json(path)
    assert str(path) in str(error.value)


def test_file_may_begin_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "a.json"
    path.write_bytes(b'\xef\xbb\xbf{"a": 1}')
    assert read_json(path).value == {"a": 1}


def test_digest_has_32_digits_and_depends_on_values_but_not_on_their_order():
    first = digest({"a": 1, "b": 2})
    assert first == digest({"b": 2, "a": 1}) != digest({"a": 2, "b": 1}) and len(first) == 32
