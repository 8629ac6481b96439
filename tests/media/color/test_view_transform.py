"""Test color configs and view transforms on the CPU against closed-form curves and matrices."""

import sys

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.color.color_config import BUILT_IN, ColorConfig, load_color_config
from heatlens.media.color.view_transform import ViewTransform, srgb_transform, view_transform
from heatlens.media.plate.picture.display import encode_srgb

HALVING = "!<MatrixTransform> {matrix: [0.5,0,0,0, 0,0.5,0,0, 0,0,0.5,0, 0,0,0,1]}"
STUDIO = f"""ocio_profile_version: 2
roles: {{default: half, scene_linear: plain}}
displays:
  Screen:
    - !<View> {{name: Dim, colorspace: half}}
    - !<View> {{name: Table, colorspace: table}}
    - !<View> {{name: Broken, colorspace: nowhere}}
colorspaces:
  - !<ColorSpace> {{name: plain, encoding: scene-linear}}
  - !<ColorSpace> {{name: other, encoding: scene-linear, to_scene_reference: {HALVING}}}
  - !<ColorSpace> {{name: half, encoding: sdr-video, from_scene_reference: {HALVING}}}
  - !<ColorSpace> {{name: table, from_scene_reference: !<FileTransform> {{src: table.cube}}}}
  - !<ColorSpace> {{name: labels, isdata: true}}
"""
LIGHT = np.array([[[0.0, 0.18, 1.0], [4.0, 0.002, 0.5]]], np.float32)


@pytest.fixture(autouse=True)
def no_config_in_the_environment(monkeypatch):
    monkeypatch.delenv("OCIO", raising=False)


@pytest.fixture
def write_config(tmp_path):
    def write(text: str = STUDIO, name: str = "studio.ocio") -> str:
        (tmp_path / name).write_text(text)
        return str(tmp_path / name)

    return write


@pytest.fixture(scope="module")
def built_in() -> ColorConfig:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("OCIO", raising=False)
        return load_color_config(None)


def default_view(config: ColorConfig) -> ViewTransform:
    return view_transform(
        config, config.default_display, config.default_view, config.default_input_space
    )


def test_load_color_config_prefers_path_then_ocio_variable_then_built_in(write_config, monkeypatch):
    given_path = write_config(STUDIO.replace("Screen", "Given"), "given.ocio")
    named_path = write_config(STUDIO.replace("Screen", "Named"), "named.ocio")
    assert load_color_config(None).source == f"built-in {BUILT_IN}"
    monkeypatch.setenv("OCIO", named_path)
    assert load_color_config(None).displays() == ("Named",)
    assert load_color_config(None).source == f"$OCIO {named_path}"
    assert load_color_config(given_path).displays() == ("Given",)
    assert load_color_config(given_path).source == given_path


def test_load_color_config_ignores_empty_ocio_variable(monkeypatch):
    monkeypatch.setenv("OCIO", "")
    assert load_color_config(None).source == f"built-in {BUILT_IN}"


def test_load_color_config_accepts_name_of_built_in_config(monkeypatch):
    monkeypatch.setenv("OCIO", f"ocio://{BUILT_IN}")
    assert load_color_config(None).default_display == "sRGB - Display"


def test_built_in_config_has_default_display_view_and_input_spaces(built_in):
    assert built_in.default_display in built_in.displays()
    assert built_in.default_view in built_in.views(built_in.default_display)
    assert built_in.default_input_space == "Linear Rec.709 (sRGB)"
    spaces = built_in.input_spaces()
    assert spaces[0] == built_in.default_input_space
    assert {"ACEScg", "ACES2065-1", "Linear Rec.2020"} < set(spaces)
    assert not {"Raw", "ACEScct"} & set(spaces)
    assert len(set(spaces)) == len(spaces)


def test_default_input_space_falls_back_to_scene_linear_role(write_config):
    config = load_color_config(write_config())
    assert config.default_input_space == "plain"
    assert config.input_spaces() == ("plain", "other")


def test_default_input_space_finds_linear_rec709_by_alias(write_config):
    config_text = STUDIO.replace("{name: other,", "{name: odd, aliases: [lin_rec709_scene],")
    config = load_color_config(write_config(config_text))
    assert config.default_input_space == "odd"
    assert config.input_spaces() == ("odd", "plain")


def test_input_spaces_without_scene_linear_encoding_are_all_but_data(write_config):
    unmarked = STUDIO.replace(", encoding: scene-linear", "").replace(", encoding: sdr-video", "")
    config = load_color_config(write_config(unmarked))
    assert config.input_spaces() == ("plain", "other", "half", "table")


def test_default_input_space_without_any_role_raises_input_error(write_config):
    config = load_color_config(write_config(STUDIO.replace(", scene_linear: plain", "")))
    with pytest.raises(InputError, match=r"studio\.ocio.*scene_linear"):
        _ = config.default_input_space


