"""PlateSource: the files of each frame, replacements of missing frames, and the loader."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.read import read_plate
from heatlens.render.source.named import single_source, source_named
from heatlens.render.source.plate_source import _neighbours, black_plate, sequence_of_one_size
from support.exr_files import write_file
from support.plates import coc_plate_of, plate_of
from support.session_files import room_file

LENS = Lens(50.0, 2.0, 2.0, 36.0)
ALL = Shot(LENS, frames=FrameRange(1, 9))


def sequence_source(folder, *frames):
    for frame in frames:
        room_file(folder / f"shot.{frame:04}.exr", 8, 6)
    return source_named(str(folder / "shot.####.exr"))


class FakeRenderer:
    """A fake renderer that records the plates loaded into it."""

    def __init__(self):
        self.taken = []

    def load(self, plate):
        self.taken.append(plate)


def load_origins(source, origins):
    fake_renderer = FakeRenderer()
    loader = source.loader(ALL, origins, fake_renderer)
    try:
        for origin in origins:
            loader.load(origin)
    finally:
        loader.close()
    return fake_renderer.taken


def test_check_lists_missing_frames_unless_replaced(tmp_path):
    source = sequence_source(tmp_path, 1, 2, 5)
    source.check(ALL, (1, 2, 5), "stop")
    with pytest.raises(InputError) as error:
        source.check(ALL, (1, 2, 3, 4, 5), "stop")
    assert "2 of 5" in str(error.value) and "3-4" in str(error.value)
    assert "shot.####.exr" in str(error.value) and "--missing hold" in str(error.value)
    for missing in ("hold", "black"):
        source.check(ALL, (1, 2, 3, 4, 5), missing)


@pytest.mark.parametrize(
    ("frame", "missing", "read", "is_black"),
    [
        (2, "hold", 2, False),
        (2, "black", 2, False),
        (4, "hold", 2, False),
        (4, "black", 2, True),
        (9, "hold", 5, False),
        (1, "black", 2, True),
    ],
)
def test_origin_of_missing_frame_is_earlier_or_nearest_frame(
    tmp_path, frame, missing, read, is_black
):
    origin = sequence_source(tmp_path, 2, 5).origin(ALL, frame, missing)
    assert (origin.frame, origin.is_black) == (read, is_black)
    assert [file.path.name for file in origin.files] == [f"shot.{read:04}.exr"]


def test_still_has_every_frame_and_numbered_file_only_its_own(tmp_path):
    room_file(tmp_path / "still.exr", 8, 6)
    room_file(tmp_path / "alone.0007.exr", 8, 6)
    still, numbered = (source_named(str(tmp_path / n)) for n in ("still.exr", "alone.0007.exr"))
    still.check(ALL, (1, 2, 3), "stop")
    assert still.origin(ALL, 30, "black").is_black is False
    # One numbered file is a still until the shot has frames: then the others are missing.
    numbered.check(Shot(LENS), (1, 2), "stop")
    assert numbered.origin(Shot(LENS), 30, "black") == numbered.origin(ALL, 7, "stop")
    assert numbered.origin(ALL, 8, "black").is_black
    with pytest.raises(InputError, match="1 of 2"):
        numbered.check(ALL, (7, 8), "stop")


def test_frames_of_pattern_range_are_limited_to_frames_of_shot(tmp_path):
    everything = sequence_source(tmp_path, *range(1, 8))
    chosen = source_named(str(tmp_path / "shot.1-7x3####.exr"))
    played_shot = Shot(LENS, frames=FrameRange(2, 9))
    assert everything.frames_of(Shot(LENS)) == tuple(range(1, 8))
    assert everything.frames_of(played_shot) == tuple(range(2, 10))
    assert chosen.frames_of(Shot(LENS)) == (1, 4, 7)
    assert chosen.frames_of(played_shot) == (4, 7)


def test_loader_loads_unchanged_frame_once(tmp_path):
    source = sequence_source(tmp_path, 1, 2, 3, 4)
    origins = tuple(source.origin(ALL, frame, "hold") for frame in (1, 2, 2, 3, 4, 5))
    names = [plate.path.name for plate in load_origins(source, origins)]
    assert names == [f"shot.{frame:04}.exr" for frame in (1, 2, 3, 4)]


def test_loader_loads_black_frame_for_missing_one(tmp_path):
    source = sequence_source(tmp_path, 1, 3)
    origins = tuple(source.origin(ALL, frame, "black") for frame in (1, 2, 3))
    lights = [float(plate.color[..., :3].max()) for plate in load_origins(source, origins)]
    assert lights[1] == 0.0 < min(lights[0], lights[2])


def test_loader_error_names_missing_or_damaged_file(tmp_path):
    source = sequence_source(tmp_path, 1, 2, 3)
    origins = tuple(source.origin(ALL, frame, "stop") for frame in (1, 2, 3))
    (tmp_path / "shot.0001.exr").unlink()
    (tmp_path / "shot.0002.exr").write_bytes(b"no picture")
    for origin in origins[:2]:
        with pytest.raises(InputError, match=rf"shot\.000{origin.frame}\.exr"):
            load_origins(source, (origin,))


def test_loader_reads_two_plates_ahead_and_none_after_last(tmp_path, monkeypatch):
    requests = []
    source = sequence_source(tmp_path, 1, 2, 3, 4, 5)
    origins = tuple(source.origin(ALL, frame, "stop") for frame in range(1, 6))
    loader = source.loader(ALL, origins, FakeRenderer())
    wait = loader._cache.read_and_wait

    def noted(frame, window):
        requests.append((frame, window))
        return wait(frame, window=window)

    monkeypatch.setattr(loader._cache, "read_and_wait", noted)
    for origin in origins:
        loader.load(origin)
    loader.close()
    assert requests == [(1, 2), (2, 2), (3, 2), (4, 1), (5, 0)]
    assert threading.active_count() < 50


def test_black_plate_has_no_light_and_no_surface():
    color, depth = np.ones((4, 6, 3), np.float32), np.full((4, 6), 2.0, np.float32)
    opaque = black_plate(plate_of(color, depth))
    assert (opaque.color[..., :3] == 0).all() and (opaque.color[..., 3] == 1).all()
    assert np.isposinf(opaque.depth_m).all() and opaque.fragments is None and opaque.behind == ()
    clear = black_plate(replace(plate_of(color, depth), has_alpha=True))
    assert (clear.color == 0).all() and np.isposinf(clear.depth_m).all()
    sharp = black_plate(coc_plate_of(color, depth))
    assert (sharp.coc_px == 0).all() and sharp.depth_m is None and (sharp.color[..., 3] == 1).all()


def test_single_source_reads_its_one_file_when_loaded(tmp_path):
    sequence_source(tmp_path, 1, 2)
    alone = single_source(tmp_path / "shot.0002.exr", PlateOptions())
    assert alone.frames is None and alone.files == tmp_path / "shot.0002.exr"
    assert alone.frames_of(Shot(LENS)) == (1,) and not alone.has_many_views
    (plate,) = load_origins(alone, (alone.origin(Shot(LENS), 1, "stop"),))
    np.testing.assert_array_equal(plate.color, read_plate(tmp_path / "shot.0002.exr").color)
    assert single_source(tmp_path / "not_there.exr", PlateOptions()).text.endswith("not_there.exr")


def test_neighbours_are_next_frames_and_ends_of_sequence(tmp_path):
    found_sequence = sequence_source(tmp_path, 1, 3, 5, 7, 9).sequence
    assert _neighbours(found_sequence, 5) == {1, 3, 7, 9}
    assert _neighbours(found_sequence, 1) == {1, 3, 9}
    assert _neighbours(found_sequence, 9) == {1, 7, 9}
    assert _neighbours(found_sequence, None) == {1, 3, 9}


@pytest.mark.parametrize("other", [(9, 6), (8, 7)])
def test_sequence_of_one_size_excludes_next_frame_of_other_size(tmp_path, other):
    sequence_source(tmp_path, 1, 2)
    room_file(tmp_path / "shot.0003.exr", *other)
    assert sequence_of_one_size(str(tmp_path / "shot.0002.exr")).present == (2,)


def test_sequence_of_one_size_compares_display_windows(tmp_path):
    """Check frames with one display window, each cropped by its renderer to what changed."""
    grey = np.zeros((6, 8), np.float16)
    for frame, (x0, y0) in enumerate([(0, 0), (4, 2)], start=1):
        part = Box(x0, y0, 8, 6)
        channels = {name: grey[: part.height, : part.width].copy() for name in "RGBZ"}
        windows = {
            "dataWindow": (np.int32([x0, y0]), np.int32([7, 5])),
            "displayWindow": (np.int32([0, 0]), np.int32([7, 5])),
        }
        write_file(tmp_path / f"crop.{frame}.exr", channels, **windows)
    assert sequence_of_one_size(str(tmp_path / "crop.1.exr")).present == (1, 2)
