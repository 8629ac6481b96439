"""Test parsing and formatting of distances: values, refusals, and round trips."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.units import (
    format_distance,
    is_bare_number,
    label_distance,
    parse_distance_m,
    parse_scene_unit_m,
)


@pytest.mark.parametrize(
    ("text", "distance_m"),
    [
        ("2.24", 2.24),
        (" 2.24m ", 2.24),
        ("2.24 Metres", 2.24),
        ("190cm", 1.9),
        ("1900 mm", 1.9),
        ("1.2km", 1200.0),
        ("0", 0.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("1e-2", 0.01),
        ("6'3\"", 1.905),
        ("6'3", 1.905),
        ("6' 3.5\"", 1.9177),
        ("6’3”", 1.905),
        ("6ft", 1.8288),
        ("6 ft 3 in", 1.905),
        ("6 feet 3 inches", 1.905),
        ("75in", 1.905),
        ('75"', 1.905),
        ("75''", 1.905),
        ("inf", math.inf),
        ("Infinity", math.inf),
        ("∞", math.inf),
    ],
)
def test_parse_distance_reads_metric_and_imperial_text(text, distance_m):
    assert parse_distance_m(text) == pytest.approx(distance_m, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        *("", " ", ".", "m", "nan", "-1", "-2 m", "-inf", "2,240", "2.24 parsecs", "1e999", "6'3'"),
        *("2 2", "3in 6ft", "1..2", "0x10", "1_000", "٣", "12e", "e3", "'"),
    ],
)
def test_parse_distance_rejects_other_text_and_quotes_it(text):
    with pytest.raises(InputError) as refusal:
        parse_distance_m(text)
    assert repr(text) in str(refusal.value)
    assert "190cm" in str(refusal.value)


@given(st.text())
def test_parse_distance_of_any_text_returns_value_or_input_error(text):
    try:
        distance_m = parse_distance_m(text)
    except InputError:
        return
    assert distance_m >= 0


@pytest.mark.parametrize(
    ("text", "unit_m"),
    [("m", 1), ("CM", 0.01), ("mm", 1e-3), ("ft", 0.3048), ("in", 0.0254), ("0.01", 0.01)],
)
def test_parse_scene_unit_returns_meters_per_unit(text, unit_m):
    assert parse_scene_unit_m(text) == unit_m


@pytest.mark.parametrize("text", ["", "0", "-1", "nan", "inf", "1e999", "1e-999", "furlong", "2 m"])
def test_parse_scene_unit_rejects_impossible_units(text):
    with pytest.raises(InputError, match="is not a scene unit"):
        parse_scene_unit_m(text)


@pytest.mark.parametrize(
    ("distance_m", "metres", "feet"),
    [
        (2.24, "2.24 m", "7'4.2\""),
        (1.905, "1.905 m", "6'3\""),
        (0.0, "0 m", '0"'),
        (0.1, "0.1 m", '3.937"'),
        (0.03669, "3.67 cm", '1.444"'),
        (-0.05, "-5 cm", '-1.969"'),
        (0.3045, "0.3045 m", "1'0\""),
        (0.3048, "0.3048 m", "1'0\""),
        (12345.6, "12346 m", "40503'11.2\""),
        (-1.905, "-1.905 m", "-6'3\""),
        (math.inf, "inf", "inf"),
        (-math.inf, "-inf", "-inf"),
        (math.nan, "unknown", "unknown"),
    ],
)
def test_format_distance_in_meters_and_feet(distance_m, metres, feet):
    assert format_distance(distance_m) == metres
    assert format_distance(distance_m, "ft") == feet


@pytest.mark.parametrize(
    ("distance_m", "metres", "feet"),
    [
        (0.1235, "12 cm", '4.862"'),
        (0.01, "1.0 cm", '0.3937"'),
        (0.00367, "0.37 cm", '0.1445"'),
        (0.9883, "0.99 m", "3'3\""),
        (0.9996, "1.00 m", "3'3\""),
        (3.7, "3.70 m", "12'2\""),
        (3.759, "3.76 m", "12'4\""),
        (9.996, "10 m", "32'10\""),
        (52.08, "52 m", "170'10\""),
        (1234.5, "1200 m", "4050'2\""),
        (-1.905, "-1.91 m", "-6'3\""),
        (math.inf, "inf", "inf"),
        (math.nan, "unknown", "unknown"),
    ],
)
def test_label_distance_in_meters_and_feet(distance_m, metres, feet):
    assert label_distance(distance_m) == metres
    assert label_distance(distance_m, "ft") == feet


@given(st.floats(1e-4, 1e4))
def test_label_distance_differs_by_at_most_half_a_digit(distance_m):
    error = 5.01e-3 if 1 <= distance_m < 10 else 5.01e-2
    assert parse_distance_m(label_distance(distance_m)) == pytest.approx(distance_m, rel=error)


def test_format_distance_rejects_unknown_unit():
    with pytest.raises(InputError, match="'furlong'"):
        format_distance(1.0, "furlong")


@given(st.floats(1e-6, 0.0999))
def test_short_distances_format_as_cm_and_parse_back_to_three_digits(distance_m):
    text = format_distance(distance_m)
    assert text.endswith(" cm")
    assert parse_distance_m(text) == pytest.approx(distance_m, rel=5.001e-3)


@given(st.floats(0.1, 1e6))
def test_formatted_meters_parse_back_to_four_digits(distance_m):
    assert parse_distance_m(format_distance(distance_m)) == pytest.approx(distance_m, rel=5.001e-4)


@given(st.floats(1e-3, 1e6))
def test_formatted_feet_parse_back_to_half_a_tenth_of_an_inch(distance_m):
    again_m = parse_distance_m(format_distance(distance_m, "ft"))
    assert again_m == pytest.approx(distance_m, abs=0.0501 * 0.0254)


@given(st.integers(1, 300), st.integers(0, 23))
def test_feet_and_half_inches_format_to_same_text(feet, half_inches):
    text = f"{feet}'{half_inches / 2:g}\""
    assert format_distance(parse_distance_m(text), "ft") == text


@pytest.mark.parametrize(("text", "metres"), [("3,5", 3.5), ("3,25m", 3.25), ("190,5cm", 1.905)])
def test_parse_distance_reads_decimal_comma(text, metres):
    assert parse_distance_m(text) == pytest.approx(metres)


def test_parse_distance_rejects_ambiguous_thousands_comma():
    with pytest.raises(InputError, match="not a distance"):
        parse_distance_m("1,900 mm")


@pytest.mark.parametrize("text", ["2", " 2.24 ", "2,24", "1e3", "1E3"])
def test_is_bare_number_is_true_only_without_unit(text):
    assert is_bare_number(text)
    assert not any(is_bare_number(words) for words in (f"{text}m", f"{text} mm", f"{text}'", ""))
