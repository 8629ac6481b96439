"""Test fields that a user sets: their ranges and types, and their command line options."""

import math
from dataclasses import dataclass, field

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import (
    Option,
    changed_options,
    check_range,
    option,
    option_field,
    options_of,
    type_of,
)


@dataclass(frozen=True)
class Record:
    needed: int = field(metadata=option("needed"))
    width: float = option_field(36.0, "Film width", "how wide", unit="mm", least=1.0, most=100.0)
    is_on: bool = option_field(False, "switch", label="", flag="on")
    name: str | None = option_field(None, "name")
    hidden: int = 3


def test_options_of_derives_flag_label_and_tip_from_words():
    options = options_of(Record)
    assert list(options) == ["needed", "width", "is_on", "name"]
    width, is_on = options["width"], options["is_on"]
    assert (width.flag, width.label, width.tip) == ("film-width", "Film width", "how wide")
    assert (width.words, width.help, width.unit, width.shown) == (
        *("Film width", "how wide", "mm", "%.2f"),
    )
    assert (is_on.flag, is_on.label) == ("on", "")


def test_option_allows_ends_of_range_but_not_nan():
    width = options_of(Record)["width"]
    assert width.allows(1.0) and width.allows(100.0)
    assert not any(map(width.allows, (0.999, 100.001, math.nan, math.inf)))
    assert Option("any").allows(-math.inf) and Option("any").allows(math.inf)
    assert Option("some", least=1.0).allows(1e9) and not Option("some", most=1.0).allows(1.1)


def test_check_range_names_allowed_range_and_value():
    check_range("width", None, 1.0, 2.0)
    check_range("width", 1.0, 1.0, 2.0)
    check_range("width", 2.0, 1.0, 2.0)
    for wrong in (0.5, 2.5, math.nan):
        with pytest.raises(InputError, match=rf"width should be 1 to 2, got {wrong:g}"):
            check_range("width", wrong, 1.0, 2.0)


def test_type_of_optional_field_is_type_without_none():
    assert type_of(Record, "name") is str and type_of(Record, "width") is float


def test_words_of_lists_only_non_default_options():
    assert changed_options(Record(1)) == []
    assert changed_options(Record(1, 24.0, True, "a b", 9)) == [
        "--film-width=24.0",
        "--on",
        "--name=a b",
    ]
