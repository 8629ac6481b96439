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
REQUIRED_LENS_FIELDS = {field.name: getattr(LENS, field.name) for field in fields(Lens)}
LAYERS = ("core.model", "deliver.export", "media.documents", "studio.session")
# Classes without limits of their own: a base of `Lens` and a value computed from a lens.
EXCLUDED_CLASSES = {"OpeningFields", "Aperture"}


def option_classes() -> list[type]:
    """Return the dataclasses that people set fields of."""
    class_of_name = {}
    for layer in LAYERS:
        package = importlib.import_module(f"heatlens.{layer}")
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            for kind in vars(importlib.import_module(module.name)).values():
                if isinstance(kind, type) and is_dataclass(kind) and options_of(kind):
                    class_of_name[kind.__qualname__] = kind
    return [kind for name, kind in sorted(class_of_name.items()) if name not in EXCLUDED_CLASSES]


def make_value(kind: type, **values: object) -> object:
    """Return a `kind` with the required fields of `LENS` and the `given` fields."""
    required_names = [it.name for it in fields(kind) if it.default is it.default_factory is MISSING]
    return kind(**{name: REQUIRED_LENS_FIELDS[name] for name in required_names} | values)


RANGES = [
    pytest.param(kind, name, id=f"{kind.__name__}.{name}")
    for kind in option_classes()
    for name, option in options_of(kind).items()
    if option.least is not None or option.most is not None
]


@pytest.mark.parametrize(("kind", "name"), RANGES)
def test_value_outside_the_range_of_its_option_is_refused(kind, name):
    option = options_of(kind)[name]
    wrong = [math.nan]
    wrong += [] if option.least is None else [option.least - 1, -math.inf]
    wrong += [] if option.most is None else [option.most + 1, math.inf]
    for value in wrong:
        with pytest.raises(HeatlensError):
            make_value(kind, **{name: value})


def is_number(hint: object) -> bool:
    return bool({int, float} & {hint, *get_args(hint)}) and get_origin(hint) is not tuple


NUMBERS = [
    pytest.param(kind, name, id=f"{kind.__name__}.{name}")
    for kind in (*option_classes(), ViewState)
    for name, hint in get_type_hints(kind).items()
    if is_number(hint)
]


@pytest.mark.parametrize(("kind", "name"), NUMBERS)
def test_value_refuses_nan_in_each_number_field(kind, name):
    with pytest.raises(HeatlensError):
        make_value(kind, **{name: math.nan})


def test_option_classes_finds_the_known_values():
    names = {kind.__name__ for kind in option_classes()}
    assert {"Lens", "DefocusSettings", "PlateOptions", "Guides", "DisplayOptions"} <= names
    assert heatlens and len(RANGES) > 20


@given(st.data())
def test_view_state_refuses_numbers_that_cannot_be_drawn(data):
    """A view that is accepted has an exposure that can be drawn, also with the lens's T-stop."""
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
        assert abs(view.brighten(data.draw(st.floats(-1e6, 1e6))).exposure_stops) <= STOPS_MOST


@pytest.mark.parametrize("unit", ["01:00", "", "M", "feet", None])
def test_view_state_refuses_unknown_unit(unit):
    assert get_origin(get_type_hints(ViewState)["unit"]) is Literal
    with pytest.raises(HeatlensError, match="m or ft"):
        ViewState(unit=unit)


@pytest.mark.parametrize("wrong", [{"exposure_stops": 31.0}, {"gamma": 0.0}, {"gamma": math.inf}])
def test_view_state_and_display_options_share_their_ranges(wrong):
    for kind in (ViewState, DisplayOptions):
        with pytest.raises(HeatlensError, match="must be within"):
            kind(**wrong)
