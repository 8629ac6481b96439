"""The typed keywords of the Python functions are those of the fields that they set."""

from dataclasses import fields
from enum import StrEnum
from typing import Literal, Unpack, get_args, get_origin, get_type_hints

import pytest

from heatlens.core.model.lens.opening_fields import OpeningFields
from heatlens.core.model.option import type_of
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.fronts.api.frame import Frame
from heatlens.fronts.api.keywords import FrameOptions, ReadingOptions, RenderOptions
from heatlens.fronts.api.opening import open as open_source
from heatlens.fronts.api.source import Source


def names(*kinds: type) -> list[str]:
    return [field.name for kind in kinds for field in fields(kind)]


def test_they_are_the_fields() -> None:
    assert list(RenderOptions.__annotations__) == names(OpeningFields, DefocusSettings)
    assert list(ReadingOptions.__annotations__) == names(PlateOptions)


def test_the_functions_are_typed_with_them() -> None:
    assert get_type_hints(Source.render)["more"] == Unpack[RenderOptions]
    assert get_type_hints(Frame.render)["given"] == Unpack[FrameOptions]
    assert get_type_hints(open_source)["reading"] == Unpack[ReadingOptions]


def test_a_frame_takes_all_that_a_source_takes_but_the_frame() -> None:
    own = set(get_type_hints(Source.render)) - {"lens", "frame", "more", "return"}
    assert set(get_type_hints(FrameOptions)) == own | set(get_type_hints(RenderOptions))


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (RenderOptions, OpeningFields),
        (RenderOptions, DefocusSettings),
        (ReadingOptions, PlateOptions),
    ],
)
def test_choices_are_those_that_there_are(options: type, kind: type) -> None:
    hints = get_type_hints(options)
    for name in names(kind):
        of_field, told = type_of(kind, name), hints[name]
        literals = [one for one in get_args(told) if get_origin(one) is Literal]
        if isinstance(of_field, type) and issubclass(of_field, StrEnum):
            assert of_field in get_args(told) and len(literals) == 1, name
            assert sorted(get_args(literals[0])) == sorted(of_field)
