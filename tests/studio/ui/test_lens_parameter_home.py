"""All facts of a keyed parameter are in `LensParameter`: no list elsewhere names several members.

The test reads the syntax trees of the program, so a new member cannot be left out.
"""

import argparse
import ast
from pathlib import Path
from types import SimpleNamespace

import pytest

import heatlens
from heatlens.core.model.curves.curve import Key
from heatlens.core.model.keys.key_rows import ROWS, shown_rows
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.fronts.commands.shots.shot_new import add_shot_options
from heatlens.fronts.commands.shots.typed_keys import PARAMETER_BY_NAME, parse_keys
from heatlens.studio.ui.setting_places import SETTINGS
from heatlens.studio.ui.timeline import dope_sheet
from heatlens.studio.ui.timeline.curve_axis import AXES

PACKAGE = Path(heatlens.__file__).parent
HOME = PACKAGE / "core/model/shot/lens_parameter.py"
VALUES = {"f_stop": 2.8, "focal_length_mm": 35.0, "squeeze": 1.5, "tilt_deg": 2.0}


def lists_in(text: str) -> list[int]:
    """Return the lines of literals that name two or more members."""
    if "LensParameter." not in text:  # most files, which need not be parsed
        return []
    literals = (ast.Dict, ast.Tuple, ast.List, ast.Set)
    return [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, literals) and len(members_in(node)) > 1
    ]


def members_in(node: ast.AST) -> set[str]:
    return {
        it.attr
        for it in ast.walk(node)
        if isinstance(it, ast.Attribute) and ast.unparse(it.value) == "LensParameter"
    }


def test_lists_in_finds_lists_of_two_or_more_members():
    assert lists_in("A = {LensParameter.TILT: 1,\n LensParameter.SPLIT: 2}") == [1]
    assert lists_in("A = LensParameter.TILT, LensParameter.SPLIT") == [1]
    assert lists_in("f(LensParameter.TILT, 1)\nB = (LensParameter.TILT, 2)") == []


def test_no_list_of_lens_parameters_outside_their_module():
    lists_by_path = {
        str(path.relative_to(PACKAGE)): lines
        for path in PACKAGE.rglob("*.py")
        if path != HOME and (lines := lists_in(path.read_text()))
    }
    assert lists_by_path == {}
    assert lists_in(HOME.read_text())


@pytest.mark.parametrize("parameter", LensParameter)
def test_each_lens_parameter_has_row_curve_option_and_control(parameter):
    """Check the rows, the curves and their axes, `--key`, the option and the Lens panel."""
    value = VALUES.get(parameter, 0.5)
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0)).with_key(1, parameter, value)
    assert parameter in ROWS and parameter in shown_rows(shot, has_camera=False)
    axis = AXES[parameter]
    assert axis.value_at(axis.level_of(value)) == pytest.approx(value)
    assert axis.visible_labels(*sorted((axis.level_of(value), axis.level_of(1.1 * value))), 0.01)
    assert parse_keys([f"{parameter.typed}@1={value}"]) == {parameter: [Key(1.0, value)]}
    parser = argparse.ArgumentParser()
    add_shot_options(parser)
    assert (
        hasattr(parser.parse_args([]), parameter.attribute) and parameter.typed in PARAMETER_BY_NAME
    )
    assert parameter.control in SETTINGS["Lens"] and str(parameter) in options_of(Lens)
    assert LensCurves().of(parameter).scale is parameter.facts.scales[0]


def test_lens_dots_draw_a_key_dot_for_each_parameter(monkeypatch):
    dots = []
    monkeypatch.setattr(dope_sheet, "key_dot", lambda _control, row, *_place: dots.append(row))
    monkeypatch.setattr(dope_sheet.imgui, "get_font_size", lambda: 10.0)
    keyed = Shot(Lens(50.0, 2.0, 2.0, 36.0)).with_key(1, LensParameter.F_STOP, 2.8)
    control = SimpleNamespace(editing=SimpleNamespace(shot=keyed))
    rects = {it.control: (0.0, 0.0, 1.0, 1.0) for it in LensParameter}
    dope_sheet.lens_dots(control, rects, is_pointed_at=True)
    assert dots == list(LensParameter)
    dots.clear()
    dope_sheet.lens_dots(control, rects, is_pointed_at=False)
    assert dots == [LensParameter.F_STOP]


def test_lens_parameter_shows_values_with_their_unit():
    shown = {it: it.format_value(VALUES.get(it, 0.5), "m") for it in LensParameter}
    assert list(shown.values()) == ["0.5 m", "f/2.8", "35 mm", "1.5 x", "2°", "0.5 D"]
    assert LensParameter.FOCUS_DISTANCE.format_value(1.905, "ft") == "6'3\""
