"""Test film backs: sizes against the inches of the standards, and tolerant spelling of names."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.filmback import FILMBACKS, Filmback, filmback_named


@pytest.mark.parametrize(
    ("name", "width_mm", "height_mm"),
    [
        ("Full frame", 36.0, 24.0),
        ("Nuke", 24.576, 18.672),
        ("Blender", 36.0, 24.0),
        ("USD", 20.955, 15.2908),
        ("ARRI Alexa 35", 27.99, 19.22),
        ("ARRI Alexa Mini LF", 36.70, 25.54),
        ("ARRI Alexa 65", 54.12, 25.58),
        ("RED V-Raptor 8K VV", 40.96, 21.60),
        ("Sony Venice 6K FF", 36.2, 24.1),
        ("Micro Four Thirds", 17.3, 13.0),
    ],
)
def test_filmback_named_returns_published_size(name, width_mm, height_mm):
    back = filmback_named(name)
    assert (back.width_mm, back.height_mm) == (width_mm, height_mm)


@pytest.mark.parametrize(
    ("name", "width_in", "height_in"),
    [
        ("Academy 35", 0.868, 0.631),
        ("Anamorphic 35", 0.868, 0.735),
        ("Super 35", 0.980, 0.735),
        ("Super 35 3-perf", 0.980, 0.546),
        ("VistaVision", 1.485, 0.991),
        ("65 mm 5-perf", 2.072, 0.906),
        ("IMAX 70 mm", 2.772, 2.072),
        ("USD", 0.825, 0.602),
    ],
)
def test_film_gate_sizes_agree_with_published_inches(name, width_in, height_in):
    back = filmback_named(name)
    assert back.width_mm == pytest.approx(width_in * 25.4, abs=0.01)
    assert back.height_mm == pytest.approx(height_in * 25.4, abs=0.01)


@pytest.mark.parametrize("back", FILMBACKS, ids=lambda back: back.name)
def test_filmback_named_ignores_case_spaces_and_hyphens(back):
    for spelling in (back.name, back.name.upper(), f" {back.name.lower().replace(' ', '-')} "):
        assert filmback_named(spelling) is back
    assert back.width_mm > back.height_mm
    assert back.source


@pytest.mark.parametrize(
    ("typed", "suggested"),
    [("Alexa 35", "ARRI Alexa 35"), ("supper 35", "Super 35"), ("blackmagik", "Blackmagic")],
)
def test_filmback_named_suggests_similar_names(typed, suggested):
    with pytest.raises(InputError, match=suggested) as refusal:
        filmback_named(typed)
    assert repr(typed) in str(refusal.value)


@pytest.mark.parametrize("typed", ["", "???", "a daguerreotype"])
def test_filmback_named_lists_all_names_for_unknown_name(typed):
    with pytest.raises(InputError, match=r"Super 8.*Nuke.*USD"):
        filmback_named(typed)


@given(st.text())
def test_filmback_named_returns_known_back_or_input_error_for_any_text(name):
    try:
        assert filmback_named(name) in FILMBACKS
    except InputError as refusal:
        assert repr(name) in str(refusal)


@pytest.mark.parametrize("width_mm", [0.0, -1.0, float("nan"), float("inf")])
def test_filmback_rejects_impossible_width(width_mm):
    with pytest.raises(InputError, match="width and height"):
        Filmback(name="mine", width_mm=width_mm, height_mm=24.0, source="measured")
