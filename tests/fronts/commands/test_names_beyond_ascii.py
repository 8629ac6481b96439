"""Test file names outside the locale: files open, and unprintable characters are escaped."""

import os

import numpy as np
import pytest

import heatlens
from support.command_line import ENVIRONMENT, start_heatlens
from support.exr_files import distances, rgb, write_file
from support.patience import PATIENCE_S

NAME = "a b ü日"
LENS = ("--f-stop", "2", "--focus-distance", "3", "--focal-length", "50", "--sensor-width", "36")


@pytest.mark.parametrize(
    "locale",
    [
        {"LC_ALL": "POSIX", "PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
    ids=["terminal", "files"],
)
def test_render_handles_file_names_outside_locale(tmp_path, locale):
    plate = write_file(tmp_path / f"{NAME}.exr", rgb() | {"Z": distances()})
    environment = ENVIRONMENT | locale
    for suffix in (".exr", ".png"):
        out = tmp_path / f"{NAME} out{suffix}"
        process = start_heatlens("render", plate, "-o", out, *LENS, env=environment)
        output, errors = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0, errors
        assert out.stat().st_size > 0
        assert output.endswith(f"a b \\xfc\\u65e5 out{suffix}\n")


def test_open_reads_file_name_that_is_not_utf8(tmp_path):
    path = tmp_path / os.fsdecode(b"caf\xe9.exr")
    plate = write_file(tmp_path / "plain.exr", rgb() | {"Z": distances()})
    plate.rename(path)
    lens = {"f_stop": 2, "focus_distance_m": 3, "focal_length_mm": 50, "sensor_width_mm": 36}
    assert np.isfinite(heatlens.open(path).render(**lens)).all()
