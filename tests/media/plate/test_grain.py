"""Test grain of path tracers: noisy plates are reported, and single spikes are removed."""

import json
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import heatlens
from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import SPIKE_FROM, SPIKE_WHOLE, PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.media.plate import grain, inspection
from heatlens.media.plate.grain import _percentile, despike, measure_noise, noise_note
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.read import read_plate
from support.deep_files import write_deep
from support.exr_files import write_file
from support.plates import room, wires_and_lamps
from support.watched_calls import watch_calls

SIZE = (180, 120)


def add_grain(color, samples, rng):
    """Return an image of a path tracer: half of its light comes from rare bright paths."""
    shape = color.shape[:2]
    paths = 0.6 * rng.pareto(1.6, (samples, *shape)).mean(axis=0)  # a mean of 1, without variance
    return (color * (0.5 + 0.5 * paths)[..., None]).astype(np.float32)


def patterned_ground(width, height):
    """Return color and depth of a patterned ground up to 12 m away, without any lamp."""
    y, x = np.mgrid[:height, :width].astype(np.float32)
    tiles = (0.15 + 0.25 * ((x // 9 + y // 7) % 2) + 0.05 * np.sin(x / 5))[..., None]
    return tiles * np.float32([1.0, 0.8, 0.6]), np.float32(12.0) / (1.0 + y / 40)


def write_color_and_depth(path, color, depth):
    channels = {name: np.ascontiguousarray(color[..., k]) for k, name in enumerate("RGB")}
    return write_file(path, channels | {"Z": depth})


@pytest.fixture
def plate(tmp_path, rng):
    color, depth = patterned_ground(*SIZE)
    return write_color_and_depth(tmp_path / "grain.exr", add_grain(color, 24, rng), depth)


@pytest.mark.parametrize("samples", [24, 128])
@pytest.mark.parametrize("made", [patterned_ground, room, wires_and_lamps])
def test_noise_note_reports_grain_but_no_patterns(rng, made, samples):
    color = made(*SIZE)[0].astype(np.float32)
    assert noise_note(measure_noise(color), "p.exr") == ()
    assert "p.exr is noisy" in noise_note(measure_noise(add_grain(color, samples, rng)), "p.exr")[0]


def test_inspect_measures_noise_only_once(plate, monkeypatch):
    """Measuring the noise takes the most time of `inspect`."""
    of_plate = watch_calls(monkeypatch, grain, "measure_noise")
    of_inspection = watch_calls(monkeypatch, inspection, "measure_noise")
    facts = inspect(plate, PlateOptions())
    assert len([*of_plate, *of_inspection]) == 1
    assert facts["color"]["noise"] > 0.05 and any("is noisy" in it for it in facts["notes"])


@given(st.floats(0.02, 0.4), st.floats(1e-3, 1e3))
def test_measure_noise_is_close_to_standard_deviation_in_any_unit(sigma, level):
    """For uniform noise it is the deviation in the most even blocks, whatever the unit of light."""
    noise = np.random.default_rng(3).normal(1.0, sigma, (160, 160, 1))
    color = np.repeat(level * np.maximum(noise, 0.0), 3, axis=2).astype(np.float32)
    assert 0.6 * sigma < measure_noise(color) < 1.1 * sigma


def test_inspect_notes_noise_with_number_and_remedies(plate):
    facts = inspect(plate, PlateOptions())
    noise_note = next(note for note in facts["notes"] if "noisy" in note)
    assert f"{100 * facts['color']['noise']:.0f} %" in noise_note
    assert "Denoise it" in noise_note and "more samples" in noise_note and "--despike" in noise_note
    json.dumps(facts, allow_nan=False)


def test_measure_noise_of_small_picture_is_zero(rng):
    assert measure_noise(rng.random((20, 20, 4), np.float32)) == 0.0


@given(st.floats(0.0, 40.0), st.integers(0, 4), st.integers(0, 5))
def test_despike_reduces_spike_by_how_much_it_outshines_neighbors(ratio, y, x):
    """The spike may be anywhere, also at the border; no other pixel changes."""
    color = np.full((5, 6, 4), 0.3, np.float32)
    color[y, x, :3] *= np.float32(ratio)
    original = color.copy()
    count = despike(color, np.full((5, 6), 3.0, np.float32))
    share = min(max(ratio - SPIKE_FROM, 0.0) / (SPIKE_WHOLE - SPIKE_FROM), 1.0)
    expected = original[y, x, :3] + share * (0.3 - original[y, x, :3])
    np.testing.assert_allclose(color[y, x, :3], expected, rtol=1e-4, atol=1e-6)
    assert count == (np.float32(ratio) * np.float32(0.3) > SPIKE_FROM * np.float32(0.3))
    original[y, x, :3] = color[y, x, :3]
    assert np.array_equal(color, original)


@pytest.mark.parametrize(("own_m", "is_lamp_kept"), [(5.0, False), (4.0, True), (np.inf, True)])
def test_despike_keeps_lamp_with_its_own_depth(own_m, is_lamp_kept):
    color, depth = np.full((9, 9, 4), 0.1, np.float32), np.full((9, 9), 5.0, np.float32)
    color[4, 4], depth[4, 4] = 50.0, own_m
    assert despike(color, depth) == (0 if is_lamp_kept else 1)
    assert (color[4, 4, 0] == 50.0) == is_lamp_kept


@pytest.mark.parametrize("behind_m", [8.0, np.inf])
@pytest.mark.parametrize("wide", [1, 2, 3, 4])
def test_despike_keeps_lamp_on_thin_pole(wide, behind_m):
    """The pole is vertical or horizontal; a lamp on something wider is removed."""
    for column in range(6, 6 + wide):
        for is_horizontal in (False, True):
            color = np.full((16, 16, 4), 0.1, np.float32)
            depth = np.full((16, 16), behind_m, np.float32)
            depth[:, 6 : 6 + wide] = 5.0
            color[7, column] = 50.0
            if is_horizontal:
                color, depth = color.transpose(1, 0, 2).copy(), depth.T.copy()
            assert despike(color, depth) == (0 if wide <= 3 else 1)


def test_despike_removes_grain_on_slanted_floor():
    color = np.full((16, 16, 4), 0.1, np.float32)
    color[7, 7] = 50.0
    floor = np.repeat(np.linspace(20.0, 4.0, 16, dtype=np.float32)[:, None], 16, axis=1)
    assert despike(color, floor) == 1


def test_despike_removes_spike_in_the_sky():
    color = np.zeros((9, 9, 4), np.float32)
    color[4, 4, :3] = 2.0
    assert despike(color, np.full((9, 9), np.inf, np.float32)) == 1
    assert not color.any()


def test_despike_brings_blurred_ground_closer_to_clean_render(plate):
    """Blur spreads each spike into a disc; without spikes the image is close to the clean one."""
    color, depth = patterned_ground(*SIZE)
    lens = {"f_stop": 1.4, "focus_distance_m": 12.0, "focal_length_mm": 50, "sensor_width_mm": 36}
    clean = heatlens.open(np.ascontiguousarray(color), depth).render(**lens, lens_model="renderer")
    differences = []
    for is_despiked in (False, True):
        source = heatlens.open(plate, despike=is_despiked)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", heatlens.HeatlensWarning)
            picture = source.render(**lens, lens_model="renderer")
        assert any("far brighter" in note for note in source.notes) == is_despiked
        differences.append(np.abs(picture - clean))
    assert (differences[1] ** 2).mean() < 0.5 * (differences[0] ** 2).mean()
    assert differences[1].max() < 0.3 * differences[0].max()


def test_read_plate_notes_number_of_despiked_pixels(plate):
    plain_plate, despiked_plate = read_plate(plate), read_plate(plate, PlateOptions(despike=True))
    changed_count = np.count_nonzero((plain_plate.color != despiked_plate.color).any(axis=2))
    assert changed_count > 50
    assert (
        f"{changed_count} of {SIZE[0] * SIZE[1]} pixels were far brighter"
        in despiked_plate.notes[-1]
    )
    assert f"{changed_count} of" in inspect(plate, PlateOptions(despike=True))["notes"][-1]


def test_read_plate_rejects_despike_for_deep_file(tmp_path):
    path = write_deep(tmp_path / "deep.exr", [[(0.5, 1.0, 2.0)]], (1, 1))
    with pytest.raises(InputError, match="leave --despike out"):
        read_plate(path, PlateOptions(despike=True))


def test_despike_is_an_option_of_every_command_that_reads_plates(capsys):
    for command in ("render", "export", "view", "info"):
        with pytest.raises(SystemExit) as exit_info:
            main([command, "--help-all"])
        assert exit_info.value.code == 0 and "--despike" in capsys.readouterr().out


def test_percentile_matches_numpy(rng):
    for count in (1, 2, 7, 64):
        values = rng.normal(size=(3, count))
        for percent in (0, 5, 50, 100):
            expected = np.percentile(values, percent, axis=1)
            np.testing.assert_allclose(_percentile(values, percent), expected, rtol=1e-12)
