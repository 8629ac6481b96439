"""Compare primaries found in headers with OpenColorIO's own matrices."""

import itertools
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.fronts.commands.main import main
from heatlens.media.color.color_config import ColorConfig, load_color_config
from heatlens.media.color.input_space import input_space_of
from heatlens.media.color.view_transform import srgb_transform, to_rec709, view_transform
from heatlens.media.plate.header.primaries import (
    KNOWN,
    REC709,
    TOLERANCE,
    Primaries,
    header_primaries,
)
from heatlens.media.plate.read import read_plate
from support.exr_files import distances, rgb, write_file

# Names in the built-in config.
CONFIG_NAMES = {
    "linear Rec.709": "Linear Rec.709 (sRGB)",
    "ACES2065-1": "ACES2065-1",
    "ACEScg": "ACEScg",
    "linear Rec.2020": "Linear Rec.2020",
    "linear P3-D65": "Linear P3-D65",
    "linear AdobeRGB": "Linear AdobeRGB",
    "CIE XYZ": "CIE XYZ-D65 - Scene-referred",
}
NO_TRIANGLE = (0.6, 0.3, 0.4, 0.3, 0.2, 0.3, 0.31, 0.33)
UNKNOWN = (0.7, 0.3, 0.2, 0.7, 0.14, 0.05, 0.31, 0.33)
known = pytest.mark.parametrize("primaries", KNOWN, ids=lambda primaries: primaries.name)


@pytest.fixture(scope="module")
def built_in() -> ColorConfig:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("OCIO", raising=False)
        return load_color_config(None)


def write_plate_with_header(tmp_path, **attributes):
    return write_file(tmp_path / "plate.exr", rgb() | {"Z": distances()}, **attributes)


@known
def test_input_space_of_known_chromaticities_is_that_space(built_in, tmp_path, primaries):
    path = write_plate_with_header(tmp_path, chromaticities=primaries.chromaticities)
    light = input_space_of(built_in, read_plate(path).attributes)
    assert light.name == CONFIG_NAMES[primaries.name]
    assert "chromaticities" in light.origin and not light.note


@known
def test_input_space_follows_color_interop_id(built_in, tmp_path, primaries):
    path = write_plate_with_header(
        tmp_path, colorInteropID=primaries.interop_id, chromaticities=UNKNOWN
    )
    light = input_space_of(built_in, read_plate(path).attributes)
    assert (light.name, light.note) == (CONFIG_NAMES[primaries.name], "")
    assert "colorInteropID" in light.origin


@known
def test_to_rec709_equals_matrix_of_opencolorio(built_in, primaries):
    name = input_space_of(built_in, {"colorInteropID": primaries.interop_id}).name
    processor = built_in.config.getProcessor(name, built_in.default_input_space)
    on_cpu = processor.getDefaultCPUProcessor()
    columns = [on_cpu.applyRGB(list(light)) for light in np.eye(3)]
    assert np.allclose(to_rec709(primaries), np.transpose(columns), rtol=0, atol=1e-6)


def test_input_space_of_aces_container_is_aces(built_in):
    assert input_space_of(built_in, {"acesImageContainerFlag": 1}).name == "ACES2065-1"
    assert header_primaries({"acesImageContainerFlag": 0}) is None


@given(
    st.sampled_from(KNOWN),
    st.lists(st.floats(-0.9 * TOLERANCE, 0.9 * TOLERANCE), min_size=8, max_size=8),
)
def test_header_primaries_tolerate_rounding(primaries, errors):
    primaries_found = header_primaries(
        {"chromaticities": tuple(np.add(primaries.chromaticities, errors))}
    )
    assert primaries_found is not None and primaries_found.known == primaries


@given(st.sampled_from(KNOWN), st.integers(0, 7), st.sampled_from([-1, 1]))
def test_header_primaries_reject_larger_differences(primaries: Primaries, at: int, side: int):
    values = list(primaries.chromaticities)
    values[at] += side * 1.5 * TOLERANCE
    primaries_found = header_primaries({"chromaticities": tuple(values)})
    assert primaries_found is not None and primaries_found.known is None


def test_known_primaries_differ_by_more_than_tolerance():
    for first_space, second_space in itertools.combinations(KNOWN, 2):
        assert (
            np.abs(np.subtract(first_space.chromaticities, second_space.chromaticities)).max()
            > 4 * TOLERANCE
        )


