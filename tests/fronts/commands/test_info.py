"""Test `heatlens info`: the printed text and the exit code."""

import argparse
import json

import numpy as np
import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.fronts.commands import info
from heatlens.fronts.commands.command_parser import add_command
from support.command_line import stderr_of_run
from support.exr_files import distances, rgb, window, write_file, write_parts


def run_info(capsys, *words):
    """Return stdout of `heatlens info WORDS`, which must succeed with an empty stderr."""
    parser = argparse.ArgumentParser()
    add_command(parser.add_subparsers(), "info", "", info)
    args = parser.parse_args(["info", *map(str, words)])
    assert args.run(args) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    return printed.out


def lines_of(text):
    """Return the aligned lines as label -> value."""
    return {line[:16].strip(): line[16:] for line in text.splitlines()}


def test_info_describes_plate_with_camera(tmp_path, capsys):
    depth = distances()
    depth[0, 0] = 1e10
    path = write_file(
        tmp_path / "shot.exr",
        rgb() | {"Z": depth, "A": np.ones((6, 8), np.float16)},
        dataWindow=window(-2, 1, 6, 7),
        displayWindow=window(0, 0, 10, 8),
        pinholeFocalLength=50.0,
        focus=float("inf"),
    )
    lines = lines_of(run_info(capsys, path))
    assert lines["size"] == "8 x 6 px"
    assert lines["data window"] == "(-2, 1) to (5, 6)"
    assert lines["display window"] == "(0, 0) to (9, 7)"
    assert lines["part 1"] == "scanlineimage, zip"
    assert (lines["half"], lines["float"]) == ("A, B, G, R", "Z")
    assert lines["focal length"] == "50 mm (header: pinholeFocalLength)"
    assert lines["focus distance"] == "infinity m (header: focus)"
    assert lines["colour"] == "RGB, with alpha"
    assert lines["colour range"] == "0 to 43.75, 0 NaN, 0 infinite"
    assert lines["depth"] == "Z, distance, planar"
    assert "above 1, so they are distances" in lines["why"]
    assert lines["range"] == "2.25 to 13.75 m"
    assert lines["counts"] == "1 px infinite, 0 px repaired"


def test_info_names_impossible_lens_values_of_header(tmp_path, capsys):
    path = write_file(tmp_path / "p.exr", rgb() | {"Z": distances()}, aperture=0.0)
    lines = lines_of(run_info(capsys, path))
    assert lines["f-stop"].startswith("none") and "aperture is 0" in lines["f-stop"]
    assert "camera" not in lines and "focal length" not in lines


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        ({}, "photographic (the header names no CG renderer)"),
        ({"cycles.ViewLayer.samples": "64"}, "renderer (header, written by Blender)"),
        ({"heatlens:lensModel": "renderer"}, "renderer (header, heatlens:lensModel)"),
    ],
)
def test_info_gives_lens_model_and_its_reason(tmp_path, capsys, header, expected):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": distances()}, **header)
    assert lines_of(run_info(capsys, path))["lens model"] == expected


def test_info_json_holds_facts_of_plate(tmp_path, capsys):
    channels = rgb(dtype=np.float32) | {"Z": np.full((6, 8), np.inf, np.float32)}
    channels["R"][0, 0] = np.nan
    path = write_file(tmp_path / "shot.exr", channels)
    facts = json.loads(run_info(capsys, path, "--json"))
    assert (facts["width_px"], facts["height_px"]) == (8, 6)
    assert facts["color"]["nan_count"] == 1
    assert facts["parts"][0]["channels"]["Z"] == "float"
    assert facts["depth"]["convention"] == "distance"
    assert facts["depth"]["near_m"] == "infinity" and facts["depth"]["infinite_count"] == 48
    assert len(facts["notes"]) == 2


def test_info_of_plate_without_depth_succeeds(tmp_path, capsys):
    text = run_info(capsys, write_file(tmp_path / "a.exr", rgb()))
    assert "none: " in lines_of(text)["depth"] and "--depth-channel" in text


def test_info_of_plate_without_color_succeeds(tmp_path, capsys):
    lines = lines_of(run_info(capsys, write_file(tmp_path / "a.exr", {"Z": distances()})))
    assert "no colour" in lines["colour"] and lines["range"] == "2 to 13.75 m"


def test_info_suggests_options_for_ambiguous_depth(tmp_path, capsys):
    path = write_file(tmp_path / "a.exr", rgb() | {"Z": distances() / 20})
    assert "--depth-convention normalized" in lines_of(run_info(capsys, path))["depth"]
    words = ("--depth-convention", "normalized", "--near", "2", "--far", "12")
    assert lines_of(run_info(capsys, path, *words))["range"] == "3 to 8.875 m"
    words = ("--depth-convention", "distance", "--scene-unit", "cm")
    assert lines_of(run_info(capsys, path, *words))["range"] == "0.001 to 0.006875 m"


def test_info_shows_coc_range_in_pixels(tmp_path, capsys):
    coc = np.linspace(-4, 6, 48, dtype=np.float32).reshape(6, 8)
    path = write_file(tmp_path / "a.exr", rgb() | {"coc": coc})
    lines = lines_of(run_info(capsys, path, "--depth-convention", "coc"))
    assert lines["range"] == "-4 to 6 px, signed diameter"


def test_info_lists_parts_and_converts_radial_depth(tmp_path, capsys):
    path = write_parts(
        tmp_path / "a.exr",
        ({"name": "rgba"}, rgb()),
        ({"name": "depth"}, {"Z": np.full((6, 8), 4, np.float32)}),
    )
    words = ("--depth-kind", "radial", "--focal-length", "36", "--sensor-width", "36")
    lines = lines_of(run_info(capsys, path, *words))
    assert lines["part 2"] == "scanlineimage, zip 'depth'"
    assert lines["depth"] == "depth.Z, distance, radial"
    # Half a pixel off the axis either way: 4 / sqrt(1 + 2 (0.5/8)^2).
    assert lines["range"].endswith(" to 3.9845 m")


@pytest.mark.parametrize("words", [("--scene-unit", "parsec"), ("--scene-unit", "-1")])
def test_info_rejects_bad_scene_units(tmp_path, capsys, words):
    path = write_file(tmp_path / "a.exr", rgb())
    with pytest.raises(HeatlensError):
        run_info(capsys, path, *words)


@pytest.mark.parametrize("number", ["inf", "nan", "near"])
def test_info_rejects_bad_near_values(capsys, number):
    with pytest.raises(SystemExit):
        run_info(capsys, "a.exr", "--near", number)
    assert "--near" in capsys.readouterr().err


def test_info_of_shot_file_refers_to_shot_show(tmp_path, capsys):
    message = stderr_of_run(capsys, 2, "info", tmp_path / "pull.heatlens.json")
    assert "pull.heatlens.json is a shot file: `heatlens shot show " in message
