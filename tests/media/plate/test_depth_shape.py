"""Test how distances and 1/z are told apart by flat surfaces, and the question where they tell
nothing.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.sequence_reader import SequenceReader
from heatlens.media.plate.depth.depth_shape import count_flat_votes
from heatlens.media.plate.header.entries import rendering_program, writing_program
from heatlens.media.plate.read import read_plate
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file
from support.plates import room

HEIGHT, WIDTH = 135, 240
NUKE = {"nuke/version": "15.1v3"}


def corner_depth(floor_m=1.2, wall_m=6.0, side=0.4):
    """Return distances (H, W) of a floor and two walls that meet at an angle, through a pinhole."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    u, v = (x - WIDTH / 2) / WIDTH, (y - HEIGHT / 2) / WIDTH
    floor = np.divide(floor_m, v, out=np.full_like(v, np.inf), where=v > 1e-6)
    walls = [wall_m / (1 + tilt * u) for tilt in (side, -2 * side)]
    return np.minimum.reduce([floor, *walls])


def spheres_depth():
    """Return distances (H, W) of two spheres seen through a pinhole; no surface is flat."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    u, v = (x - WIDTH / 2) / WIDTH, (y - HEIGHT / 2) / WIDTH
    depth = np.full((HEIGHT, WIDTH), np.inf)
    for cx, cz, radius in ((-0.6, 2.0, 1.5), (1.5, 8.0, 3.0)):
        a, b = u * u + v * v + 1, u * cx + cz
        under = b * b - a * (cx * cx + cz * cz - radius * radius)
        hit = under > 0
        depth[hit] = np.minimum(depth, (b - np.sqrt(np.maximum(under, 0))) / a)[hit]
    return depth


def flat_votes_of(values):
    values = np.asarray(values, np.float32)
    return count_flat_votes(values, ~np.isfinite(values))


def inverse(depth_m):
    return np.where(np.isfinite(depth_m), 1 / depth_m, 0.0)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.3, 4.0), st.floats(2.0, 30.0), st.floats(0.2, 0.8))
def test_flat_votes_of_planes_identify_distance_or_inverse(floor_m, wall_m, side):
    depth = corner_depth(floor_m, wall_m, side)
    votes_found = flat_votes_of(depth)
    assert votes_found.says_distance and not votes_found.says_inverse
    votes_found = flat_votes_of(inverse(depth))
    assert votes_found.says_inverse and not votes_found.says_distance
    # Of gentle slopes 16 bits have too few steps to tell, and then nothing is said.
    assert not flat_votes_of(depth.astype(np.float16)).says_inverse
    assert not flat_votes_of(inverse(depth).astype(np.float16)).says_distance


def test_flat_votes_of_floor_work_with_16_bits():
    depth = corner_depth(floor_m=0.2)
    assert flat_votes_of(depth.astype(np.float16)).says_distance
    assert flat_votes_of(inverse(depth).astype(np.float16)).says_inverse


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 999), st.floats(0.05, 0.5))
def test_flat_votes_without_planes_identify_nothing(seed, amount):
    waves = np.random.default_rng(seed).uniform(-1, 1, (4, 5))
    y, x = np.mgrid[:HEIGHT, :WIDTH] / WIDTH
    heights = sum(a * np.sin(9 * b * x + 9 * c * y + 6 * d + e) for a, b, c, d, e in waves)
    for values in (3 + amount * heights, 3 * np.exp(amount * heights)):
        votes_found = flat_votes_of(values)
        assert not (votes_found.says_distance and votes_found.says_inverse)
    assert (
        not flat_votes_of(spheres_depth()).says_inverse
        and not flat_votes_of(inverse(spheres_depth())).says_distance
    )


def test_flat_votes_of_single_ramp_identify_nothing():
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    for values in (1 + 0.02 * y, 4 - 0.01 * x, 1 + 0.01 * x + 0.02 * y):
        assert flat_votes_of(values).examined == 0


def test_flat_votes_of_small_constant_or_empty_channel_identify_nothing():
    for values in (np.ones((1, 1)), np.full((60, 60), 4.0), np.zeros((60, 60)), np.ones((9, 2))):
        assert not flat_votes_of(values).says_distance and not flat_votes_of(values).says_inverse


def write_depth_plate(path, depth, name="depth.Z", **attributes):
    values = depth.astype(np.float32)
    return write_file(path, rgb(HEIGHT, WIDTH) | {name: values}, **attributes)


def test_read_plate_identifies_inverse_depth_of_nuke_by_planes(tmp_path):
    depth = corner_depth(floor_m=0.2)  # 1/z up to 1.4: above 1, which alone would mean distances
    plate = read_plate(write_depth_plate(tmp_path / "n.exr", inverse(depth), **NUKE))
    assert plate.depth.convention == "inverse" and not plate.depth.question
    np.testing.assert_allclose(plate.depth_m, depth, rtol=1e-5)
    assert "flat surfaces" in plate.depth.why
    distance_plate = read_plate(
        write_depth_plate(tmp_path / "z.exr", depth, **NUKE)
    )  # a render passed on
    assert distance_plate.depth.convention == "distance"
    np.testing.assert_allclose(distance_plate.depth_m, depth, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "values", "attributes", "taken"),
    [
        ("depth.Z", inverse(spheres_depth()), NUKE, "inverse"),  # nothing flat tells
        ("Z", inverse(corner_depth(floor_m=0.2)), {}, "inverse"),  # no program tells
        ("Z", np.linspace(0.3, 1.0, HEIGHT * WIDTH) ** 8 * 1.3, {}, "distance"),  # dense near 0
    ],
)
def test_read_plate_asks_about_ambiguous_depth_and_strict_rejects_it(
    tmp_path, name, values, attributes, taken
):
    values = np.where(values > 0, values, 0.011).reshape(HEIGHT, WIDTH)
    path = write_depth_plate(tmp_path / "q.exr", values, name, **attributes)
    plate = read_plate(path)
    assert plate.depth.convention == taken
    assert "distances, or 1/z?" in plate.depth.question
    for option in ("--depth-convention distance", "--depth-convention inverse"):
        assert option in plate.depth.question
    other = "distance" if taken == "inverse" else "inverse"
    advice = f"If the wrong things are sharp: --depth-convention {other}."
    assert any(note.endswith(advice) for note in plate.notes)
    with pytest.raises(InputError, match=r"distances, or 1/z\?"):
        read_plate(path, PlateOptions(strict=True))
    for convention in ("distance", "inverse"):  # an answer ends the question
        options = PlateOptions(depth_convention=convention, strict=True)
        assert not read_plate(path, options).depth.question


def test_render_asks_about_ambiguous_depth_and_strict_rejects_it(tmp_path, capsys):
    path = write_depth_plate(tmp_path / "q.exr", inverse(spheres_depth()) + 0.011, **NUKE)
    words = ["render", path, "-o", tmp_path / "o.exr", "--f-stop", 2, "--focus-distance", 2]
    words += ["--focal-length", 50, "--quality", "draft"]
    assert "sharp: --depth-convention distance" in stderr_of_run(capsys, 0, *words)
    assert "distances, or 1/z?" in stderr_of_run(capsys, 0, *words, "--verbose")
    stderr = stderr_of_run(capsys, 2, *words, "--strict")
    assert "distances, or 1/z?" in stderr and "taken as" not in stderr


def test_sequence_reader_uses_convention_of_first_frame(tmp_path):
    flat, empty = inverse(corner_depth(floor_m=0.2)), np.full((HEIGHT, WIDTH), 1.5)
    first = write_depth_plate(tmp_path / "s.1.exr", flat, **NUKE)
    second = write_depth_plate(tmp_path / "s.2.exr", empty, **NUKE)
    reader = SequenceReader(PlateOptions())
    assert reader(first).depth.convention == "inverse"
    assert reader(second).depth.convention == "inverse"
    reader_with_first = SequenceReader(PlateOptions(), first)  # whichever frame is asked for
    assert reader_with_first(second).depth_m[0, 0] == pytest.approx(1 / 1.5)


def test_later_frames_give_the_reason_of_the_guess_not_that_it_was_given(tmp_path):
    """Only a convention that the user gave is called given."""
    _, depth = room(WIDTH, HEIGHT)
    paths = [write_depth_plate(tmp_path / f"s.{i}.exr", depth + 0.1 * i) for i in (1, 2)]
    reader = SequenceReader(PlateOptions())
    first, second = (reader(path).depth.why for path in paths)
    assert first == second and "--depth-convention" not in first
    given_reader = SequenceReader(PlateOptions(depth_convention="distance"))
    assert all("--depth-convention" in given_reader(path).depth.why for path in paths)


def test_sequence_reader_decides_by_next_frame_if_first_is_unreadable(tmp_path):
    _, depth = room(WIDTH, HEIGHT)
    second = write_depth_plate(tmp_path / "s.2.exr", depth)
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
def test_writing_program_is_recognized_by_header(header, program):
    assert writing_program([{}, header]) == program


@pytest.mark.parametrize(
    ("headers", "renderer"),
    [
        ([{"nuke/input/filename": "x"}, {"arnold/version": "7"}], "Arnold"),
        ([{"nuke/version": "15"}], ""),
        ([{"owner": "arnold", "cameraModel": "ALEXA 35"}], ""),
        ([{"vrayInfo/vrayversion": "6"}], "V-Ray"),
    ],
)
def test_rendering_program_finds_renderer_behind_compositing_program(headers, renderer):
    assert rendering_program(headers) == renderer


@pytest.mark.parametrize("scale", [8.0, 300.0])
def test_read_plate_asks_about_raw_disparity_in_exr(tmp_path, scale):
    """A network writes 1/z with its own scale and an offset, so every value is above 1."""
    grey = dict.fromkeys("RGB", np.full((HEIGHT, WIDTH), 0.2, np.float32))
    disparity = (scale * inverse(corner_depth()) + 2.0).astype(np.float32)
    path = write_file(tmp_path / "d.exr", grey | {"Z": disparity})
    report = read_plate(path).depth
    assert report.convention == "distance" and "disparity" in report.question
    with pytest.raises(InputError, match="disparity"):
        read_plate(path, PlateOptions(strict=True))
    far = write_file(tmp_path / "m.exr", grey | {"Z": np.float32(corner_depth(9, 40))})
    assert not read_plate(far).depth.question
