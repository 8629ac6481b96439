"""The camera that a plate's headers tell of, and the one a shot's lens makes with them."""

import Imath
import numpy as np
import OpenEXR
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.camera.placement import shortest
from heatlens.media.camera.plate_camera import read_plate_camera
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.render.source.named import camera_of_shot
from support.cameras import EYE, FRAMES, TARGET, dolly, exr_attribute, world_to_camera
from support.exr_files import rgb, window, write_file, write_parts

LENS = Lens(50.0, 1.3, 2.24, 36.0)


def lens_header(focus_m: float = 2.24) -> dict:
    return lens_attributes(50.0, 1.3, focus_m, 36.0, 24.0)


@pytest.fixture
def plate(tmp_path):
    """Return a sequence that moves: a pattern for its files, 16 x 9 pixels."""
    for index, (frame, eye) in enumerate(zip(FRAMES, dolly(), strict=True)):
        header = lens_header(2.0 + index) | {"worldToCamera": exr_attribute(eye, TARGET)}
        write_file(tmp_path / f"plate.{frame}.exr", rgb(9, 16), **header)
    return str(tmp_path / "plate.####.exr")


def test_a_header_is_read_without_its_pixels(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb(90, 160), **lens_header())
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    (header,) = read_headers(path)
    assert header["focus"] == pytest.approx(2.24)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (None, "is not there"),
        (b"", "is empty"),
        (b"\x89PNG", "is not an OpenEXR file"),
        (b"\x76\x2f\x31\x01\x02\x00", "its header is not whole"),
    ],
)
def test_what_has_no_header_is_told(tmp_path, content, why):
    if content is not None:
        (tmp_path / "a.exr").write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.exr .*{why}|a\.exr {why}"):
        read_headers(tmp_path / "a.exr")


def test_the_lens_and_the_place_of_every_frame(plate):
    found = read_camera(plate)
    assert found == read_plate_camera(plate)
    assert (found.name, found.frames) == ("plate", tuple(FRAMES))
    assert found.focus_distance_m == tuple(2.0 + n for n in range(8))
    assert set(found.f_stop) == {1.3}  # not the 1.2999999523 of float32
    assert (set(found.sensor_width_mm), set(found.sensor_height_mm)) == ({36.0}, {20.25})
    expected = np.array([world_to_camera(eye, TARGET) for eye in dolly()])
    assert np.array(found.world_to_camera) == pytest.approx(expected, abs=1e-6)
    (note,) = found.notes
    assert "worldToCamera" in note and "no placement" not in note


def test_a_world_in_feet_comes_out_in_metres(plate):
    found = np.array(read_plate_camera(plate, scene_unit_m=0.3048).world_to_camera)
    metres = np.array(read_plate_camera(plate).world_to_camera)
    assert found[:, :3, 3] == pytest.approx(metres[:, :3, 3] * 0.3048)
    assert np.array_equal(found[:, :, :3], metres[:, :, :3])


def test_frames_that_are_not_there_are_left_out(plate, tmp_path):
    (tmp_path / "plate.1003.exr").unlink()
    found = read_plate_camera(plate)
    assert found.frames == (1001, 1002, *range(1004, 1009))
    assert found.focus_distance_m == (2.0, 3.0, *(2.0 + n for n in range(3, 8)))


def test_a_still_is_a_camera_at_one_frame(tmp_path):
    write_file(tmp_path / "still.exr", rgb(9, 16), pinholeFocalLength=35.0)
    found = read_plate_camera(str(tmp_path / "still.exr"))
    assert (found.name, found.frames, found.focal_length_mm) == ("still", (1,), (35.0,))
    assert (found.f_stop, found.focus_distance_m, found.sensor_height_mm) == (None,) * 3
    (note,) = found.notes
    assert "no worldToCamera" in note and "no placement" in note


def test_what_only_some_frames_tell_is_refused(plate, tmp_path):
    write_file(tmp_path / "plate.1003.exr", rgb(9, 16), pinholeFocalLength=50.0)
    with pytest.raises(InputError, match=r"plate.1003.exr: the header"):
        read_plate_camera(plate)


def file_at_rate(path, *fraction: int) -> str:
    """Write an EXR with a frame rate; only the older API of the library writes fractions."""
    header = OpenEXR.Header(2, 2) | {"framesPerSecond": Imath.Rational(*fraction)}
    file = OpenEXR.OutputFile(str(path), header)
    file.writePixels(dict.fromkeys("RGB", np.zeros((2, 2), np.float32).tobytes()))
    file.close()
    return str(path)


