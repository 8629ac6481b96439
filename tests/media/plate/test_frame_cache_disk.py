"""Frames that are damaged, written again, come or go while they are read ahead."""

import os

import numpy as np
import pytest

from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.cache import Damaged, FrameCache
from heatlens.media.frame_cache.sequence_reader import SequenceReader
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.depth_files import PlateFiles
from heatlens.media.sequence.sequence import find_sequence
from support.exr_files import distances, rgb, write_file
from support.frame_caches import News, Reader, at_rest, names


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


def refreshed(cache, news, predicate):
    """Look at the disk until `predicate`; each look is asked for again, as a window does."""

    def look():
        cache.refresh()
        return predicate()

    news.wait_until(look)


def test_real_frames_good_and_bad(shot):
    news = News()
    with FrameCache(find_sequence(shot), read_plate, 10**6, 2, news) as cache:
        cache.want(1001, 1, 9)
        at_rest(cache, news)
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


def test_frames_that_are_written_again_come_or_go_are_noticed(shot):
    news = News()
    with FrameCache(find_sequence(shot), read_plate, 10**6, 2, news) as cache:
        for frame in (1001, 1002, 1003, 1006):
            cache.wait(frame, 1, 9)
        before = cache.get(1002)
        write_frame(shot / "shot.1001.exr", 11)
        write_frame(shot / "shot.1003.exr", 3)
        write_frame(shot / "shot.1004.exr", 4)
        write_frame(shot / "shot.1006.exr", 6)
        write_frame(shot / "shot.1008.exr", 8)
        (shot / "shot.1005.exr").unlink()
        values = {1001: 11, 1002: 2, 1003: 3, 1004: 4, 1006: 6, 1008: 8}
        refreshed(cache, news, lambda: names(cache.states(), "ready") == list(values))
        for frame, value in values.items():
            assert (cache.get(frame).color[:, :, :3] == value).all()
        assert cache.get(1002) is before
        assert names(cache.states(), "missing") == [1005, 1007]
        assert cache.sequence.last == 1008


def test_a_damaged_frame_is_tried_again_only_when_its_file_changes(shot):
    reads, news = [], News()

    def read(path):
        reads.append(path.name)
        return read_plate(path)

    with FrameCache(find_sequence(shot), read, 10**6, 2, news) as cache:
        cache.wait(1003, 1, 0)
        os.utime(shot / "shot.1001.exr", ns=(1, 1))  # not held: no news
        (shot / "shot.1007.exr").touch()
        refreshed(cache, news, lambda: cache.sequence.last == 1007)
        assert cache.states()[1003] == "damaged" and reads == ["shot.1003.exr"]
        os.utime(shot / "shot.1003.exr", ns=(1, 1))
        refreshed(cache, news, lambda: len(reads) == 2)
        news.wait_until(lambda: cache.states()[1003] == "damaged")
    assert reads == ["shot.1003.exr"] * 2


@pytest.mark.parametrize("is_pattern", [True, False])
def test_a_depth_file_apart_that_was_written_again_is_read_again(tmp_path, is_pattern):
    """Also one that was missing; what has its depth in another file, which stays, is kept."""
    for frame in (1, 2, 3):
        write_file(tmp_path / f"rgb.{frame:04}.exr", rgb())
        write_file(tmp_path / f"depth.{frame:04}.exr", {"Z": distances()})
    depth = tmp_path / ("depth.####.exr" if is_pattern else "depth.0002.exr")
    options = PlateOptions(depth_source=str(depth), depth_convention=DepthConvention.DISTANCE)
    (tmp_path / "depth.0003.exr").rename(tmp_path / "kept.exr")
    sequence, news = find_sequence(tmp_path / "rgb.####.exr"), News()
    read, files_of = SequenceReader(options), PlateFiles((str(depth),))
    with FrameCache(sequence, read, 10**6, 2, news, files_of=files_of) as cache:
        first, second = cache.wait(1, 1, 0), cache.wait(2, 1, 0)
        assert isinstance(cache.wait(3, 1, 0), Damaged) is is_pattern
        write_file(tmp_path / "depth.0002.exr", {"Z": 3 * distances()})
        os.utime(tmp_path / "depth.0002.exr", ns=(1, 1))
        (tmp_path / "kept.exr").rename(tmp_path / "depth.0003.exr")
        refreshed(cache, news, lambda: cache.get(2) is not second)
        np.testing.assert_allclose(cache.wait(2, 1, 0).depth_m, 3 * second.depth_m)
        assert (cache.get(1) is first) is is_pattern
        assert not isinstance(cache.wait(3, 1, 0), Damaged)


def test_a_file_that_goes_while_it_is_read_is_missing(shot):
    reader, news = Reader(), News()
    with FrameCache(find_sequence(shot), reader, 10**6, 2, news) as cache:
        reader.gate.clear()
        cache.want(1002, 1, 0)
        news.wait_until(lambda: reader.begun)
        (shot / "shot.1002.exr").unlink()
        refreshed(cache, news, lambda: not cache.sequence.has(1002))
        assert cache.states()[1002] == "reading"
        reader.gate.set()
        news.wait_until(lambda: cache.states()[1002] == "missing")
        assert cache.get(1002) is None and cache.bytes_in_use == 0


def test_a_folder_that_cannot_be_looked_into_takes_nothing_away(shot, tmp_path_factory):
    news = News()
    with FrameCache(find_sequence(shot), read_plate, 10**6, 2, news) as cache:
        before = cache.wait(1001, 1, 0)
        elsewhere = shot.rename(tmp_path_factory.mktemp("away") / "shot")
        refreshed(cache, news, lambda: cache.problem is not None)
        assert "cannot be listed" in cache.problem and cache.get(1001) is before
        elsewhere.rename(shot)
        refreshed(cache, news, lambda: cache.problem is None)
        assert cache.get(1001) is before


def test_a_still_is_a_sequence_like_any_other(tmp_path):
    write_file(tmp_path / "still.exr", rgb() | {"Z": distances()})
    with FrameCache(find_sequence(tmp_path), read_plate, 10**6) as cache:
        assert cache.wait(cache.sequence.first, -1, 30).path == tmp_path / "still.exr"
        assert list(cache.states().values()) == ["ready"]
