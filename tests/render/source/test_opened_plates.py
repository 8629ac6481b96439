"""Opened plates and SourceOpener: first frame, metadata, refused files and canceled openings."""

from fractions import Fraction

import pytest

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.placing import Placing
from heatlens.render.source.opened import Opening
from heatlens.render.source.opened_plates import open_plates
from heatlens.render.source.opener import SourceOpener
from heatlens.render.source.scene_source import SceneSource
from support.session_files import LENS, room_file, write_scene

FRAMES = (3, 4, 6)


@pytest.fixture
def pattern(tmp_path):
    for frame in FRAMES:
        room_file(tmp_path / f"shot.{frame:04}.exr", 8, 6, framesPerSecond=30.0)
    return str(tmp_path / "shot.####.exr")


def open_plates_named(text, frame=None, wake=lambda: None):
    return open_plates(Opening(text=str(text), options=PlateOptions(), frame=frame, wake=wake))


@pytest.mark.parametrize(
    ("name", "requested_frame", "first"),
    [
        ("shot.####.exr", None, 3),
        ("shot.####.exr", 6, 6),
        ("shot.####.exr", 5, 3),  # it has no file
        ("shot.0004.exr", None, 4),
        ("shot.0004.exr", 6, 6),
        ("shot.0004.exr", 9, 4),
    ],
)
def test_open_plates_starts_at_requested_frame_or_that_of_name(
    pattern, tmp_path, name, requested_frame, first
):
    plates = open_plates_named(tmp_path / name, requested_frame)
    plates.close()
    assert plates.frame == first and plates.plate.path.name == f"shot.{first:04}.exr"


def test_opened_plates_have_frames_files_and_lens(pattern, tmp_path):
    plates = open_plates_named(pattern)
    try:
        assert plates.text == pattern and plates.frames == FrameRange(3, 6)
        assert plates.files_at(4, "stop") == (tmp_path / "shot.0004.exr",)
        assert plates.files_at(5, "hold") == (tmp_path / "shot.0004.exr",)
        assert plates.files_at(5, "black") == () == plates.files_at(5, "stop")
        assert plates.notes == plates.plate.notes and plates.attributes == plates.plate.attributes
        assert plates.scene is plates.timing is None and plates.stamps == ()
        assert plates.settled_options.depth_convention is plates.plate.depth.convention
        start = plates.lens({})
        assert start.lens == LENS
        shot = plates.shot(start.lens, DefocusSettings())
        assert (shot.frames, shot.source) == (FrameRange(3, 6), pattern)
        assert shot.plate_options == plates.options
    finally:
        plates.close()


def test_shot_has_frame_rate_of_header_or_24(tmp_path):
    rates = []
    for name, attributes in (("a", {"framesPerSecond": Fraction(30)}), ("b", {})):
        plates = open_plates_named(room_file(tmp_path / f"{name}.exr", 8, 6, **attributes))
        rates.append(plates.shot(LENS, DefocusSettings()).frames_per_second)
        assert plates.frames is None
        plates.close()
    assert rates == [30.0, 24.0]


def test_read_ahead_counts_changes_and_wakes_loop(pattern):
    wake_calls = []
    plates = open_plates_named(pattern, wake=lambda: wake_calls.append(True))
    try:
        count_before = plates.change_count
        assert isinstance(plates.cache.read_and_wait(6, window=0), Plate)
        assert plates.change_count > count_before and len(wake_calls) == plates.change_count
    finally:
        plates.close()


def test_open_plates_error_names_unreadable_first_frame(pattern, tmp_path):
    (tmp_path / "shot.0003.exr").write_bytes(b"damaged")
    with pytest.raises(InputError, match=r"shot\.0003\.exr"):
        open_plates_named(pattern)
    open_plates_named(tmp_path / "shot.0004.exr").close()


def wait_for_source(opener):
    opener._current.wait()
    return opener.poll()


def test_opener_keeps_failure_until_next_open(pattern, tmp_path):
    wake_calls = []
    opener = SourceOpener(lambda: wake_calls.append(True))
    missing, options = str(tmp_path / "missing.exr"), PlateOptions(scene_unit_m=0.01)
    opener.open(missing, options)
    assert opener.opening == missing and opener.failure is None
    with pytest.raises(HeatlensError, match="missing"):
        wait_for_source(opener)
    assert opener.opening is None and wake_calls
    assert (opener.failure.text, opener.failure.options) == (missing, options)
    assert "missing" in opener.failure.message
    opener.open(pattern, PlateOptions(), frame=6)
    assert opener.failure is None
    plates = wait_for_source(opener)
    assert plates.frame == 6 and opener.opening is None and opener.poll() is None
    plates.close()
    opener.close()


def test_opener_cancel_stops_reading_and_returns_nothing(pattern):
    opener = SourceOpener(lambda: None)
    opener.open(pattern, PlateOptions())
    stop = opener._stop
    opener.cancel()
    assert opener.opening is None and stop._is_requested and opener.poll() is None
    opener.open(pattern, PlateOptions())
    assert opener._stop is not stop
    wait_for_source(opener).close()


def test_opener_asks_placing_of_scene(tmp_path):
    path, requested_names = write_scene(tmp_path / "a.glb"), []

    def placing_of(text):
        requested_names.append(text)
        return Placing()

    opener = SourceOpener(lambda: None, placing_of=placing_of)
    opener.open(str(path), PlateOptions(), frame=7)
    scene = wait_for_source(opener)
    assert requested_names == [str(path)] and isinstance(scene.render_source, SceneSource)
    scene.close()
