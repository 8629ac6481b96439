"""Test the start lens: given values, then the header's, then defaults, each with its source."""

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


def test_start_lens_takes_all_values_of_header():
    start = start_lens(plate(ramp(), HEADER), {})
    assert start.lens == Lens(35.0, 4.0, 3.5, 24.0, t_stop=4.4)
    assert start.sources["f_stop"] == "header, aperture"
    assert start.sources["focus_distance_m"] == "header, focus"


def test_start_lens_without_header_focuses_on_middle():
    start = start_lens(plate(ramp()), {})
    assert start.lens == Lens(50.0, 2.8, 7.0, 36.0)  # the middle ninth holds 5, 6, 7 and 8 m
    assert start.sources["focal_length_mm"].startswith("assumed")
    assert start.sources["focus_distance_m"] == "what is in the middle of the picture"


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
def test_start_lens_prefers_given_values(given_values):
    header = start_lens(plate(ramp(), HEADER), {}).lens
    start = start_lens(plate(ramp(), HEADER), given_values)
    assert start.lens == replace(header, **given_values)
    given_names = {name for name, source in start.sources.items() if source == "given"}
    assert given_names == set(given_values) - {"squeeze", "close_focus_m"}


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
def test_start_lens_focus_is_median_of_middle_of_plate(depth_m, focus_m):
    assert start_lens(plate(depth_m), {}).lens.focus_distance_m == focus_m


def test_start_lens_ignores_header_focus_within_focal_length():
    start = start_lens(plate(ramp(), replace(HEADER, focus_distance_m=0.03)), {})
    assert start.lens.focus_distance_m == 7.0


def test_start_lens_accepts_header_focus_at_infinity():
    start = start_lens(plate(ramp(), replace(HEADER, focus_distance_m=math.inf)), {})
    assert start.lens.focus_distance_m == math.inf


def test_start_lens_ignores_impossible_header_values():
    """The plate is shown all the same; the panel names the assumed values."""
    impossible_header = replace(HEADER, focal_length_mm=3e9, f_stop=1e-9, t_stop=1e12)
    start = start_lens(plate(ramp(), impossible_header), {})
    assert (start.lens.focal_length_mm, start.lens.f_stop) == (50.0, 2.8)
    assert (start.lens.sensor_width_mm, start.lens.t_stop) == (24.0, None)
    assert start.sources["f_stop"].startswith("assumed")


def test_start_lens_of_circle_of_confusion_plate_is_default():
    color = np.zeros((4, 4, 3), np.float32)
    start = start_lens(coc_plate_of(color, np.zeros((4, 4))), {})
    assert start.lens == Lens(50.0, 2.8, math.inf, 36.0)


def test_start_lens_rejects_impossible_given_values():
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
def test_lens_model_follows_header_unless_given(header, model):
    plate_with_header = plate(ramp(), camera_at_header([header]))
    given_values = {"focal_length_mm": 50.0, "f_stop": 2.0, "focus_distance_m": 3.0}
    assert (
        start_lens(plate_with_header, {}).lens.model
        is plate_lens(plate_with_header, given_values).lens.model
        is model
    )
    for given_model in LensModel:
        assert start_lens(plate_with_header, {"model": given_model}).lens.model is given_model


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
def test_camera_at_header_names_impossible_values(header, words):
    assert camera_at_header([header]).refused == words


def test_missing_lens_error_names_refused_header_values():
    header = {"aperture": 0.0, "focus": -1.0}
    flat = plate(np.ones((2, 2)), camera_at_header([header]))
    with pytest.raises(MissingLensError) as error:
        plate_lens(flat, {"focal_length_mm": 50.0})
    assert "0 and focus is -1" in str(error.value)
    with pytest.raises(MissingLensError, match="no focus distance; give it"):
        plate_lens(plate(np.ones((2, 2))), {"focal_length_mm": 50.0, "f_stop": 2.0})
