"""Test frames that are damaged, rewritten, added or removed while they are read ahead."""

import os

import numpy as np
import pytest

from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.cache import Damaged, FrameCache
from heatlens.media.frame_cache.sequence_reader import SequenceReader
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.depth_files import PlateFiles
from heatlens.media.sequence.sequence_search import find_sequence
from support.exr_files import distances, rgb, write_file
from support.frame_caches import Reader, ReadyEvent, frames_in_state, wait_until_idle


def write_frame(path, value, size=(6, 8)):
    channels = {name: np.full(size, value, np.float16) for name in "RGB"}
    write_file(path, channels | {"Z": distances(*size)})


@pytest.fixture
def shot(tmp_path):
    """1001 to 1006: 1003 cut short, 1004 missing, 1005 larger than the others, 1006 no EXR."""
    for frame in (1001, 1002, 1003, 1005):
        path = tmp_path / f"shot.{frame}.exr"
        write_frame(path, frame - 1000, (12, 16) if frame == 1005 else (6, 8))
    cut = tmp_path / "shot.1003.exr"
    cut.write_bytes(cut.read_bytes()[:-40])
    (tmp_path / "shot.1006.exr").write_bytes(b"not yet")
    for path in tmp_path.iterdir():  # long ago, however coarse the clock of the file system is
        os.utime(path, ns=(10**18, 10**18))
    return tmp_path


def refresh_until(cache, news, predicate):
    """Refresh the cache from the disk until `predicate` is true, as a window does."""

    def look():
        cache.refresh()
        return predicate()

    news.wait_until(look)


def test_frame_cache_reads_good_and_damaged_files(shot):
    news = ReadyEvent()
    with FrameCache(
        find_sequence(shot), read_plate, budget_bytes=10**6, workers=2, on_ready=news
    ) as cache:
        cache.set_playhead(1001, direction=1, window=9)
        wait_until_idle(cache, news)
        assert list(cache.states().values()) == [
            *("ready", "ready", "damaged", "missing", "ready", "damaged")
        ]
        for frame in (1001, 1002, 1005):
            plate = cache.get(frame)
            assert (plate.color[:, :, :3] == frame - 1000).all()
            assert plate.path == cache.sequence.path_at(frame)
        assert cache.get(1005).color.shape == (12, 16, 4)
        assert "1003.exr is damaged or cut short" in cache.get(1003).sentence
        assert "not an OpenEXR file" in cache.get(1006).sentence
        assert cache.bytes_in_use == (2 * 6 * 8 + 12 * 16) * 20


def test_frame_cache_notices_rewritten_added_and_removed_frames(shot):
    news = ReadyEvent()
    with FrameCache(
        find_sequence(shot), read_plate, budget_bytes=10**6, workers=2, on_ready=news
    ) as cache:
        for frame in (1001, 1002, 1003, 1006):
            cache.read_and_wait(frame, direction=1, window=9)
        unchanged_plate = cache.get(1002)
        write_frame(shot / "shot.1001.exr", 11)
        write_frame(shot / "shot.1003.exr", 3)
        write_frame(shot / "shot.1004.exr", 4)
        write_frame(shot / "shot.1006.exr", 6)
        write_frame(shot / "shot.1008.exr", 8)
        (shot / "shot.1005.exr").unlink()
        values = {1001: 11, 1002: 2, 1003: 3, 1004: 4, 1006: 6, 1008: 8}
        refresh_until(cache, news, lambda: frames_in_state(cache.states(), "ready") == list(values))
        for frame, value in values.items():
            assert (cache.get(frame).color[:, :, :3] == value).all()
        assert cache.get(1002) is unchanged_plate
        assert frames_in_state(cache.states(), "missing") == [1005, 1007]
        assert cache.sequence.last == 1008


def test_frame_cache_retries_damaged_frame_only_after_change(shot):
    reads, news = [], ReadyEvent()

    def read(path):
        reads.append(path.name)
        return read_plate(path)

    with FrameCache(
        find_sequence(shot), read, budget_bytes=10**6, workers=2, on_ready=news
    ) as cache:
        cache.read_and_wait(1003, direction=1, window=0)
        os.utime(shot / "shot.1001.exr", ns=(1, 1))  # not held: no news
        (shot / "shot.1007.exr").touch()
        refresh_until(cache, news, lambda: cache.sequence.last == 1007)
        assert cache.states()[1003] == "damaged" and reads == ["shot.1003.exr"]
        os.utime(shot / "shot.1003.exr", ns=(1, 1))
        refresh_until(cache, news, lambda: len(reads) == 2)
        news.wait_until(lambda: cache.states()[1003] == "damaged")
    assert reads == ["shot.1003.exr"] * 2


