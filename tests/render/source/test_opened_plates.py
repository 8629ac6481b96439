"""Plates that were opened: which frame comes first, what is said of it, and what is refused."""

from fractions import Fraction

import pytest

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.placing import Placing
from heatlens.render.source.opened import Opening
from heatlens.render.source.opened_plates import opened_plates
from heatlens.render.source.opener import SourceOpener
from heatlens.render.source.scene_source import SceneSource
from support.session_files import LENS, room_file, write_scene

FRAMES = (3, 4, 6)


@pytest.fixture
def pattern(tmp_path):
    for frame in FRAMES:
        room_file(tmp_path / f"shot.{frame:04}.exr", 8, 6, framesPerSecond=30.0)
    return str(tmp_path / "shot.####.exr")


def opened(text, frame=None, wake=lambda: None):
    return opened_plates(Opening(str(text), PlateOptions(), frame, wake=wake))


@pytest.mark.parametrize(
    ("name", "wanted", "first"),
    [
        ("shot.####.exr", None, 3),
        ("shot.####.exr", 6, 6),
        ("shot.####.exr", 5, 3),  # it has no file
        ("shot.0004.exr", None, 4),
        ("shot.0004.exr", 6, 6),
        ("shot.0004.exr", 9, 4),
    ],
)
def test_the_wanted_frame_comes_first_else_that_of_the_name(pattern, tmp_path, name, wanted, first):
    found = opened(tmp_path / name, wanted)
    found.close()
    assert found.frame == first and found.plate.path.name == f"shot.{first:04}.exr"


def test_what_is_opened_tells_its_frames_files_and_lens(pattern, tmp_path):
    found = opened(pattern)
    try:
        assert found.text == pattern and found.frames == FrameRange(3, 6)
        assert found.files_at(4, "stop") == (tmp_path / "shot.0004.exr",)
        assert found.files_at(5, "hold") == (tmp_path / "shot.0004.exr",)
        assert found.files_at(5, "black") == () == found.files_at(5, "stop")
        assert found.notes == found.plate.notes and found.attributes == found.plate.attributes
        assert found.scene is found.timing is None and found.stamps == ()
        assert found.settled.depth_convention is found.plate.depth.convention
        start = found.lens({})
        assert start.lens == LENS
        shot = found.shot(start.lens, DefocusSettings())
        assert (shot.frames, shot.source) == (FrameRange(3, 6), pattern)
        assert shot.plate_options == found.options
    finally:
        found.close()


def test_the_rate_of_the_header_is_that_of_the_shot_and_24_without_one(tmp_path):
    rates = []
    for name, attributes in (("a", {"framesPerSecond": Fraction(30)}), ("b", {})):
        found = opened(room_file(tmp_path / f"{name}.exr", 8, 6, **attributes))
        rates.append(found.shot(LENS, DefocusSettings()).frames_per_second)
        assert found.frames is None
        found.close()
    assert rates == [30.0, 24.0]


def test_frames_that_are_read_ahead_are_news_and_wake_the_loop(pattern):
    woken = []
    found = opened(pattern, wake=lambda: woken.append(True))
    try:
        before = found.news
        assert isinstance(found.cache.wait(6, window=0), Plate)
        assert found.news > before and len(woken) == found.news
    finally:
        found.close()


def test_a_first_frame_that_cannot_be_read_is_named(pattern, tmp_path):
    (tmp_path / "shot.0003.exr").write_bytes(b"damaged")
    with pytest.raises(InputError, match=r"shot\.0003\.exr"):
        opened(pattern)
    opened(tmp_path / "shot.0004.exr").close()


def waited(opener):
    opener._coming.wait()
    return opener.poll()


def test_a_refusal_is_kept_until_something_else_is_opened(pattern, tmp_path):
    woken = []
    opener = SourceOpener(lambda: woken.append(True))
    missing, options = str(tmp_path / "missing.exr"), PlateOptions(scene_unit_m=0.01)
    opener.open(missing, options)
    assert opener.opening == missing and opener.refused is None
    with pytest.raises(HeatlensError, match="missing"):
        waited(opener)
    assert opener.opening is None and woken
    assert (opener.refused.text, opener.refused.options) == (missing, options)
    assert "missing" in opener.refused.sentence
    opener.open(pattern, PlateOptions(), frame=6)
    assert opener.refused is None
    found = waited(opener)
    assert found.frame == 6 and opener.opening is None and opener.poll() is None
    found.close()
    opener.close()


def test_a_cancelled_opening_brings_nothing_and_stops_reading(pattern):
    opener = SourceOpener(lambda: None)
    opener.open(pattern, PlateOptions())
    stop = opener._stop
    opener.cancel()
    assert opener.opening is None and stop._is_asked and opener.poll() is None
    opener.open(pattern, PlateOptions())
    assert opener._stop is not stop
    waited(opener).close()


def test_a_scene_is_placed_as_the_user_said_of_it(tmp_path):
    path, asked = write_scene(tmp_path / "a.glb"), []

    def placing_of(text):
        asked.append(text)
        return Placing()

    opener = SourceOpener(lambda: None, placing_of=placing_of)
    opener.open(str(path), PlateOptions(), frame=7)
    found = waited(opener)
    assert asked == [str(path)] and isinstance(found.again, SceneSource)
    found.close()