@pytest.mark.parametrize(
    ("fraction", "rate"), [((24000, 1001), 24000 / 1001), ((0, 1), 24), ((-25, 1), 24)]
)
def test_the_rate_of_the_header_is_read_where_a_film_can_have_it(tmp_path, fraction, rate):
    found = read_plate_camera(file_at_rate(tmp_path / "a.exr", *fraction))
    assert found.frames_per_second == pytest.approx(rate, rel=1e-15)


def test_a_rate_that_is_no_fraction_is_a_damaged_header(tmp_path):
    with pytest.raises(InputError, match=r"a.exr cannot be read"):
        read_headers(file_at_rate(tmp_path / "a.exr", 24, 0))


def test_any_part_may_hold_the_place(tmp_path):
    placed = {"name": "depth", "worldToCamera": exr_attribute(EYE, TARGET)}
    path = write_parts(tmp_path / "a.exr", ({"name": "rgb"}, rgb()), (placed, {"Z": rgb()["R"]}))
    found = np.array(read_plate_camera(str(path)).world_to_camera)
    assert found == pytest.approx(np.array([world_to_camera(EYE, TARGET)]), abs=1e-6)


def test_a_shot_takes_height_and_place_from_its_plate(plate):
    camera = camera_of_shot(Shot(LENS, source=plate), "s")
    assert camera.frames == tuple(FRAMES)
    assert set(camera.sensor_height_mm) == {20.25}
    assert camera.world_to_camera == read_plate_camera(plate).world_to_camera
    assert set(camera.focus_distance_m) == {2.24}  # the shot's, not the header's
    assert camera.notes[0].startswith("sensor height 20.25 mm, from the shape of plate.1001.exr;")


def test_the_scene_unit_of_the_shot_is_that_of_its_plates_world(plate):
    shot = Shot(LENS, source=plate, plate_options=PlateOptions(scene_unit_m=0.01))
    for unit_m, expected_m in ((None, 0.01), (0.1, 0.1)):
        found = np.array(camera_of_shot(shot, "s", scene_unit_m=unit_m).world_to_camera)
        metres = np.array(read_plate_camera(plate).world_to_camera)
        assert found[:, :3, 3] == pytest.approx(metres[:, :3, 3] * expected_m)


def test_the_part_that_is_played_is_handed_on_unless_frames_are_given(plate):
    shot = Shot(LENS, source=plate, frames=FRAMES, in_out=FrameRange(1003, 1005))
    assert camera_of_shot(shot, "s").frames == (1003, 1004, 1005)
    given = camera_of_shot(shot, "s", FrameRange(1002, 1003))
    assert given.frames == (1002, 1003)
    assert given.world_to_camera == read_plate_camera(plate).world_to_camera[1:3]


def test_a_still_stands_at_every_frame(tmp_path):
    attribute = exr_attribute(EYE, TARGET)
    path = write_file(tmp_path / "still.exr", rgb(9, 16), worldToCamera=attribute)
    shot = Shot(LENS, source=str(path))
    assert camera_of_shot(shot, "s").frames == (1,)
    camera = camera_of_shot(shot, "s", FrameRange(1, 3))
    assert len(camera.world_to_camera) == 3 and len(set(camera.world_to_camera)) == 1


def test_a_single_frame_of_a_renderer_is_that_frame(tmp_path):
    path = write_file(tmp_path / "plate.0007.exr", rgb(9, 16))
    assert camera_of_shot(Shot(LENS, source=str(path)), "s").frames == (7,)


def test_a_plate_without_files_needs_frames(tmp_path):
    with pytest.raises(InputError, match=r"The shot has no frames.*Give them with --frames"):
        camera_of_shot(Shot(LENS, source=str(tmp_path / "none.exr")), "s")


def test_a_place_that_some_frames_do_not_tell_is_left_out(plate, tmp_path):
    (tmp_path / "plate.1003.exr").unlink()
    write_file(tmp_path / "plate.1007.exr", rgb(9, 16), worldToCamera=np.full((4, 4), np.nan, "f4"))
    camera = camera_of_shot(Shot(LENS, source=plate), "s")
    assert camera.world_to_camera is None
    assert "at frames 1003,1007" in camera.notes[-1]


