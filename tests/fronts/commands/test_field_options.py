"""Test options made from fields: each field has one, with its type and its range."""

import re
from argparse import ArgumentParser
from dataclasses import fields, replace
from enum import StrEnum
from typing import Any

import pytest

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import changed_options, options_of, type_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.view.view import DisplayOptions
from heatlens.fronts.commands.options.field_options import (
    add_fields,
    attribute_names,
    flag_of,
    given_fields,
    unused_blur_options,
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


def parse_fields(kind: type, *words: str) -> dict[str, Any]:
    parser = ArgumentParser()
    add_fields(parser, kind)
    return given_fields(parser.parse_args(words), kind)


def option_text(value: Any) -> str:
    if isinstance(value, OpeningImage):
        return value.path
    return f"{value:.17g}" if isinstance(value, float) else str(value)


def test_every_user_field_has_an_option():
    assert set(options_of(DefocusSettings)) == {f.name for f in fields(DefocusSettings)}
    assert set(options_of(PlateOptions)) == NAMES_OF_PLATES - OF_THE_LENS - SETTLED
    assert set(options_of(Lens)) == {f.name for f in fields(Lens)}
    assert {str(parameter) for parameter in LensParameter} <= set(options_of(Lens))


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_option_flags_are_unique_words(record):
    flags = [flag_of(type(record), name) for name in options_of(type(record))]
    assert len(set(flags)) == len(flags)
    assert all(re.fullmatch(r"--[A-Za-z]+(-[a-z]+)*", flag) for flag in flags)


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_typed_option_sets_field_to_its_value(record):
    kind = type(record)
    for name, changed_record in with_other_fields(record):
        if name not in options_of(kind):
            continue
        value = getattr(changed_record, name)
        flag = flag_of(kind, name)
        values = value if isinstance(value, tuple) else (value,)
        is_flag = type_of(kind, name) is bool
        words = [flag] if is_flag else [f"{flag}={option_text(item)}" for item in values]
        assert parse_fields(kind, *words) == {name: value}
        assert replace(record, **parse_fields(kind, *words)) == changed_record


@pytest.mark.parametrize("record", [DefocusSettings(), DisplayOptions()])
def test_words_of_record_parse_back_to_same_record(record):
    """The window passes its settings to the export command in this way."""
    kind = type(record)
    assert changed_options(record) == []
    for _, changed_record in with_other_fields(record):
        assert (
            replace(record, **parse_fields(kind, *changed_options(changed_record)))
            == changed_record
        )
    changed_record = with_all_fields_other(record)
    assert replace(record, **parse_fields(kind, *changed_options(changed_record))) == changed_record


def test_parse_fields_omits_options_not_given():
    assert parse_fields(DefocusSettings) == parse_fields(PlateOptions) == parse_fields(Lens) == {}


def test_choice_option_parses_to_enum_member():
    method = parse_fields(DefocusSettings, "--method", "gather")["method"]
    assert method is Method.GATHER and isinstance(method, StrEnum)


@pytest.mark.parametrize(("record", "name"), RANGES, ids=lambda it: it if str(it) == it else "")
def test_record_accepts_ends_of_option_range_and_rejects_beyond(record, name):
    option = options_of(type(record))[name]
    is_integer = type_of(type(record), name) is int
    valid_record = replace(record, focus_distance_m=1e9) if isinstance(record, Lens) else record
    for end, outside_value in (
        (option.least, option.least - 0.1),
        (option.most, option.most * 1.01 + 1),
    ):
        kind = int if is_integer else float
        assert getattr(replace(valid_record, **{name: kind(end)}), name) == end
        outside = kind(outside_value) if not is_integer or outside_value > end else kind(end) - 1
        with pytest.raises(HeatlensError, match=f"{option.words[1:]} must be "):
            replace(valid_record, **{name: outside})


@pytest.mark.parametrize("name", ["layers", "proxy", "views"])
def test_option_out_of_range_is_refused_with_its_flag(name):
    option = options_of(DefocusSettings)[name]
    words = f"--{name} must be {option.least:g} to {option.most:g}, got 99999999"
    with pytest.raises(InputError, match=re.escape(words.replace("99999999", "1e+08"))):
        parse_fields(DefocusSettings, f"--{name}=100000000")


@pytest.mark.parametrize("method", Method)
def test_unused_blur_options_depend_on_method(method):
    ignored = {name for names in unused_blur_options(method).values() for name in names}
    of_shape = {"bokeh", "quality", "layers"}
    assert (of_shape <= ignored) is (method is not Method.DIFFUSION)
    assert ("views" in ignored) is not method.needs_scene
    assert not ignored & {"method", "proxy"}
    assert ignored <= set(attribute_names(DefocusSettings))
