"""Grain of path tracers: noisy plates are told, and lone spikes taken out of them."""

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
from heatlens.media.plate.grain import _percentile, despike, noise_doubt, noise_of
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.read import read_plate
from support.deep_files import write_deep
from support.exr_files import write_file
from support.plates import room, wires_and_lamps

SIZE = (180, 120)


def grainy(color, samples, rng):
    """Return a picture as a path tracer leaves it: half of the light comes on rare bright paths."""
    shape = color.shape[:2]
    paths = 0.6 * rng.pareto(1.6, (samples, *shape)).mean(axis=0)  # a mean of 1, without variance
    return (color * (0.5 + 0.5 * paths)[..., None]).astype(np.float32)


def ground(width, height):
    """Return colour and depth of a ground with a pattern, out to 12 m, without any lamp."""
    y, x = np.mgrid[:height, :width].astype(np.float32)
    tiles = (0.15 + 0.25 * ((x // 9 + y // 7) % 2) + 0.05 * np.sin(x / 5))[..., None]
    return tiles * np.float32([1.0, 0.8, 0.6]), np.float32(12.0) / (1.0 + y / 40)


def saved(path, color, depth):
    channels = {name: np.ascontiguousarray(color[..., k]) for k, name in enumerate("RGB")}
    return write_file(path, channels | {"Z": depth})


@pytest.fixture
def plate(tmp_path, rng):
    color, depth = ground(*SIZE)
    return saved(tmp_path / "grain.exr", grainy(color, 24, rng), depth)


@pytest.mark.parametrize("samples", [24, 128])
@pytest.mark.parametrize("made", [ground, room, wires_and_lamps])
def test_noise_is_doubted_and_patterns_are_not(rng, made, samples):
    color = made(*SIZE)[0].astype(np.float32)
    assert noise_doubt(noise_of(color), "p.exr") == ()
    assert "p.exr is noisy" in noise_doubt(noise_of(grainy(color, samples, rng)), "p.exr")[0]


def test_facts_of_a_plate_measure_its_noise_once(plate, monkeypatch):
    """It is the longest of their work."""
    measured = []

    def counted(color):
        measured.append(color.shape)
        return noise_of(color)

    monkeypatch.setattr("heatlens.media.plate.grain.noise_of", counted)
    monkeypatch.setattr("heatlens.media.plate.inspection.noise_of", counted)
    facts = inspect(plate, PlateOptions())
    assert len(measured) == 1
    assert facts["color"]["noise"] > 0.05 and any("is noisy" in it for it in facts["notes"])


@given(st.floats(0.02, 0.4), st.floats(1e-3, 1e3))
def test_the_number_is_that_of_the_noise(sigma, level):
    """Of even noise it is the deviation in the evenest blocks, whatever the unit of light."""
    noise = np.random.default_rng(3).normal(1.0, sigma, (160, 160, 1))
    color = np.repeat(level * np.maximum(noise, 0.0), 3, axis=2).astype(np.float32)
    assert 0.6 * sigma < noise_of(color) < 1.1 * sigma


def test_info_tells_it_with_a_number_and_what_helps(plate):
    facts = inspect(plate, PlateOptions())
    told = next(note for note in facts["notes"] if "noisy" in note)
    assert f"{100 * facts['color']['noise']:.0f} %" in told
    assert "Denoise it" in told and "more samples" in told and "--despike" in told
    json.dumps(facts, allow_nan=False)


def test_a_small_picture_tells_nothing(rng):
    assert noise_of(rng.random((20, 20, 4), np.float32)) == 0.0


@given(st.floats(0.0, 40.0), st.integers(0, 4), st.integers(0, 5))
def test_a_spike_goes_by_as_much_as_it_outshines_its_neighbours(ratio, y, x):
    """Wherever it stands, also at the border, and by no more than the rest of the picture is."""
    color = np.full((5, 6, 4), 0.3, np.float32)
    color[y, x, :3] *= np.float32(ratio)
    before = color.copy()
    count = despike(color, np.full((5, 6), 3.0, np.float32))
    part = min(max(ratio - SPIKE_FROM, 0.0) / (SPIKE_WHOLE - SPIKE_FROM), 1.0)
    expected = before[y, x, :3] + part * (0.3 - before[y, x, :3])
    np.testing.assert_allclose(color[y, x, :3], expected, rtol=1e-4, atol=1e-6)
    assert count == (np.float32(ratio) * np.float32(0.3) > SPIKE_FROM * np.float32(0.3))
    before[y, x, :3] = color[y, x, :3]
    assert np.array_equal(color, before)


@pytest.mark.parametrize(("own_m", "kept"), [(5.0, False), (4.0, True), (np.inf, True)])
def test_a_lamp_with_a_depth_of_its_own_stays(own_m, kept):
    color, depth = np.full((9, 9, 4), 0.1, np.float32), np.full((9, 9), 5.0, np.float32)
    color[4, 4], depth[4, 4] = 50.0, own_m
    assert despike(color, depth) == (0 if kept else 1)
    assert (color[4, 4, 0] == 50.0) == kept


@pytest.mark.parametrize("behind_m", [8.0, np.inf])
@pytest.mark.parametrize("wide", [1, 2, 3, 4])
def test_a_lamp_on_a_pole_stays(wide, behind_m):
    """Wherever it stands on the pole, upright or lying; one on something wider is taken out."""
    for column in range(6, 6 + wide):
        for turned in (False, True):
            color = np.full((16, 16, 4), 0.1, np.float32)
            depth = np.full((16, 16), behind_m, np.float32)
            depth[:, 6 : 6 + wide] = 5.0
            color[7, column] = 50.0
            if turned:
                color, depth = color.transpose(1, 0, 2).copy(), depth.T.copy()
            assert despike(color, depth) == (0 if wide <= 3 else 1)


def test_a_grain_on_a_slanted_floor_is_no_lamp():
    color = np.full((16, 16, 4), 0.1, np.float32)
    color[7, 7] = 50.0
    floor = np.repeat(np.linspace(20.0, 4.0, 16, dtype=np.float32)[:, None], 16, axis=1)
    assert despike(color, floor) == 1


def test_stars_are_of_the_sky():
    color = np.zeros((9, 9, 4), np.float32)
    color[4, 4, :3] = 2.0
    assert despike(color, np.full((9, 9), np.inf, np.float32)) == 1
    assert not color.any()


def test_out_of_focus_ground_is_nearer_to_the_clean_one(plate):
    """Blur spreads each spike into a disc; without them the picture is that of the clean plate."""
    color, depth = ground(*SIZE)
    lens = {"f_stop": 1.4, "focus_distance_m": 12.0, "focal_length_mm": 50, "sensor_width_mm": 36}
    clean = heatlens.open(np.ascontiguousarray(color), depth).render(**lens, lens_model="renderer")
    off = []
    for asked in (False, True):
        source = heatlens.open(plate, despike=asked)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", heatlens.HeatlensWarning)
            picture = source.render(**lens, lens_model="renderer")
        assert any("far brighter" in note for note in source.notes) == asked
        off.append(np.abs(picture - clean))
    assert (off[1] ** 2).mean() < 0.5 * (off[0] ** 2).mean()
    assert off[1].max() < 0.3 * off[0].max()


def test_the_reader_says_how_many_pixels_it_changed(plate):
    before, after = read_plate(plate), read_plate(plate, PlateOptions(despike=True))
    changed = np.count_nonzero((before.color != after.color).any(axis=2))
    assert changed > 50
    assert f"{changed} of {SIZE[0] * SIZE[1]} pixels were far brighter" in after.notes[-1]
    assert f"{changed} of" in inspect(plate, PlateOptions(despike=True))["notes"][-1]


def test_deep_samples_are_left_as_they_are(tmp_path):
    path = write_deep(tmp_path / "deep.exr", [[(0.5, 1.0, 2.0)]], (1, 1))
    with pytest.raises(InputError, match="leave --despike out"):
        read_plate(path, PlateOptions(despike=True))


def test_it_is_an_option_of_every_command_that_reads_plates(capsys):
    for command in ("render", "export", "view", "info"):
        with pytest.raises(SystemExit) as ended:
            main([command, "--help"])
        assert ended.value.code == 0 and "--despike" in capsys.readouterr().out


def test_a_percentile_is_that_of_numpy(rng):
    for count in (1, 2, 7, 64):
        values = rng.normal(size=(3, count))
        for percent in (0, 5, 50, 100):
            expected = np.percentile(values, percent, axis=1)
            np.testing.assert_allclose(_percentile(values, percent), expected, rtol=1e-12)
