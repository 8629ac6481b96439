"""Test ASC CDL grades: their files, and the view against the formula of the standard."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import ocio
from heatlens.core.model.shot.grade import Grade, parse_grade
from heatlens.media.color.color_config import ColorConfig, load_color_config
from heatlens.media.color.grade_file import parse_or_read_grade, read_grade
from heatlens.media.color.view_transform import ViewTransform, view_transform
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.gpu.textures import download, new_texture, upload

GRADE = Grade((1.1, 1.0, 0.9), (0.01, 0.0, -0.02), (1.0, 1.1, 0.9), 0.8)
LUMA = np.array([0.2126, 0.7152, 0.0722])
LIGHT = np.random.default_rng(5).uniform(0.01, 8.0, (6, 7, 3)).astype(np.float32)
CORRECTION = """<ColorCorrection id="{name}"><SOPNode><Slope>{slope} 1 0.9</Slope>
<Offset>0.01 0 -0.02</Offset><Power>1 1.1 0.9</Power></SOPNode>
<SatNode><Saturation>0.8</Saturation></SatNode></ColorCorrection>"""


def corrections(*slopes: str) -> str:
    return "".join(CORRECTION.format(name=f"shot{n}", slope=it) for n, it in enumerate(slopes))


@pytest.fixture(scope="module")
def config() -> ColorConfig:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("OCIO", raising=False)
        return load_color_config(None)


def graded_view(config: ColorConfig, view: str, grade: Grade | None = None) -> ViewTransform:
    display, space = config.default_display, config.default_input_space
    return view_transform(config, display, view, space, grade=grade)


def cdl_formula(values: np.ndarray, grade: Grade) -> np.ndarray:
    """Return what the standard says, in float64; numbers below 0 have no power."""
    sop = values * np.array(grade.slope) + np.array(grade.offset)
    graded = np.where(sop > 0, np.abs(sop) ** np.array(grade.power), sop)
    luma = (graded @ LUMA)[..., None]
    return luma + grade.saturation * (graded - luma)


def convert_space(config: ColorConfig, light: np.ndarray, source: str, target: str) -> np.ndarray:
    out = np.array(light, np.float32, order="C")
    processor = config.config.getProcessor(ocio().ColorSpaceTransform(src=source, dst=target))
    processor.getDefaultCPUProcessor().applyRGB(out)
    return out


def test_graded_view_applies_cdl_formula_in_acescct(config):
    linear = config.default_input_space
    graded = cdl_formula(convert_space(config, LIGHT, linear, "ACEScct").astype(np.float64), GRADE)
    expected = convert_space(config, graded.astype(np.float32), "ACEScct", linear)
    for view in ("Un-tone-mapped", config.default_view):
        shown = graded_view(config, view, GRADE).apply_cpu(LIGHT)
        np.testing.assert_allclose(shown, graded_view(config, view).apply_cpu(expected), atol=2e-4)
        assert np.abs(shown - graded_view(config, view).apply_cpu(LIGHT)).max() > 0.05


def test_graded_view_of_raw_numbers_ignores_grade(config):
    assert graded_view(config, "Raw", GRADE).key == graded_view(config, "Raw").key


def test_view_with_neutral_grade_is_unchanged(config):
    plain = graded_view(config, "Un-tone-mapped")
    same = graded_view(config, "Un-tone-mapped", Grade()).apply_cpu(LIGHT)
    np.testing.assert_allclose(same, plain.apply_cpu(LIGHT), atol=1e-4)


def test_display_pass_draws_grade_as_cpu_does(ctx, config):
    transform = graded_view(config, config.default_view, GRADE)
    rgba = np.concatenate([LIGHT, np.ones((6, 7, 1), np.float32)], axis=2)
    display, picture = DisplayPass(ctx), new_texture(ctx, (7, 6), 4)
    out = new_texture(ctx, (7, 6), 4)
    upload(picture, rgba)
    display.set_transform(transform)
    display.run(picture, out)
    np.testing.assert_allclose(download(out)[..., :3], transform.apply_cpu(LIGHT), atol=2e-3)
    display.release()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.cc", corrections("1.1")),
        ("a.ccc", f"<ColorCorrectionCollection>{corrections('1.1')}</ColorCorrectionCollection>"),
        (
            "a.cdl",
            "<ColorDecisionList><ColorDecision>"
            f"{corrections('1.1')}</ColorDecision></ColorDecisionList>",
        ),
    ],
)
def test_read_grade_reads_cc_ccc_and_cdl_files(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    assert read_grade(tmp_path / name) == GRADE == parse_or_read_grade(str(tmp_path / name))


def test_parse_or_read_grade_selects_correction_by_id(tmp_path):
    path = tmp_path / "a.ccc"
    text = f"<ColorCorrectionCollection>{corrections('1.1', '1.5')}</ColorCorrectionCollection>"
    path.write_text(text)
    assert parse_or_read_grade(f"{path}#shot1").slope[0] == 1.5
    with pytest.raises(InputError, match="nobody"):
        parse_or_read_grade(f"{path}#nobody")


def test_read_grade_rereads_changed_file(tmp_path):
    path = tmp_path / "a.cc"
    for slope in ("1.1", "1.7"):
        path.write_text(corrections(slope))
        assert read_grade(path).slope[0] == float(slope)


@pytest.mark.parametrize("text", ["", "x", "<ColorCorrection", corrections("-1"), "\0"])
def test_read_grade_rejects_damaged_or_missing_file_by_name(tmp_path, text):
    path = tmp_path / "a.cc"
    path.write_text(text)
    with pytest.raises(InputError, match=r"a\.cc"):
        read_grade(path)
    with pytest.raises(InputError, match=r"gone\.cc"):
        read_grade(Path("gone.cc"))


POSITIVE = st.floats(0.01, 10.0)
THREE = st.tuples(POSITIVE, POSITIVE, POSITIVE)


@given(st.builds(Grade, THREE, THREE, THREE, st.floats(0.0, 4.0)))
def test_parse_grade_reads_back_text_of_any_grade(grade):
    parsed = parse_grade(str(grade))
    for name in ("slope", "offset", "power", "saturation"):
        np.testing.assert_allclose(getattr(parsed, name), getattr(grade, name), rtol=1e-9)


@pytest.mark.parametrize(
    "text",
    ["", "1", "1,1,1 0,0,0 1,1,1", "1,1 0,0,0 1,1,1 1", "1,1,1 0,0,0 1,1,x 1", "none at all"],
)
def test_parse_grade_rejects_malformed_text_with_expected_form(text):
    with pytest.raises(InputError, match="SLOPE OFFSET POWER SATURATION"):
        parse_grade(text)


@pytest.mark.parametrize(
    "text", ["-1,1,1 0,0,0 1,1,1 1", "1,1,1 0,0,0 0,1,1 1", "1,1,1 nan,0,0 1,1,1 1"]
)
def test_parse_grade_rejects_impossible_numbers(text):
    with pytest.raises(InputError, match="grade"):
        parse_grade(text)
