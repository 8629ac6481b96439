"""Test that the typed keywords of the Python functions equal the fields that they set."""

from dataclasses import fields
from enum import StrEnum
from typing import Literal, Unpack, get_args, get_origin, get_type_hints

import pytest

from heatlens.core.model.lens.opening_fields import OpeningFields
from heatlens.core.model.option import type_of
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.deliver.export.options import ExportOptions
from heatlens.fronts.api.frame import Frame
from heatlens.fronts.api.keywords import ExportKeywords, FrameOptions, ReadingOptions, RenderOptions
from heatlens.fronts.api.opening import open as open_source
from heatlens.fronts.api.source import Source


def names(*kinds: type) -> list[str]:
    return [field.name for kind in kinds for field in fields(kind)]


def test_typed_keywords_equal_fields_they_set() -> None:
    assert list(RenderOptions.__annotations__) == names(OpeningFields, DefocusSettings)
    assert list(ReadingOptions.__annotations__) == names(PlateOptions)
    own_names = [
        name for name in ExportKeywords.__annotations__ if name not in FrameOptions.__annotations__
    ]
    assert own_names == names(ExportOptions)


def test_api_functions_use_typed_keywords() -> None:
    assert get_type_hints(Source.render)["more"] == Unpack[RenderOptions]
    assert get_type_hints(Source.export)["options"] == Unpack[ExportKeywords]
    assert get_type_hints(Frame.render)["given"] == Unpack[FrameOptions]
    assert get_type_hints(open_source)["reading"] == Unpack[ReadingOptions]


def test_frame_render_takes_all_keywords_but_frame() -> None:
    source_keywords = set(get_type_hints(Source.render)) - {"lens", "frame", "more", "return"}
    assert set(get_type_hints(FrameOptions)) == source_keywords | set(get_type_hints(RenderOptions))


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (RenderOptions, OpeningFields),
        (RenderOptions, DefocusSettings),
        (ReadingOptions, PlateOptions),
    ],
)
def test_literal_hints_list_all_choices(options: type, kind: type) -> None:
    hints = get_type_hints(options)
    for name in names(kind):
        field_type, hint = type_of(kind, name), hints[name]
        literals = [argument for argument in get_args(hint) if get_origin(argument) is Literal]
        if isinstance(field_type, type) and issubclass(field_type, StrEnum):
            assert field_type in get_args(hint) and len(literals) == 1, name
            assert sorted(get_args(literals[0])) == sorted(field_type)
