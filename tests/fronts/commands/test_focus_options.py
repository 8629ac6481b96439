"""Test `--focus-at` and `--focus-distance` with all kinds of typed values."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.units import FOOT_M, INCH_M
from heatlens.fronts.commands.main import main
from heatlens.media.plate.header.camera_header import camera_at_header
from support.command_line import (
    CAMERA,
    HEIGHT,
    WIDTH,
    channels,
    depths,
    folder_of,
    picture,
    refused_render_message,
    render,
)
from support.exr_files import window, write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


def focus_in_message(message: str) -> str:
    """Return the focus of a message, as `2.24 m` of "lens: ..., focus 2.24 m"."""
    return message.rpartition(", focus ")[2].splitlines()[0]


def test_focus_at_focuses_on_depth_of_pixel(capsys, plate, tmp_path):
    message = render(capsys, plate, tmp_path / "out.exr", "--focus-at", "7,5")
    assert focus_in_message(message) == "8 m"


def test_focus_at_on_sky_focuses_at_infinity(capsys, tmp_path):
    sky = channels() | {"Z": np.where(np.arange(HEIGHT)[:, None] < 6, np.inf, depths())}
    plate = write_file(tmp_path / "p.exr", sky, **CAMERA)
    assert focus_in_message(render(capsys, plate, tmp_path / "o.exr", "--focus-at", "3,1")) == "inf"


def test_focus_at_counts_pixels_from_display_window(capsys, tmp_path):
    """Display x = 7 is x = 17 of the file, the data window's pixel 5, where the depth is 6 m."""
    windows = {"dataWindow": window(12, 20, 28, 30), "displayWindow": window(10, 20, 40, 40)}
    plate = write_file(tmp_path / "p.exr", channels(), **windows, **CAMERA)
    assert focus_in_message(render(capsys, plate, tmp_path / "o.exr", "--focus-at", "7,5")) == "6 m"
    message = refused_render_message(capsys, plate, tmp_path / "no.exr", "--focus-at", "1,5")
    assert "2,0 to 17,9" in message


@pytest.mark.parametrize("pixel", ["16,3", "3,10", "=-1,3", "=3,-1", "99999999999999999999,3"])
def test_focus_at_rejects_pixel_outside_picture(capsys, plate, tmp_path, pixel):
    words = [f"--focus-at{pixel}"] if pixel.startswith("=") else ["--focus-at", pixel]
    message = refused_render_message(capsys, plate, tmp_path / "out.exr", *words)
    assert "outside the picture" in message and "0,0 to 15,9" in message


@pytest.mark.parametrize("pixel", ["", "3", "3,", ",3", "3,4,5", "3;4", "3.5,4", "x,y", "nan,1"])
def test_focus_at_rejects_text_that_is_no_pixel(capsys, plate, tmp_path, pixel):
    assert "X,Y" in refused_render_message(
        capsys, plate, tmp_path / "out.exr", f"--focus-at={pixel}"
    )


@pytest.mark.parametrize(
    ("distance", "metres"),
    [
        ("2.24", 2.24),
        ("190cm", 1.9),
        ("1900 mm", 1.9),
        ("6'3\"", 6 * FOOT_M + 3 * INCH_M),
        ("75in", 75 * INCH_M),
        ("0.5km", 500.0),
        ("inf", math.inf),
    ],
)
def test_focus_distance_reads_units(capsys, plate, tmp_path, distance, metres):
    render(capsys, plate, tmp_path / "out.exr", "--focus-distance", distance)
    camera = camera_at_header([picture(tmp_path / "out.exr")[0]])
    assert camera.focus_distance_m == pytest.approx(metres, rel=1e-6)


WORDS = st.text(alphabet=st.characters(codec="utf-8", exclude_characters="\0"), max_size=20)
PIXELS = st.tuples(st.integers(-5, 20), st.integers(-5, 20)).map(lambda at: f"{at[0]},{at[1]}")
NUMBERS = st.floats().map(str) | st.integers().map(str)
UNITS = st.sampled_from(["", "m", "cm", "'", '"', " ft", "parsec"])
DISTANCES = st.tuples(NUMBERS, UNITS).map("".join)


@pytest.fixture(scope="module")
def open_plate(tmp_path_factory):
    return write_file(tmp_path_factory.mktemp("open") / "plate.exr", channels(), **CAMERA)


def exit_code_of_render(option: str, plate) -> int:
    """Render with an option. Return the exit code; check that only code 0 leaves a picture."""
    out = plate.with_name("out.exr")
    code = main(["render", str(plate), "-o", str(out), "--quality=draft", option])
    assert set(folder_of(out)) == {"plate.exr"} | ({"out.exr"} if code == 0 else set())
    out.unlink(missing_ok=True)
    return code


@settings(max_examples=50, deadline=None)
@given(pixel=PIXELS)
def test_focus_at_accepts_exactly_the_pixels_of_the_picture(open_plate, pixel):
    inside = {f"{x},{y}" for x in range(WIDTH) for y in range(HEIGHT)}
    assert exit_code_of_render(f"--focus-at={pixel}", open_plate) == (0 if pixel in inside else 2)


@settings(max_examples=50, deadline=None)
@given(metres=st.floats(0.0, 1e9))
def test_focus_distance_accepts_exactly_distances_beyond_focal_length(open_plate, metres):
    assert exit_code_of_render(f"--focus-distance={metres!r}", open_plate) == (
        0 if 1e3 * metres > 50 else 2
    )


@settings(max_examples=80, deadline=None)
@given(option=st.sampled_from(["--focus-at", "--focus-distance"]), words=WORDS | DISTANCES)
def test_focus_options_with_any_text_give_picture_or_refusal(open_plate, option, words):
    assert exit_code_of_render(f"{option}={words}", open_plate) in (0, 2)
