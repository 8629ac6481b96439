"""The lens a window begins with: given, else the header's, else the usual; each source is told."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.media.plate.header.camera_header import camera_at_header, lens_attributes
from heatlens.media.plate.header.header_lens import MissingLensError, plate_lens, start_lens
from heatlens.media.plate.plate import CameraHeader
from support.plates import coc_plate_of, plate_of

UNKNOWN = CameraHeader()
HEADER = CameraHeader(
    focus_distance_m=3.5,
    f_stop=4.0,
    focal_length_mm=35.0,
    sensor_width_mm=24.0,
    t_stop=4.4,
    sources={
        "focus_distance_m": "focus",
        "f_stop": "aperture",
        "focal_length_mm": "pinholeFocalLength",
        "sensor_width_mm": "sensorOverallDimensions",
    },
)


def plate(depth_m: np.ndarray, camera: CameraHeader = UNKNOWN):
    color = np.zeros((*depth_m.shape, 3), np.float32)
    return plate_of(color, depth_m.astype(np.float32), camera=camera)


def ramp(height: int = 9, width: int = 12) -> np.ndarray:
    """Return metres 1 to 12 across."""
    return np.tile(np.arange(1, width + 1, dtype=np.float32), (height, 1))


def test_the_header_is_taken_whole():
    begun = start_lens(plate(ramp(), HEADER), {})
    assert begun.lens == Lens(35.0, 4.0, 3.5, 24.0, t_stop=4.4)
    assert begun.sources["f_stop"] == "header, aperture"
    assert begun.sources["focus_distance_m"] == "header, focus"


def test_without_a_header_it_is_the_usual_lens_focused_on_the_middle():
    begun = start_lens(plate(ramp()), {})
    assert begun.lens == Lens(50.0, 2.8, 7.0, 36.0)  # the middle ninth holds 5, 6, 7 and 8 m
    assert begun.sources["focal_length_mm"].startswith("assumed")
    assert begun.sources["focus_distance_m"] == "what is in the middle of the picture"


GIVEN = st.fixed_dictionaries(
    {},
    optional={
        "focal_length_mm": st.floats(10, 200),
        "f_stop": st.floats(0.7, 32),
        "sensor_width_mm": st.floats(5, 70),
        "focus_distance_m": st.one_of(st.floats(0.3, 100), st.just(math.inf)),
        "squeeze": st.floats(1, 2),
        "close_focus_m": st.floats(0.1, 2),
    },
)


@given(GIVEN)
def test_what_is_given_wins_and_the_rest_is_as_without(given_values):
    header = start_lens(plate(ramp(), HEADER), {}).lens
    begun = start_lens(plate(ramp(), HEADER), given_values)
    assert begun.lens == replace(header, **given_values)
    told = {name for name, source in begun.sources.items() if source == "given"}
    assert told == set(given_values) - {"squeeze", "close_focus_m"}


@pytest.mark.parametrize(
    ("depth_m", "focus_m"),
    [
        (np.full((3, 3), np.inf), math.inf),  # sky alone
        (np.full((1, 1), 4.0), 4.0),
        (np.full((1, 200), 2.0), 2.0),
        (np.full((200, 1), 2.0), 2.0),
        (np.full((6, 6), 0.02), math.inf),  # nearer than the focal length: no lens focuses there
        (np.where(np.arange(36).reshape(6, 6) % 2, 5.0, np.inf), math.inf),  # the farther of halves
    ],
)
def test_focus_on_the_middle_of_any_plate(depth_m, focus_m):
    assert start_lens(plate(depth_m), {}).lens.focus_distance_m == focus_m


def test_a_header_focused_within_its_focal_length_is_not_believed():
    begun = start_lens(plate(ramp(), replace(HEADER, focus_distance_m=0.03)), {})
    assert begun.lens.focus_distance_m == 7.0


def test_a_header_focused_at_infinity_is():
    begun = start_lens(plate(ramp(), replace(HEADER, focus_distance_m=math.inf)), {})
    assert begun.lens.focus_distance_m == math.inf


def test_a_header_that_no_lens_can_have_is_not_believed():
    """A picture is seen all the same; the panel tells what was assumed."""
    absurd = replace(HEADER, focal_length_mm=3e9, f_stop=1e-9, t_stop=1e12)
    begun = start_lens(plate(ramp(), absurd), {})
    assert (begun.lens.focal_length_mm, begun.lens.f_stop) == (50.0, 2.8)
    assert (begun.lens.sensor_width_mm, begun.lens.t_stop) == (24.0, None)
    assert begun.sources["f_stop"].startswith("assumed")


def test_a_plate_with_its_own_blur_has_a_lens_all_the_same():
    color = np.zeros((4, 4, 3), np.float32)
    begun = start_lens(coc_plate_of(color, np.zeros((4, 4))), {})
    assert begun.lens == Lens(50.0, 2.8, math.inf, 36.0)


def test_given_values_that_make_no_lens_are_refused():
    with pytest.raises(LensError, match="focal length of 50 mm"):
        start_lens(plate(ramp()), {"focus_distance_m": 0.01})


@pytest.mark.parametrize(
    ("header", "model"),
    [
        ({"cycles.ViewLayer.samples": "64"}, LensModel.RENDERER),
        ({"cameraModel": "ALEXA 35"}, LensModel.PHOTOGRAPHIC),
        ({"Software": "Blender 5.0.1", **lens_attributes(50, 2, 3, 36)}, LensModel.RENDERER),
        (lens_attributes(50, 2, 3, 36, model=LensModel.RENDERER), LensModel.RENDERER),
        (
            {
                "Software": "Blender 5.0.1",
                **lens_attributes(50, 2, 3, 36, model=LensModel.PHOTOGRAPHIC),
            },
            LensModel.PHOTOGRAPHIC,
        ),
    ],
)
def test_the_header_decides_whose_discs_they_are(header, model):
    told = plate(ramp(), camera_at_header([header]))
    given_values = {"focal_length_mm": 50.0, "f_stop": 2.0, "focus_distance_m": 3.0}
    assert start_lens(told, {}).lens.model is plate_lens(told, given_values).lens.model is model
    for other in LensModel:
        assert start_lens(told, {"model": other}).lens.model is other


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ({"aperture": 0.0}, {"f_stop": "aperture is 0"}),
        ({"focus": -1.0, "aperture": 2.0}, {"focus_distance_m": "focus is -1"}),
        ({"pinholeFocalLength": math.nan}, {"focal_length_mm": "pinholeFocalLength is nan"}),
        ({"aperture": "wide open"}, {"f_stop": "aperture is 'wide open'"}),
        ({"pinholeFocalLength": 0.0, "nominalFocalLength": 50.0}, {}),
        (
            {"sensorOverallDimensions": np.float32([0, 24])},
            {"sensor_width_mm": "sensorOverallDimensions is 0 x 24"},
        ),
        ({"sensorOverallDimensions": np.float32([36, 0])}, {}),  # a height that is not known
        ({"focus": math.inf}, {}),
    ],
)
def test_values_that_no_lens_has_are_named(header, words):
    assert camera_at_header([header]).refused == words


def test_a_refusal_names_the_values_that_were_left_out():
    header = {"aperture": 0.0, "focus": -1.0}
    flat = plate(np.ones((2, 2)), camera_at_header([header]))
    with pytest.raises(MissingLensError) as error:
        plate_lens(flat, {"focal_length_mm": 50.0})
    assert "0 and focus is -1" in str(error.value)
    with pytest.raises(MissingLensError, match="no focus distance; give it"):
        plate_lens(plate(np.ones((2, 2))), {"focal_length_mm": 50.0, "f_stop": 2.0})