@pytest.mark.parametrize(
    "attributes",
    [
        {},
        {"chromaticities": (0.64, 0.33)},
        {"chromaticities": "wide"},
        {"colorInteropID": "unknown"},
        {"colorInteropID": "data"},
        {"colorInteropID": 3},
        {"acesImageContainerFlag": "yes"},
    ],
)
def test_input_space_without_primaries_is_default(built_in, attributes):
    light = input_space_of(built_in, attributes)
    assert (light.name, light.note) == (built_in.default_input_space, "")
    assert input_space_of(None, attributes).name == REC709.name


def test_input_space_of_impossible_primaries_is_default_with_note(built_in):
    for values in (NO_TRIANGLE, (np.nan,) * 8):
        for config in (built_in, None):
            light = input_space_of(config, {"chromaticities": values})
            usual = REC709.name if config is None else built_in.default_input_space
            assert light.name == usual
            assert light.note.count(". ") == 0 and usual in light.note
            assert f"{values[0]:.4g}" in light.note


def test_input_space_of_unknown_primaries_uses_a_matrix(built_in):
    """Primaries slightly off a known space lose its name, but look as that space does."""
    for known_space in KNOWN[:6]:
        values = tuple(np.add(known_space.chromaticities, 2.5 * TOLERANCE))
        attributes = {"chromaticities": values}
        for config in (built_in, None):
            light = input_space_of(config, attributes)
            assert light.source_primaries is not None and not light.note
            assert light.source_primaries.chromaticities == pytest.approx(values)
            named = input_space_of(config, {"chromaticities": known_space.chromaticities})
            shown_colors = [show_colors(config, space) for space in (light, named)]
            np.testing.assert_allclose(*shown_colors, atol=0.03)


def show_colors(config, light):
    colors = np.float32([[[0.2, 0.2, 0.2], [0.3, 0.1, 0.05], [0.1, 0.3, 0.4], [0.9, 0.9, 0.9]]])
    if config is None:
        return srgb_transform(light.name, light.source_primaries).apply_cpu(colors)
    view = "Un-tone-mapped"
    display = config.default_display
    return view_transform(config, display, view, light.name, light.source_primaries).apply_cpu(
        colors
    )


def test_to_rec709_of_unknown_primaries_keeps_white(built_in):
    light = input_space_of(built_in, {"chromaticities": UNKNOWN})
    np.testing.assert_allclose(to_rec709(light.source_primaries) @ np.ones(3), 1.0, atol=1e-9)


def test_input_space_missing_in_config_is_noted(tmp_path):
    path = tmp_path / "small.ocio"
    path.write_text(
        "ocio_profile_version: 2\nroles: {default: plain, scene_linear: plain}\n"
        "displays: {Screen: [!<View> {name: Raw, colorspace: plain}]}\n"
        "colorspaces:\n  - !<ColorSpace> {name: plain, aliases: [house], encoding: scene-linear}\n"
    )
    config = load_color_config(str(path))
    light = input_space_of(config, {"colorInteropID": "lin_ap1_scene"})
    assert light.name == "plain" and "small.ocio has no ACEScg" in light.note
    assert input_space_of(config, {"colorInteropID": "house"}).note == ""


def test_input_space_chosen_by_user_overrides_header(built_in):
    for attributes in ({}, {"chromaticities": UNKNOWN}, {"acesImageContainerFlag": 1}):
        light = input_space_of(built_in, attributes, "Linear Rec.2020")
        assert (light.name, light.note) == ("Linear Rec.2020", "")


@known
def test_info_names_input_space(tmp_path, capsys, primaries):
    path = write_plate_with_header(tmp_path, chromaticities=primaries.chromaticities)
    assert main(["info", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert f"primaries       {primaries.name} (header: chromaticities)" in lines


def test_info_prints_unknown_primaries_or_none(tmp_path, capsys):
    path = write_plate_with_header(tmp_path, chromaticities=UNKNOWN)
    assert main(["info", str(path)]) == 0
    assert "red 0.7 0.3, green 0.2 0.7, blue 0.14 0.05, white 0.31 0.33" in capsys.readouterr().out
    assert main(["info", str(path), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["primaries"]
    assert (facts["attribute"], facts["space"]) == ("chromaticities", None)
    assert facts["by_matrix"]
    assert main(["info", str(write_plate_with_header(tmp_path)), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["primaries"] is None
