"""Test Record3D captures: the lens and rate come from metadata.json, whatever it holds."""

import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from heatlens.core.model.shot.plate_options import PictureCurve
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.parts.picture_parts import color_parts, picture_header
from heatlens.media.plate.picture.capture_folder import capture_info

TOLD = {"K": [200.0, 0, 0, 0, 200.0, 0, 45, 60, 1], "w": 90, "h": 120, "fps": 60, "poses": []}
JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=2), inner),
    max_leaves=4,
)


@pytest.fixture
def frame(tmp_path):
    (tmp_path / "rgb").mkdir()
    path = tmp_path / "rgb" / "0.jpg"
    Image.fromarray(np.full((120, 90, 3), 90, np.uint8)).save(path)
    (tmp_path / "metadata.json").write_text(json.dumps(TOLD))
    return path


def test_capture_lens_is_that_of_the_full_frame(frame):
    """200 px over 120 px give a focal length of 200/120 times the long side of 36 mm."""
    camera = camera_at_header([picture_header(frame)])
    assert camera.focal_length_mm == pytest.approx(36 * 200 / 120)
    assert camera.sensor_width_mm == pytest.approx(36 * 90 / 120)
    assert camera.focus_distance_m is None and camera.f_stop is None
    ((header, _),) = color_parts(frame, PictureCurve.AUTO)
    assert header["framesPerSecond"] == Fraction(60)


def test_capture_info_of_other_folder_is_empty(frame):
    frame.parent.rename(frame.parent.with_name("frames"))
    assert capture_info(frame.parents[1] / "frames" / "0.jpg", (90, 120)) == {}


@pytest.mark.parametrize(
    "changed", [{"K": []}, {"K": [0]}, {"w": 120}, {"h": "x"}, {"w": 0}, {"K": None}, {"fps": []}]
)
def test_capture_without_valid_metadata_has_a_note(frame, changed):
    (frame.parents[1] / "metadata.json").write_text(json.dumps(TOLD | changed))
    ((header, _),) = color_parts(frame, PictureCurve.AUTO)
    assert camera_at_header([header]).focal_length_mm is None
    (note,) = (it for it in header["heatlens:pictureFacts"].notes if "metadata.json" in it)
    assert note.endswith("its lens is assumed.")


@given(st.fixed_dictionaries({name: JSON for name in TOLD}) | JSON)
def test_capture_info_of_any_metadata_does_not_fail(tmp_path_factory, metadata):
    folder = tmp_path_factory.mktemp("capture")
    (folder / "rgb").mkdir()
    (folder / "metadata.json").write_text(json.dumps(metadata))
    assert capture_info(folder / "rgb" / "0.jpg", (90, 120)).keys() <= {"header", "note"}