@pytest.mark.parametrize(
    "text",
    ["", "[", "ocio_profile_version: 99", "ocio_profile_version: 2\nroles: {default: raw}", None],
    ids=["empty", "no YAML", "from the future", "no display", "missing"],
)
def test_load_color_config_reports_bad_config_in_one_sentence(write_config, tmp_path, text):
    path = str(tmp_path / "gone.ocio") if text is None else write_config(text, "bad.ocio")
    with pytest.raises(InputError) as error:
        load_color_config(path)
    assert str(error.value).startswith(path)
    assert "\n" not in str(error.value)


def test_load_color_config_error_names_ocio_variable(monkeypatch):
    monkeypatch.setenv("OCIO", "ocio://nothing")
    with pytest.raises(InputError, match=r"\$OCIO ocio://nothing .*nothing"):
        load_color_config(None)


def test_load_color_config_rejects_path_that_is_no_unicode():
    with pytest.raises(InputError, match="Unicode"):
        load_color_config("studio\udcff.ocio")


def test_load_color_config_without_library_names_package_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "PyOpenColorIO", None)
    with pytest.raises(InputError, match="pip install opencolorio"):
        load_color_config(None)
    assert srgb_transform().apply_cpu(LIGHT).shape == LIGHT.shape


@pytest.mark.parametrize(
    ("display", "view", "space", "words"),
    [
        ("Wall", "Dim", "plain", "display 'Wall' is not known; there are: Screen"),
        (
            "Screen",
            "Bright",
            "plain",
            "view of Screen 'Bright' is not known; there are: Dim, Table, Broken",
        ),
        ("Screen", "Dim", "ACEScg", "ACEScg"),
        ("Screen", "Broken", "plain", "nowhere"),
        ("Screen", "Table", "plain", r"table\.cube"),
    ],
    ids=["display", "view", "input space", "view of nothing", "missing table"],
)
def test_view_transform_reports_unknown_names_in_one_sentence(
    write_config, display, view, space, words
):
    config = load_color_config(write_config())
    with pytest.raises(InputError, match=words) as error:
        view_transform(config, display, view, space)
    assert str(error.value).startswith(config.source)
    assert "\n" not in str(error.value)


def test_view_transform_works_beside_a_broken_view(write_config):
    config = load_color_config(write_config())
    shown = view_transform(config, "Screen", "Dim", "plain").apply_cpu(LIGHT)
    np.testing.assert_allclose(shown, 0.5 * LIGHT, rtol=1e-6)
    shown = view_transform(config, "Screen", "Dim", "other").apply_cpu(LIGHT)
    np.testing.assert_allclose(shown, 0.25 * LIGHT, rtol=1e-6)


def test_srgb_transform_equals_srgb_encoded(rng):
    light = rng.uniform(-0.5, 2.0, (5, 7, 3)).astype(np.float32)
    np.testing.assert_array_equal(srgb_transform().apply_cpu(light), encode_srgb(light))
    np.testing.assert_array_equal(srgb_transform().apply_cpu(light, 1.0), encode_srgb(2 * light))


def test_built_in_srgb_view_without_tone_mapping_is_srgb_curve(built_in):
    light = np.linspace(0, 1, 300, dtype=np.float32).reshape(10, 10, 3)
    plain = view_transform(built_in, "sRGB - Display", "Un-tone-mapped", "Linear Rec.709 (sRGB)")
    np.testing.assert_allclose(plain.apply_cpu(light), encode_srgb(light), atol=1e-4)


def test_apply_cpu_exposure_multiplies_light_by_power_of_two(built_in):
    view = default_view(built_in)
    brighter = view.apply_cpu(LIGHT, exposure_stops=1.5)
    np.testing.assert_allclose(brighter, view.apply_cpu(LIGHT * np.float32(2**1.5)), atol=1e-6)


def test_apply_cpu_gamma_is_power_of_display_value_and_keeps_sign(write_config):
    raw = view_transform(load_color_config(write_config()), "Screen", "Dim", "plain")
    light = np.array([[[0.5, 2.0, -0.5]]], np.float32)
    np.testing.assert_allclose(raw.apply_cpu(light, gamma=2.0), [[[0.5, 1.0, -0.5]]], rtol=1e-6)


def test_apply_cpu_of_nan_and_infinity_is_finite(built_in):
    wild = np.array([[[np.nan, np.inf, -np.inf], [3e38, -3e38, 1e-45]]], np.float32)
    for transform in (srgb_transform(), default_view(built_in)):
        assert np.isfinite(transform.apply_cpu(wild, exposure_stops=8.0, gamma=0.5)).all()
    black = default_view(built_in).apply_cpu(np.zeros((1, 1, 3), np.float32))
    missing = default_view(built_in).apply_cpu(np.full((1, 1, 3), np.nan, np.float32))
    np.testing.assert_array_equal(missing, black)


def test_apply_cpu_does_not_change_its_input(built_in):
    light = LIGHT.copy()
    default_view(built_in).apply_cpu(light)
    np.testing.assert_array_equal(light, LIGHT)


def test_view_transforms_of_equal_choices_are_equal(built_in):
    assert default_view(built_in) == default_view(load_color_config(None))
    views = [
        view_transform(built_in, "sRGB - Display", v, "ACEScg")
        for v in ("Raw", "Video (colorimetric)")
    ]
    assert len({default_view(built_in), *views}) == 3