def cache_with_depth_files(folder, depth_name, news):
    """Write three frames with a depth file each and return a cache that reads `depth_name`."""
    for frame in (1, 2, 3):
        write_file(folder / f"rgb.{frame:04}.exr", rgb())
        write_file(folder / f"depth.{frame:04}.exr", {"Z": distances()})
    depth = str(folder / depth_name)
    options = PlateOptions(depth_source=depth, depth_convention=DepthConvention.DISTANCE)
    return FrameCache(
        find_sequence(folder / "rgb.####.exr"),
        SequenceReader(options),
        budget_bytes=10**6,
        workers=2,
        on_ready=news,
        files_of=PlateFiles((depth,)),
    )


def read_frame(cache, frame):
    """Return the frame's plate or its damage, without reading ahead."""
    return cache.read_and_wait(frame, window=0)


def change_depth_of_frame_2(folder):
    path = folder / "depth.0002.exr"
    write_file(path, {"Z": 3 * distances()})
    os.utime(path, ns=(1, 1))


def test_frame_cache_rereads_only_the_frame_whose_depth_file_changes(tmp_path):
    news = ReadyEvent()
    with cache_with_depth_files(tmp_path, "depth.####.exr", news) as cache:
        first, second = read_frame(cache, 1), read_frame(cache, 2)
        change_depth_of_frame_2(tmp_path)
        refresh_until(cache, news, lambda: cache.get(2) is not second)
        np.testing.assert_allclose(read_frame(cache, 2).depth_m, 3 * second.depth_m)
        assert cache.get(1) is first


def test_frame_cache_reads_missing_depth_file_when_it_appears(tmp_path):
    news, path = ReadyEvent(), tmp_path / "depth.0003.exr"
    with cache_with_depth_files(tmp_path, "depth.####.exr", news) as cache:
        path.rename(tmp_path / "removed.exr")
        assert isinstance(read_frame(cache, 3), Damaged)
        (tmp_path / "removed.exr").rename(path)
        refresh_until(cache, news, lambda: not isinstance(cache.get(3), Damaged))
        assert not isinstance(read_frame(cache, 3), Damaged)


def test_frame_cache_rereads_every_frame_if_their_shared_depth_file_changes(tmp_path):
    news = ReadyEvent()
    with cache_with_depth_files(tmp_path, "depth.0002.exr", news) as cache:
        plates = [read_frame(cache, frame) for frame in (1, 2)]
        change_depth_of_frame_2(tmp_path)
        refresh_until(cache, news, lambda: cache.get(2) is not plates[1])
        for frame, before in zip((1, 2), plates, strict=True):
            np.testing.assert_allclose(read_frame(cache, frame).depth_m, 3 * before.depth_m)


def test_frame_cache_marks_file_removed_during_read_as_missing(shot):
    reader, news = Reader(), ReadyEvent()
    with FrameCache(
        find_sequence(shot), reader, budget_bytes=10**6, workers=2, on_ready=news
    ) as cache:
        reader.gate.clear()
        cache.set_playhead(1002, direction=1, window=0)
        news.wait_until(lambda: reader.begun)
        (shot / "shot.1002.exr").unlink()
        refresh_until(cache, news, lambda: not cache.sequence.has_file(1002))
        assert cache.states()[1002] == "reading"
        reader.gate.set()
        news.wait_until(lambda: cache.states()[1002] == "missing")
        assert cache.get(1002) is None and cache.bytes_in_use == 0


def test_frame_cache_keeps_frames_if_folder_cannot_be_listed(shot, tmp_path_factory):
    news = ReadyEvent()
    with FrameCache(
        find_sequence(shot), read_plate, budget_bytes=10**6, workers=2, on_ready=news
    ) as cache:
        cached_plate = cache.read_and_wait(1001, direction=1, window=0)
        moved_folder = shot.rename(tmp_path_factory.mktemp("away") / "shot")
        refresh_until(cache, news, lambda: cache.problem is not None)
        assert "cannot be listed" in cache.problem and cache.get(1001) is cached_plate
        moved_folder.rename(shot)
        refresh_until(cache, news, lambda: cache.problem is None)
        assert cache.get(1001) is cached_plate


def test_frame_cache_reads_still_as_sequence_of_one(tmp_path):
    write_file(tmp_path / "still.exr", rgb() | {"Z": distances()})
    with FrameCache(sequence=find_sequence(tmp_path), read=read_plate, budget_bytes=10**6) as cache:
        assert (
            cache.read_and_wait(cache.sequence.first, direction=-1, window=30).path
            == tmp_path / "still.exr"
        )
        assert list(cache.states().values()) == ["ready"]
