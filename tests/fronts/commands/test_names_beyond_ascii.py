"""Names beyond the terminal's letters: files open, and what cannot be printed is escaped."""

import os

import numpy as np
import pytest

import heatlens
from support.command_line import ENVIRONMENT, started
from support.exr_files import distances, rgb, write_file

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
def test_a_name_beyond_the_locale_is_read_written_and_printed(tmp_path, locale):
    plate = write_file(tmp_path / f"{NAME}.exr", rgb() | {"Z": distances()})
    environment = ENVIRONMENT | locale
    for suffix in (".exr", ".png"):
        out = tmp_path / f"{NAME} out{suffix}"
        process = started("render", plate, "-o", out, *LENS, env=environment)
        told, said = process.communicate(timeout=120)
        assert process.returncode == 0, said
        assert out.stat().st_size > 0
        assert told.endswith(f"a b \\xfc\\u65e5 out{suffix}\n")


def test_a_name_that_is_no_utf8_is_read(tmp_path):
    path = tmp_path / os.fsdecode(b"caf\xe9.exr")
    plate = write_file(tmp_path / "plain.exr", rgb() | {"Z": distances()})
    plate.rename(path)
    lens = {"f_stop": 2, "focus_distance_m": 3, "focal_length_mm": 50, "sensor_width_mm": 36}
    assert np.isfinite(heatlens.open(path).render(**lens)).all()
