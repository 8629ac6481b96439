"""Check for every depth convention that its facts agree with the reader, options and manual. Each
test runs over all members, so a convention that is added later is checked as well.
"""

import re
from argparse import ArgumentParser
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PictureCurve, PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.options.lens_options import add_plate_options, plate_options
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, write_file
from support.manual import manual_text, page

RAMP = np.linspace(0.25, 0.75, 24, dtype=np.float32).reshape(4, 6)
ENDS = {"near_m": 1.0, "far_m": 5.0}
CHOSEN = [c for c in DepthConvention if c is not DepthConvention.AUTO]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_file(tmp_path / "plate.exr", rgb(4, 6) | {"Z": RAMP})


def options_for(convention: DepthConvention, **fields: float) -> PlateOptions:
    ends = ENDS if convention.facts.takes_ends else {}
    return PlateOptions(depth_convention=convention, **ends, **fields)


@pytest.mark.parametrize("convention", CHOSEN)
def test_read_plate_and_inspect_report_requested_convention(path, convention):
    plate = read_plate(path, options_for(convention))
    assert plate.depth.convention is convention
    assert inspect(path, options_for(convention))["depth"]["convention"] == str(convention)


@pytest.mark.parametrize("convention", CHOSEN)
def test_read_plate_requires_ends_only_if_convention_needs_them(path, convention):
    bare = PlateOptions(depth_convention=convention)
    if convention.facts.needs_ends:
        with pytest.raises(InputError, match="--near and --far"):
            read_plate(path, bare)
    else:
        assert read_plate(path, bare).depth.convention is convention


@pytest.mark.parametrize("convention", CHOSEN)
def test_near_and_far_change_depth_only_if_convention_takes_them(path, convention):
    near = read_plate(path, PlateOptions(depth_convention=convention, near_m=1.0, far_m=5.0))
    far = read_plate(path, PlateOptions(depth_convention=convention, near_m=2.0, far_m=9.0))
    is_same = np.array_equal(depth_values_of(near), depth_values_of(far))
    assert is_same is not convention.facts.takes_ends


@pytest.mark.parametrize("convention", CHOSEN)
def test_scene_unit_scales_depth_only_if_convention_has_a_unit(path, convention):
    metres = depth_values_of(read_plate(path, options_for(convention)))
    centimetres = depth_values_of(read_plate(path, options_for(convention, scene_unit_m=0.01)))
    factor = 0.01 if convention.facts.has_unit else 1.0
    np.testing.assert_allclose(centimetres, factor * metres, rtol=1e-6)


@pytest.mark.parametrize("convention", CHOSEN)
def test_plate_has_circles_of_confusion_or_depth_by_convention(path, convention):
    plate = read_plate(path, options_for(convention))
    assert (plate.coc_px is not None) is convention.facts.is_coc
    assert plate.has_distances is not convention.facts.is_coc


def depth_values_of(plate) -> np.ndarray:
    return plate.depth_m if plate.coc_px is None else plate.coc_px


def test_depth_convention_labels_are_unique():
    labels = [convention.facts.label for convention in DepthConvention]
    assert len(set(labels)) == len(labels)
    assert len({kind.label for kind in DepthKind}) == len(DepthKind)


@pytest.mark.parametrize("convention", DepthConvention)
def test_command_line_accepts_and_manual_explains_each_convention(convention):
    parser = ArgumentParser()
    add_plate_options(parser)
    args = parser.parse_args(["--depth-convention", str(convention)])
    assert plate_options(args).depth_convention is convention
    assert f"| `{convention}` | {convention.facts.meaning} |" in manual_text()


def test_command_line_error_lists_all_conventions(capsys):
    parser = ArgumentParser()
    add_plate_options(parser)
    with pytest.raises(SystemExit):
        parser.parse_args(["--depth-convention", "log"])
    stderr = capsys.readouterr().err
    assert all(f"'{convention}'" in stderr for convention in DepthConvention) and "<" not in stderr


@pytest.mark.parametrize("convention", DepthConvention)
def test_shot_file_keeps_depth_convention(tmp_path, convention):
    options = PlateOptions(depth_convention=convention, depth_kind=DepthKind.RADIAL)
    shot = Shot(Lens(50, 2, 3, 36), source=str(tmp_path / "a.exr"), plate_options=options)
    path = tmp_path / "a.heatlens.json"
    write_shot(path, shot)
    assert read_shot(path).plate_options == options


def test_plate_options_accept_names_of_enums():
    options = PlateOptions(depth_convention="inverse", depth_kind="radial", picture_curve="srgb")
    assert options.depth_convention is DepthConvention.INVERSE
    assert options.depth_kind is DepthKind.RADIAL and options.picture_curve is PictureCurve.SRGB
    with pytest.raises(InputError, match="'log' is not a depth convention; known are auto, "):
        replace(options, depth_convention="log")


def test_manual_table_agrees_with_convention_facts():
    rows = re.findall(r"^\| `([a-z-]+)` \| (.*) \| (.*) \| (.*) \|$", page("depth"), re.M)
    manual_rows = {name: (meaning, ends, unit) for name, meaning, ends, unit in rows}
    for convention in DepthConvention:
        meaning, ends, unit = manual_rows[str(convention)]
        facts = convention.facts
        assert meaning == facts.meaning
        assert (ends != "-") is facts.takes_ends and (ends == "needed") is facts.needs_ends
        assert unit == ("counts" if facts.has_unit else "-")
