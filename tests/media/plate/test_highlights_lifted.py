"""Test lifting of clipped highlights: unchanged below, exact at white, smooth in between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import LIFT_STOPS_MOST, PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.picture.highlights import lift_highlights
from heatlens.media.plate.read import read_plate
from support.exr_files import write_file

STOPS = st.floats(0.0, LIFT_STOPS_MOST)
LIGHT = st.lists(st.floats(0.0, 1.0, width=32), min_size=3, max_size=3)


def gray_image(values) -> np.ndarray:
    return np.repeat(np.asarray(values, np.float32)[:, None, None], 3, axis=2)


@given(st.floats(0.0, 0.875, width=32), STOPS)
def test_lift_highlights_keeps_light_below_shoulder(light, stops):
    np.testing.assert_array_equal(lift_highlights(gray_image([light]), stops), gray_image([light]))


@given(STOPS)
def test_lift_highlights_raises_white_by_given_stops(stops):
    np.testing.assert_allclose(lift_highlights(gray_image([1.0]), stops), 2.0**stops, rtol=1e-5)


@given(STOPS)
def test_lift_highlights_is_monotone_and_smooth(stops):
    lifted_values = lift_highlights(gray_image(np.linspace(0.8, 1.0, 4001)), stops)[:, 0, 0].astype(
        np.float64
    )
    steps = np.diff(lifted_values)
    assert (steps > 0).all()
    assert steps[2000] / steps[0] == pytest.approx(1.0, abs=0.12)  # no corner at LIFT_FROM
    assert np.abs(np.diff(np.log(lifted_values), 2)).max() < 1e-4


@given(LIGHT, st.floats(0, 1, width=32), STOPS)
def test_lift_highlights_keeps_hue_and_alpha(rgb, alpha, stops):
    color = np.array([[[*rgb, alpha]]], np.float32)
    lifted_image = lift_highlights(color, stops)
    assert lifted_image[0, 0, 3] == color[0, 0, 3]
    np.testing.assert_allclose(
        lifted_image[0, 0, :3] * max(rgb),
        np.array(rgb) * lifted_image[0, 0, :3].max(),
        rtol=1e-4,
        atol=1e-6,
    )


@pytest.fixture
def photo(tmp_path):
    """Write a grey photograph with a white lamp, and its depth."""
    pixels = np.full((24, 32, 3), 120, np.uint8)
    pixels[10:13, 20:23] = 255
    Image.fromarray(pixels).save(tmp_path / "photo.png")
    Image.fromarray(np.full((24, 32), 4000, np.uint16)).save(tmp_path / "depth.png")
    return tmp_path / "photo.png"


def test_read_plate_lifts_clipped_lamps_of_photo(photo):
    depth = {"depth_source": str(photo.with_name("depth.png")), "scene_unit_m": 0.001}
    plain = read_plate(photo, PlateOptions(**depth)).color
    lifted_color = read_plate(photo, PlateOptions(**depth, lift_highlights_stops=3)).color
    is_lamp = plain[..., 0] == 1.0
    assert is_lamp.sum() == 9
    np.testing.assert_allclose(lifted_color[is_lamp][:, :3], 8.0, rtol=1e-4)
    np.testing.assert_array_equal(lifted_color[~is_lamp], plain[~is_lamp])


def test_inspect_proposes_lift_for_clipped_photo(photo):
    notes = " ".join(inspect(photo, PlateOptions())["notes"])
    assert "--lift-highlights 3" in notes and "1.2 %" in notes
    notes = inspect(photo, PlateOptions(lift_highlights_stops=2.0))["notes"]
    assert not any("--lift-highlights" in note for note in notes)


@pytest.mark.parametrize("suffix", [".exr", ".tif"])
def test_render_rejects_lift_of_light_that_is_not_clipped(tmp_path, capsys, suffix):
    path, flat = tmp_path / f"p{suffix}", np.full((8, 8), 0.5, np.float32)
    if suffix == ".exr":
        write_file(path, {"R": flat, "G": flat, "B": flat, "Z": flat})
    else:
        Image.fromarray(flat).save(path)
    words = ["--focal-length=50", "--f-stop=2", "--focus-distance=2", "--lift-highlights=3"]
    words += [] if suffix == ".exr" else ["--depth", str(path)]
    assert main(["render", str(path), "-o", str(tmp_path / "o.png"), *words]) == 2
    stderr = capsys.readouterr().err
    assert str(path) in stderr and "leave it out" in stderr


@pytest.mark.parametrize("stops", [-1.0, 11.0, float("nan")])
def test_plate_options_reject_lift_out_of_range(stops):
    with pytest.raises(InputError, match="0 to 10"):
        PlateOptions(lift_highlights_stops=stops)
