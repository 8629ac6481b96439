"""Limits belong to a value itself: whoever sets it, a page, the command line or a panel."""

import importlib
import math
import pkgutil
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Literal, get_args, get_origin, get_type_hints

import pytest
from hypothesis import given
from hypothesis import strategies as st

import heatlens
from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import options_of
from heatlens.core.model.view.view import STOPS_MOST, DisplayOptions, ViewState

LENS = Lens(50.0, 2.0, 2.0, 36.0)
NEEDED = {field.name: getattr(LENS, field.name) for field in fields(Lens)}
LAYERS = ("core.model", "deliver.export", "media.documents", "studio.session")
# A part of the lens, which checks it, and what is computed from a lens.
PARTS = {"OpeningFields", "Aperture"}


def values() -> list[type]:
    """Return the dataclasses that people set fields of."""
    found = {}
    for layer in LAYERS:
        room = importlib.import_module(f"heatlens.{layer}")
        for module in pkgutil.walk_packages(room.__path__, f"{room.__name__}."):
            for kind in vars(importlib.import_module(module.name)).values():
                if isinstance(kind, type) and is_dataclass(kind) and options_of(kind):
                    found[kind.__qualname__] = kind
    return [kind for name, kind in sorted(found.items()) if name not in PARTS]


def made(kind: type, **given: object) -> object:
    needed = [it.name for it in fields(kind) if it.default is it.default_factory is MISSING]
    return kind(**{name: NEEDED[name] for name in needed} | given)


RANGES = [
    pytest.param(kind, name, id=f"{kind.__name__}.{name}")
    for kind in values()
    for name, option in options_of(kind).items()
    if option.least is not None or option.most is not None
]


@pytest.mark.parametrize(("kind", "name"), RANGES)
def test_a_range_of_an_option_is_that_of_the_value(kind, name):
    option = options_of(kind)[name]
    wrong = [math.nan]
    wrong += [] if option.least is None else [option.least - 1, -math.inf]
    wrong += [] if option.most is None else [option.most + 1, math.inf]
    for value in wrong:
        with pytest.raises(HeatlensError):
            made(kind, **{name: value})


def is_number(hint: object) -> bool:
    return bool({int, float} & {hint, *get_args(hint)}) and get_origin(hint) is not tuple


NUMBERS = [
    pytest.param(kind, name, id=f"{kind.__name__}.{name}")
    for kind in (*values(), ViewState)
    for name, hint in get_type_hints(kind).items()
    if is_number(hint)
]


@pytest.mark.parametrize(("kind", "name"), NUMBERS)
def test_no_number_of_a_value_is_nan(kind, name):
    with pytest.raises(HeatlensError):
        made(kind, **{name: math.nan})


def test_the_law_sees_the_values():
    names = {kind.__name__ for kind in values()}
    assert {"Lens", "DefocusSettings", "PlateOptions", "Guides", "DisplayOptions"} <= names
    assert heatlens and len(RANGES) > 20


@given(st.data())
def test_every_number_of_a_view_is_in_its_range_or_refused(data):
    """A view that is taken has an exposure that can be drawn, also behind a lens that transmits."""
    for name, hint in get_type_hints(ViewState).items():
        if not is_number(hint):
            continue
        value = data.draw(st.floats() | st.floats(0.01, 40.0), name)
        try:
            view = replace(ViewState(), **{name: value})
        except HeatlensError as error:
            assert str(error).endswith(".")
            continue
        assert math.isfinite(2.0**view.exposure_stops) and math.isfinite(1.0 / view.gamma)
        assert abs(view.exposed_by(data.draw(st.floats(-1e6, 1e6))).exposure_stops) <= STOPS_MOST


@pytest.mark.parametrize("unit", ["01:00", "", "M", "feet", None])
def test_a_unit_of_a_view_is_one_of_its_set(unit):
    assert get_origin(get_type_hints(ViewState)["unit"]) is Literal
    with pytest.raises(HeatlensError, match="m or ft"):
        ViewState(unit=unit)


@pytest.mark.parametrize("wrong", [{"exposure_stops": 31.0}, {"gamma": 0.0}, {"gamma": math.inf}])
def test_options_and_view_have_one_range(wrong):
    for kind in (ViewState, DisplayOptions):
        with pytest.raises(HeatlensError, match="must be within"):
            kind(**wrong)
