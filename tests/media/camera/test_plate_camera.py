"""Test the camera in a plate's headers, and the one that a shot's lens makes with them."""

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
from heatlens.media.camera.placement import shortest_decimal
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


def test_read_headers_does_not_need_the_pixels(tmp_path):
    path = write_file(tmp_path / "a.exr", rgb(90, 160), **lens_header())
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
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
def test_read_headers_reports_file_without_header(tmp_path, content, why):
    if content is not None:
        (tmp_path / "a.exr").write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.exr .*{why}|a\.exr {why}"):
        read_headers(tmp_path / "a.exr")


def test_read_camera_of_plate_has_lens_and_placement_of_every_frame(plate):
    camera = read_camera(plate)
    assert camera == read_plate_camera(plate)
    assert (camera.name, camera.frames) == ("plate", tuple(FRAMES))
    assert camera.focus_distance_m == tuple(2.0 + n for n in range(8))
    assert set(camera.f_stop) == {1.3}  # not the 1.2999999523 of float32
    assert (set(camera.sensor_width_mm), set(camera.sensor_height_mm)) == ({36.0}, {20.25})
    expected = np.array([world_to_camera(eye, TARGET) for eye in dolly()])
    assert np.array(camera.world_to_camera) == pytest.approx(expected, abs=1e-6)
    (note,) = camera.notes
    assert "worldToCamera" in note and "no placement" not in note


def test_read_plate_camera_converts_scene_unit_to_meters(plate):
    placements = np.array(read_plate_camera(plate, scene_unit_m=0.3048).world_to_camera)
    in_metres = np.array(read_plate_camera(plate).world_to_camera)
    assert placements[:, :3, 3] == pytest.approx(in_metres[:, :3, 3] * 0.3048)
    assert np.array_equal(placements[:, :, :3], in_metres[:, :, :3])


def test_read_plate_camera_leaves_out_missing_frames(plate, tmp_path):
    (tmp_path / "plate.1003.exr").unlink()
    camera = read_plate_camera(plate)
    assert camera.frames == (1001, 1002, *range(1004, 1009))
    assert camera.focus_distance_m == (2.0, 3.0, *(2.0 + n for n in range(3, 8)))


def test_read_plate_camera_of_still_has_one_frame(tmp_path):
    write_file(tmp_path / "still.exr", rgb(9, 16), pinholeFocalLength=35.0)
    camera = read_plate_camera(str(tmp_path / "still.exr"))
    assert (camera.name, camera.frames, camera.focal_length_mm) == ("still", (1,), (35.0,))
    assert (camera.f_stop, camera.focus_distance_m, camera.sensor_height_mm) == (None,) * 3
    (note,) = camera.notes
    assert "no worldToCamera" in note and "no placement" in note


def test_read_plate_camera_rejects_attribute_of_some_frames_only(plate, tmp_path):
    write_file(tmp_path / "plate.1003.exr", rgb(9, 16), pinholeFocalLength=50.0)
    with pytest.raises(InputError, match=r"plate.1003.exr: the header"):
        read_plate_camera(plate)


def write_exr_with_rate(path, *fraction: int) -> str:
    """Write an EXR with a frame rate; only the older API of the library writes fractions."""
    header = OpenEXR.Header(2, 2) | {"framesPerSecond": Imath.Rational(*fraction)}
    file = OpenEXR.OutputFile(str(path), header)
    file.writePixels(dict.fromkeys("RGB", np.zeros((2, 2), np.float32).tobytes()))
    file.close()
    return str(path)


@pytest.mark.parametrize(
    ("fraction", "rate"), [((24000, 1001), 24000 / 1001), ((0, 1), 24), ((-25, 1), 24)]
)
def test_read_plate_camera_reads_frame_rate_or_uses_24(tmp_path, fraction, rate):
    camera = read_plate_camera(write_exr_with_rate(tmp_path / "a.exr", *fraction))
    assert camera.frames_per_second == pytest.approx(rate, rel=1e-15)


def test_read_headers_rejects_rate_with_zero_denominator(tmp_path):
    with pytest.raises(InputError, match=r"a.exr cannot be read"):
        read_headers(write_exr_with_rate(tmp_path / "a.exr", 24, 0))


def test_read_plate_camera_finds_placement_in_any_part(tmp_path):
    placed = {"name": "depth", "worldToCamera": exr_attribute(EYE, TARGET)}
    path = write_parts(tmp_path / "a.exr", ({"name": "rgb"}, rgb()), (placed, {"Z": rgb()["R"]}))
    placements = np.array(read_plate_camera(str(path)).world_to_camera)
    assert placements == pytest.approx(np.array([world_to_camera(EYE, TARGET)]), abs=1e-6)


def test_camera_of_shot_takes_sensor_height_and_placement_from_plate(plate):
    camera = camera_of_shot(Shot(LENS, source=plate), "s")
    assert camera.frames == tuple(FRAMES)
    assert set(camera.sensor_height_mm) == {20.25}
    assert camera.world_to_camera == read_plate_camera(plate).world_to_camera
    assert set(camera.focus_distance_m) == {2.24}  # the shot's, not the header's
    assert camera.notes[0].startswith("sensor height 20.25 mm, from the shape of plate.1001.exr;")


def test_camera_of_shot_uses_scene_unit_of_shot_or_argument(plate):
    shot = Shot(LENS, source=plate, plate_options=PlateOptions(scene_unit_m=0.01))
    for unit_m, expected_m in ((None, 0.01), (0.1, 0.1)):
        placements = np.array(camera_of_shot(shot, "s", scene_unit_m=unit_m).world_to_camera)
        metres = np.array(read_plate_camera(plate).world_to_camera)
        assert placements[:, :3, 3] == pytest.approx(metres[:, :3, 3] * expected_m)


