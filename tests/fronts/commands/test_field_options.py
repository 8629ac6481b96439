"""Options made from fields: each field has one, it is read as its type says, and ranges agree."""

import re
from argparse import ArgumentParser
from dataclasses import fields, replace
from enum import StrEnum
from typing import Any

import pytest

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import options_of, type_of, words_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.view.view import DisplayOptions
from heatlens.fronts.commands.options.field_options import (
    add_fields,
    attributes_of,
    flag_of,
    typed_fields,
    unasked,
)
from support.other_values import with_all_fields_other, with_other_fields

NAMES_OF_PLATES = {field.name for field in fields(PlateOptions)}
LENS = Lens(50.0, 2.0, 3.0, 36.0)
OF_THE_LENS = {"focal_length_mm", "sensor_width_mm"}  # of PlateOptions, too: the lens has these
SETTLED = {"behind_conventions"}  # what reading finds out, and the shot keeps
RECORDS = (DefocusSettings(), PlateOptions(), LENS)
RANGES = [
    (record, name)
    for record in RECORDS
    for name, told in options_of(type(record)).items()
    if told.least is not None
]


def parsed(kind: type, *words: str) -> dict[str, Any]:
    parser = ArgumentParser()
    add_fields(parser, kind)
    return typed_fields(parser.parse_args(words), kind)


def typed(value: Any) -> str:
    if isinstance(value, OpeningImage):
        return value.path
    return f"{value:.17g}" if isinstance(value, float) else str(value)


def test_every_field_that_a_person_sets_has_an_option():
    assert set(options_of(DefocusSettings)) == {f.name for f in fields(DefocusSettings)}
    assert set(options_of(PlateOptions)) == NAMES_OF_PLATES - OF_THE_LENS - SETTLED
    assert set(options_of(Lens)) == {f.name for f in fields(Lens)}
    assert {str(parameter) for parameter in LensParameter} <= set(options_of(Lens))


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_flags_are_words_and_all_different(record):
    flags = [flag_of(type(record), name) for name in options_of(type(record))]
    assert len(set(flags)) == len(flags)
    assert all(re.fullmatch(r"--[A-Za-z]+(-[a-z]+)*", flag) for flag in flags)


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_what_is_typed_is_the_value(record):
    kind = type(record)
    for name, other in with_other_fields(record):
        if name not in options_of(kind):
            continue
        value = getattr(other, name)
        flag = flag_of(kind, name)
        values = value if isinstance(value, tuple) else (value,)
        is_flag = type_of(kind, name) is bool
        words = [flag] if is_flag else [f"{flag}={typed(one)}" for one in values]
        assert parsed(kind, *words) == {name: value}
        assert replace(record, **parsed(kind, *words)) == other


@pytest.mark.parametrize("record", [DefocusSettings(), DisplayOptions()])
def test_the_words_of_a_value_are_read_as_that_value(record):
    """So does the window hand its settings to the command that exports."""
    kind = type(record)
    assert words_of(record) == []
    for _, other in with_other_fields(record):
        assert replace(record, **parsed(kind, *words_of(other))) == other
    other = with_all_fields_other(record)
    assert replace(record, **parsed(kind, *words_of(other))) == other


def test_what_is_not_typed_is_left_out():
    assert parsed(DefocusSettings) == parsed(PlateOptions) == parsed(Lens) == {}


def test_a_choice_is_typed_as_its_member():
    found = parsed(DefocusSettings, "--method", "gather")["method"]
    assert found is Method.GATHER and isinstance(found, StrEnum)


@pytest.mark.parametrize(("record", "name"), RANGES, ids=lambda it: it if str(it) == it else "")
def test_the_ends_of_a_range_are_allowed_and_what_lies_beyond_is_not(record, name):
    told = options_of(type(record))[name]
    whole = type_of(type(record), name) is int
    far = replace(record, focus_distance_m=1e9) if isinstance(record, Lens) else record
    for end, beyond in ((told.least, told.least - 0.1), (told.most, told.most * 1.01 + 1)):
        kind = int if whole else float
        assert getattr(replace(far, **{name: kind(end)}), name) == end
        outside = kind(beyond) if not whole or beyond > end else kind(end) - 1
        with pytest.raises(HeatlensError, match=f"{told.words[1:]} must be "):
            replace(far, **{name: outside})


@pytest.mark.parametrize("name", ["layers", "proxy", "views"])
def test_a_number_outside_its_range_is_refused_by_its_flag(name):
    told = options_of(DefocusSettings)[name]
    words = f"--{name} must be {told.least:g} to {told.most:g}, got 99999999"
    with pytest.raises(InputError, match=re.escape(words.replace("99999999", "1e+08"))):
        parsed(DefocusSettings, f"--{name}=100000000")


@pytest.mark.parametrize("method", Method)
def test_a_method_asks_for_its_own_options(method):
    ignored = {name for names in unasked(method).values() for name in names}
    of_shape = {"bokeh", "quality", "layers"}
    assert (of_shape <= ignored) is (method is not Method.DIFFUSION)
    assert ("views" in ignored) is not method.needs_scene
    assert not ignored & {"method", "proxy"}
    assert ignored <= set(attributes_of(DefocusSettings))