@pytest.mark.parametrize("broken", [np.zeros((4, 4), "f4"), 3 * np.eye(4, dtype="f4")])
def test_a_place_that_is_none_is_left_out(tmp_path, broken):
    path = write_file(tmp_path / "a.exr", rgb(), worldToCamera=broken)
    found = read_plate_camera(str(path))
    assert found.world_to_camera is None
    (note,) = found.notes
    assert "shears" in note and "no placement" in note


def test_a_left_handed_world_is_said_aloud(tmp_path):
    mirrored = np.diag([1, 1, -1, 1]).astype("f4") @ exr_attribute(EYE, TARGET)
    path = write_file(tmp_path / "a.exr", rgb(), worldToCamera=mirrored)
    found = read_plate_camera(str(path))
    expected = np.array([world_to_camera(EYE, TARGET)])
    assert np.array(found.world_to_camera) == pytest.approx(expected, abs=1e-6)
    assert "left-handed: its z is reversed" in found.notes[-1]


def test_wide_pixels_make_a_flat_sensor(tmp_path):
    """Of the display window, not of the data window that may be larger or smaller."""
    header = {"pixelAspectRatio": 2.0, "displayWindow": window(0, 0, 10, 10)}
    path = write_file(tmp_path / "a.exr", rgb(), dataWindow=window(1, 1, 9, 7), **header)
    camera = camera_of_shot(Shot(LENS, source=str(path)), "s", FrameRange(1, 1))
    assert camera.sensor_height_mm == (18.0,)


@pytest.mark.parametrize(
    ("width_mm", "given_mm", "height_mm", "note"),
    [
        (24.89, None, None, "16:9"),  # Super 35 with three perforations and with four
        (36.0, None, 24.0, "assumed: film back Full frame"),  # and Blender's, of one height
        (28.25, None, 18.17, "assumed: film back ARRI Alexa Mini"),
        (30.0, None, 30 * 9 / 16, "assumed: a picture of 16:9"),
        (36.0, 15.0, 15.0, "sensor height 15 mm, as given"),
    ],
)
def test_without_a_plate_the_height_is_assumed_aloud(width_mm, given_mm, height_mm, note):
    shot = Shot(Lens(50.0, 2.0, 3.0, width_mm), source="none/plate.####.exr")
    camera = camera_of_shot(shot, "s", FrameRange(1, 2), given_mm)
    assert camera.sensor_height_mm == pytest.approx((height_mm or width_mm * 9 / 16,) * 2)
    assert camera.notes[0].startswith("the plate has no files:")
    assert note in camera.notes[1]
    assert "without a plate" in camera.notes[2] and "no placement" in camera.notes[2]


def test_a_damaged_first_frame_is_told(plate, tmp_path):
    (tmp_path / "plate.1001.exr").write_bytes(b"\x76\x2f\x31\x01")
    with pytest.raises(InputError, match=r"plate\.1001\.exr .*its header is not whole"):
        camera_of_shot(Shot(LENS, source=plate), "s")


@pytest.mark.parametrize("unit", [1.0, 100.0, 1 / 0.3048, 0.01])
@pytest.mark.parametrize("value", [1.3, 50.0, 35.56, 2.8, 20.955, 1e9, 0.94])
def test_a_number_kept_in_float32_is_read_as_it_was_meant(value, unit):
    assert shortest(float(np.float32(value * unit)), unit) == value


def test_infinity_stays_and_no_number_stays_none():
    assert shortest(np.inf) == np.inf
    assert np.isnan(shortest(np.nan))


@pytest.mark.parametrize(
    ("header_mm", "end"),
    [
        (24.0, "; its header says 24 mm, which is not the height of this picture."),
        (20.25, "of a.exr."),
        (20.2, "of a.exr."),  # rounded
        (0.0, "of a.exr."),  # not known
    ],
)
def test_another_height_in_the_header_is_told(tmp_path, header_mm, end):
    lens = lens_attributes(50.0, 1.3, 2.0, 36.0, header_mm)
    path = write_file(tmp_path / "a.exr", rgb(90, 160), **lens)
    camera = camera_of_shot(Shot(LENS, source=str(path)), "s", FrameRange(1, 1))
    (note,) = (note for note in camera.notes if note.startswith("sensor height"))
    assert camera.sensor_height_mm == (20.25,) and note.endswith(end)