def test_camera_of_shot_covers_in_out_range_or_requested_frames(plate):
    shot = Shot(LENS, source=plate, frames=FRAMES, in_out=FrameRange(1003, 1005))
    assert camera_of_shot(shot, "s").frames == (1003, 1004, 1005)
    camera = camera_of_shot(shot, "s", FrameRange(1002, 1003))
    assert camera.frames == (1002, 1003)
    assert camera.world_to_camera == read_plate_camera(plate).world_to_camera[1:3]


def test_camera_of_shot_repeats_placement_of_still(tmp_path):
    attribute = exr_attribute(EYE, TARGET)
    path = write_file(tmp_path / "still.exr", rgb(9, 16), worldToCamera=attribute)
    shot = Shot(LENS, source=str(path))
    assert camera_of_shot(shot, "s").frames == (1,)
    camera = camera_of_shot(shot, "s", FrameRange(1, 3))
    assert len(camera.world_to_camera) == 3 and len(set(camera.world_to_camera)) == 1


def test_camera_of_shot_takes_frame_number_of_single_file(tmp_path):
    path = write_file(tmp_path / "plate.0007.exr", rgb(9, 16))
    assert camera_of_shot(Shot(LENS, source=str(path)), "s").frames == (7,)


def test_camera_of_shot_without_plate_files_needs_frames(tmp_path):
    with pytest.raises(InputError, match=r"The shot has no frames.*Give them with --frames"):
        camera_of_shot(Shot(LENS, source=str(tmp_path / "none.exr")), "s")


def test_camera_of_shot_omits_placement_if_some_frames_lack_it(plate, tmp_path):
    (tmp_path / "plate.1003.exr").unlink()
    write_file(tmp_path / "plate.1007.exr", rgb(9, 16), worldToCamera=np.full((4, 4), np.nan, "f4"))
    camera = camera_of_shot(Shot(LENS, source=plate), "s")
    assert camera.world_to_camera is None
    assert "at frames 1003,1007" in camera.notes[-1]


@pytest.mark.parametrize("broken", [np.zeros((4, 4), "f4"), 3 * np.eye(4, dtype="f4")])
def test_read_plate_camera_omits_impossible_placement(tmp_path, broken):
    path = write_file(tmp_path / "a.exr", rgb(), worldToCamera=broken)
    camera = read_plate_camera(str(path))
    assert camera.world_to_camera is None
    (note,) = camera.notes
    assert "shears" in note and "no placement" in note


def test_read_plate_camera_notes_left_handed_world(tmp_path):
    mirrored = np.diag([1, 1, -1, 1]).astype("f4") @ exr_attribute(EYE, TARGET)
    path = write_file(tmp_path / "a.exr", rgb(), worldToCamera=mirrored)
    camera = read_plate_camera(str(path))
    expected = np.array([world_to_camera(EYE, TARGET)])
    assert np.array(camera.world_to_camera) == pytest.approx(expected, abs=1e-6)
    assert "left-handed: its z is reversed" in camera.notes[-1]


def test_camera_of_shot_divides_sensor_height_by_pixel_aspect(tmp_path):
    """The shape is that of the display window; the data window may be larger or smaller."""
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
def test_camera_of_shot_without_plate_notes_assumed_sensor_height(
    width_mm, given_mm, height_mm, note
):
    shot = Shot(Lens(50.0, 2.0, 3.0, width_mm), source="none/plate.####.exr")
    camera = camera_of_shot(shot, "s", FrameRange(1, 2), given_mm)
    assert camera.sensor_height_mm == pytest.approx((height_mm or width_mm * 9 / 16,) * 2)
    assert camera.notes[0].startswith("the plate has no files:")
    assert note in camera.notes[1]
    assert "without a plate" in camera.notes[2] and "no placement" in camera.notes[2]


def test_camera_of_shot_reports_damaged_first_frame(plate, tmp_path):
    (tmp_path / "plate.1001.exr").write_bytes(b"\x76\x2f\x31\x01")
    with pytest.raises(InputError, match=r"plate\.1001\.exr .*its header is not whole"):
        camera_of_shot(Shot(LENS, source=plate), "s")


@pytest.mark.parametrize("unit", [1.0, 100.0, 1 / 0.3048, 0.01])
@pytest.mark.parametrize("value", [1.3, 50.0, 35.56, 2.8, 20.955, 1e9, 0.94])
def test_shortest_recovers_decimal_number_from_float32(value, unit):
    assert shortest_decimal(float(np.float32(value * unit)), unit) == value


def test_shortest_keeps_infinity_and_nan():
    assert shortest_decimal(np.inf) == np.inf
    assert np.isnan(shortest_decimal(np.nan))


@pytest.mark.parametrize(
    ("header_mm", "end"),
    [
        (24.0, "; its header says 24 mm, which is not the height of this picture."),
        (20.25, "of a.exr."),
        (20.2, "of a.exr."),  # rounded
        (0.0, "of a.exr."),  # not known
    ],
)
def test_camera_of_shot_notes_different_sensor_height_in_header(tmp_path, header_mm, end):
    lens = lens_attributes(50.0, 1.3, 2.0, 36.0, header_mm)
    path = write_file(tmp_path / "a.exr", rgb(90, 160), **lens)
    camera = camera_of_shot(Shot(LENS, source=str(path)), "s", FrameRange(1, 1))
    (note,) = (note for note in camera.notes if note.startswith("sensor height"))
    assert camera.sensor_height_mm == (20.25,) and note.endswith(end)
