"""Distances or 1/z: read off the flat surfaces, and asked where these say nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.sequence_reader import SequenceReader
from heatlens.media.plate.depth.depth_shape import flat_votes
from heatlens.media.plate.header.entries import rendered_by, written_by
from heatlens.media.plate.read import read_plate
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file
from support.plates import room

HEIGHT, WIDTH = 135, 240
NUKE = {"nuke/version": "15.1v3"}


def corner(floor_m=1.2, wall_m=6.0, side=0.4):
    """Return distances (H, W) of a floor and two walls that meet at an angle, through a pinhole."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    u, v = (x - WIDTH / 2) / WIDTH, (y - HEIGHT / 2) / WIDTH
    floor = np.divide(floor_m, v, out=np.full_like(v, np.inf), where=v > 1e-6)
    walls = [wall_m / (1 + tilt * u) for tilt in (side, -2 * side)]
    return np.minimum.reduce([floor, *walls])


def spheres():
    """Return distances (H, W) of two balls, seen through a pinhole; nothing flat."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    u, v = (x - WIDTH / 2) / WIDTH, (y - HEIGHT / 2) / WIDTH
    depth = np.full((HEIGHT, WIDTH), np.inf)
    for cx, cz, radius in ((-0.6, 2.0, 1.5), (1.5, 8.0, 3.0)):
        a, b = u * u + v * v + 1, u * cx + cz
        under = b * b - a * (cx * cx + cz * cz - radius * radius)
        hit = under > 0
        depth[hit] = np.minimum(depth, (b - np.sqrt(np.maximum(under, 0))) / a)[hit]
    return depth


def votes(values):
    values = np.asarray(values, np.float32)
    return flat_votes(values, ~np.isfinite(values))


def inverse(depth_m):
    return np.where(np.isfinite(depth_m), 1 / depth_m, 0.0)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.3, 4.0), st.floats(2.0, 30.0), st.floats(0.2, 0.8))
def test_planes_say_which_of_the_two_a_channel_is(floor_m, wall_m, side):
    depth = corner(floor_m, wall_m, side)
    found = votes(depth)
    assert found.says_distance and not found.says_inverse
    found = votes(inverse(depth))
    assert found.says_inverse and not found.says_distance
    # Of gentle slopes 16 bits have too few steps to tell, and then nothing is said.
    assert not votes(depth.astype(np.float16)).says_inverse
    assert not votes(inverse(depth).astype(np.float16)).says_distance


def test_16_bits_are_enough_for_a_floor():
    depth = corner(floor_m=0.2)
    assert votes(depth.astype(np.float16)).says_distance
    assert votes(inverse(depth).astype(np.float16)).says_inverse


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 999), st.floats(0.05, 0.5))
def test_what_has_no_planes_says_nothing(seed, amount):
    waves = np.random.default_rng(seed).uniform(-1, 1, (4, 5))
    y, x = np.mgrid[:HEIGHT, :WIDTH] / WIDTH
    heights = sum(a * np.sin(9 * b * x + 9 * c * y + 6 * d + e) for a, b, c, d, e in waves)
    for values in (3 + amount * heights, 3 * np.exp(amount * heights)):
        found = votes(values)
        assert not (found.says_distance and found.says_inverse)
    assert not votes(spheres()).says_inverse and not votes(inverse(spheres())).says_distance


def test_one_ramp_over_the_picture_says_nothing():
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    for values in (1 + 0.02 * y, 4 - 0.01 * x, 1 + 0.01 * x + 0.02 * y):
        assert votes(values).looked_at == 0


def test_small_even_and_empty_channels_say_nothing():
    for values in (np.ones((1, 1)), np.full((60, 60), 4.0), np.zeros((60, 60)), np.ones((9, 2))):
        assert not votes(values).says_distance and not votes(values).says_inverse


def plate_file(path, depth, name="depth.Z", **attributes):
    values = depth.astype(np.float32)
    return write_file(path, rgb(HEIGHT, WIDTH) | {name: values}, **attributes)


def test_1_over_z_of_nuke_with_something_near_is_read_as_such(tmp_path):
    depth = corner(floor_m=0.2)  # 1/z up to 1.4: above 1, which alone would mean distances
    plate = read_plate(plate_file(tmp_path / "n.exr", inverse(depth), **NUKE))
    assert plate.depth.convention == "inverse" and not plate.depth.question
    np.testing.assert_allclose(plate.depth_m, depth, rtol=1e-5)
    assert any("flat surfaces" in note for note in plate.notes)
    through = read_plate(plate_file(tmp_path / "z.exr", depth, **NUKE))  # a render passed on
    assert through.depth.convention == "distance"
    np.testing.assert_allclose(through.depth_m, depth, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "values", "attributes", "taken"),
    [
        ("depth.Z", inverse(spheres()), NUKE, "inverse"),  # nothing flat tells
        ("Z", inverse(corner(floor_m=0.2)), {}, "inverse"),  # no program tells
        ("Z", np.linspace(0.3, 1.0, HEIGHT * WIDTH) ** 8 * 1.3, {}, "distance"),  # dense near 0
    ],
)
def test_what_fits_both_is_asked_aloud_and_refused_when_strict(
    tmp_path, name, values, attributes, taken
):
    values = np.where(values > 0, values, 0.011).reshape(HEIGHT, WIDTH)
    path = plate_file(tmp_path / "q.exr", values, name, **attributes)
    plate = read_plate(path)
    assert plate.depth.convention == taken
    assert "distances, or 1/z?" in plate.depth.question
    for option in ("--depth-convention distance", "--depth-convention inverse"):
        assert option in plate.depth.question
        assert any(option in note for note in plate.notes)
    with pytest.raises(InputError, match=r"distances, or 1/z\?"):
        read_plate(path, PlateOptions(strict=True))
    for convention in ("distance", "inverse"):  # an answer ends the question
        options = PlateOptions(depth_convention=convention, strict=True)
        assert not read_plate(path, options).depth.question


def test_the_command_asks_and_strict_refuses(tmp_path, capsys):
    path = plate_file(tmp_path / "q.exr", inverse(spheres()) + 0.011, **NUKE)
    words = ["render", path, "-o", tmp_path / "o.exr", "--f-stop", 2, "--focus-distance", 2]
    words += ["--focal-length", 50, "--quality", "draft"]
    assert "distances, or 1/z?" in stderr_of_run(capsys, 0, *words)
    refused = stderr_of_run(capsys, 2, *words, "--strict")
    assert "distances, or 1/z?" in refused and "Taken as" not in refused


def test_a_sequence_is_read_as_its_first_frame_was(tmp_path):
    flat, empty = inverse(corner(floor_m=0.2)), np.full((HEIGHT, WIDTH), 1.5)
    first = plate_file(tmp_path / "s.1.exr", flat, **NUKE)
    second = plate_file(tmp_path / "s.2.exr", empty, **NUKE)
    reader = SequenceReader(PlateOptions())
    assert reader(first).depth.convention == "inverse"
    assert reader(second).depth.convention == "inverse"
    deciding = SequenceReader(PlateOptions(), first)  # whichever frame is asked for
    assert deciding(second).depth_m[0, 0] == pytest.approx(1 / 1.5)


def test_a_first_frame_that_cannot_be_read_leaves_the_decision_to_the_next(tmp_path):
    _, depth = room(WIDTH, HEIGHT)
    second = plate_file(tmp_path / "s.2.exr", depth)
    (tmp_path / "s.1.exr").write_bytes(b"no picture")
    reader = SequenceReader(PlateOptions(), tmp_path / "s.1.exr")
    assert reader(second).depth.convention == "distance"
    with pytest.raises(InputError):
        reader(tmp_path / "s.1.exr")


@pytest.mark.parametrize(
    ("header", "program"),
    [
        ({"nuke/input/filename": "x", "arnold/version": "7"}, "Nuke"),
        ({"cycles.ViewLayer.samples": "64"}, "Blender"),
        ({"Software": "Blender 5.0.1"}, "Blender"),
        ({"generatedBy": "Mitsuba version 3.9.1"}, "Mitsuba"),
        ({"renderTimeSeconds": 3.5, "samplesPerPixel": 16}, "pbrt"),
        ({"Software": 7, "owner": "nuke"}, ""),
    ],
)
def test_programs_are_known_by_their_headers(header, program):
    assert written_by([{}, header]) == program


@pytest.mark.parametrize(
    ("headers", "renderer"),
    [
        ([{"nuke/input/filename": "x"}, {"arnold/version": "7"}], "Arnold"),
        ([{"nuke/version": "15"}], ""),
        ([{"owner": "arnold", "cameraModel": "ALEXA 35"}], ""),
        ([{"vrayInfo/vrayversion": "6"}], "V-Ray"),
    ],
)
def test_a_renderer_is_known_behind_a_compositing_program(headers, renderer):
    assert rendered_by(headers) == renderer


@pytest.mark.parametrize("scale", [8.0, 300.0])
def test_raw_disparity_in_an_exr_is_a_question(tmp_path, scale):
    """A network writes 1/z in a scale of its own, with an offset: every value is above 1."""
    grey = dict.fromkeys("RGB", np.full((HEIGHT, WIDTH), 0.2, np.float32))
    disparity = (scale * inverse(corner()) + 2.0).astype(np.float32)
    path = write_file(tmp_path / "d.exr", grey | {"Z": disparity})
    report = read_plate(path).depth
    assert report.convention == "distance" and "disparity" in report.question
    with pytest.raises(InputError, match="disparity"):
        read_plate(path, PlateOptions(strict=True))
    far = write_file(tmp_path / "m.exr", grey | {"Z": np.float32(corner(9, 40))})
    assert not read_plate(far).depth.question
