"""Rendered frames in memory and on disk: within their bounds, and never a wrong picture."""

import json
import os
import tempfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base import free_memory
from heatlens.core.model.boxes import Box
from heatlens.render.rendered_frames.frame_store import FrameStore
from heatlens.render.rendered_frames.kept_pictures import (
    _HEAD,
    DiskStore,
    KeptPicture,
    MemoryStore,
    RenderedPicture,
    decoded,
    default_memory_bytes,
    encoded,
    half_of,
)

WINDOWS = Box(-2, 3, 10, 9), Box(0, 0, 12, 8)


def key_of(number: int) -> str:
    return f"{number:032x}"


def picture_of(number: int, height: int = 4, width: int = 6) -> KeptPicture:
    """Return a picture that is like no other."""
    pixels = np.full((height, width, 4), number, np.float16)
    pixels[0, 0] = np.arange(4)
    return KeptPicture(pixels, *WINDOWS, pixel_aspect=1.25)


def same(one: KeptPicture, other: KeptPicture) -> bool:
    rest = [(it.data_window, it.display_window, it.pixel_aspect) for it in (one, other)]
    return rest[0] == rest[1] and np.array_equal(one.pixels, other.pixels)


SIZES = st.tuples(st.integers(1, 9), st.integers(1, 9))
# Puts (key, size), asks (key), changes of the bound, and forgetting all.
USE = st.lists(
    st.one_of(
        st.tuples(st.just("put"), st.integers(0, 12), SIZES),
        st.tuples(st.just("get"), st.integers(0, 12), SIZES),
        st.tuples(st.just("resize"), st.integers(0, 4000), SIZES),
        st.tuples(st.just("clear"), st.just(0), SIZES),
    ),
    max_size=60,
)


@given(st.integers(0, 3000), USE)
def test_memory_stays_within_its_bound_and_gives_back_what_was_put(limit, use):
    store, put = MemoryStore(limit), {}
    for what, number, size in use:
        if what == "put":
            put[number] = picture_of(number, *size)
            store.put(key_of(number), put[number])
            is_small = put[number].pixels.nbytes <= store.limit_bytes
            assert (store.get(key_of(number)) is put[number]) == is_small
        elif what == "get":
            assert store.get(key_of(number)) in (None, put.get(number))
        elif what == "resize":
            store.resize(number)
        else:
            store.clear()
            assert store.bytes_in_use == 0
        held = [store.get(key) for key in store.keys()]
        assert store.bytes_in_use == sum(picture.pixels.nbytes for picture in held)
        assert store.bytes_in_use <= store.limit_bytes


def test_what_was_not_asked_for_longest_leaves_memory_first():
    store = MemoryStore(3 * picture_of(0).pixels.nbytes)
    for number in (1, 2, 3):
        store.put(key_of(number), picture_of(number))
    store.get(key_of(1))
    store.put(key_of(4), picture_of(4))
    assert store.keys() == {key_of(n) for n in (1, 3, 4)}


@settings(max_examples=30)
@given(st.integers(0, 6000), USE)
def test_the_folder_stays_within_its_bound_and_gives_back_what_was_put(limit, use):
    with tempfile.TemporaryDirectory() as folder:
        store, put = DiskStore(Path(folder) / "frames", limit), {}
        for what, number, size in use:
            if what == "put":
                put[number] = picture_of(number, *size)
                store.save(key_of(number), put[number])
            elif what == "get":
                found = store.load(key_of(number))
                assert found is None or same(found, put[number])
            elif what == "resize":
                store.resize(number)
            else:
                store.clear()
            files = list(store.folder.iterdir()) if store.folder.exists() else []
            assert {path.stem for path in files} == store.keys()
            assert sum(path.stat().st_size for path in files) == store.bytes_in_use
            assert store.bytes_in_use <= store.limit_bytes


def test_the_file_that_was_not_used_longest_goes_first(tmp_path):
    one = len(encoded(picture_of(1), key_of(1)))
    store = DiskStore(tmp_path, 3 * one)
    for number in (1, 2, 3):
        store.save(key_of(number), picture_of(number))
        os.utime(tmp_path / f"{key_of(number)}.frame", (number, number))
    assert store.load(key_of(1)) is not None
    store.save(key_of(4), picture_of(4))
    assert store.keys() == {key_of(n) for n in (1, 3, 4)}


@given(st.data())
def test_a_damaged_or_cut_file_is_none_at_all(data):
    whole = encoded(picture_of(7), key_of(7))
    assert same(decoded(whole, key_of(7)), picture_of(7))
    assert decoded(whole, key_of(8)) is None  # another file under this name
    cut = data.draw(st.integers(0, len(whole) - 1))
    assert decoded(whole[:cut], key_of(7)) is None
    bits = bytearray(whole)
    at = data.draw(st.integers(0, len(whole) - 1))
    bits[at] ^= data.draw(st.integers(1, 255))
    assert decoded(bytes(bits), key_of(7)) is None
    assert decoded(data.draw(st.binary(max_size=80)), key_of(7)) is None


@pytest.mark.parametrize("damage", [b"", b"no picture", None])
def test_a_damaged_file_is_a_miss_and_goes(tmp_path, damage):
    store = DiskStore(tmp_path, 10**6)
    store.save(key_of(1), picture_of(1))
    path = tmp_path / f"{key_of(1)}.frame"
    if damage is None:
        path.unlink()  # as another window does that needs the room
    else:
        path.write_bytes(damage)
    assert store.load(key_of(1)) is None
    assert store.keys() == set() and not path.exists()


NONSENSE = [
    *({"pixel_aspect": aspect} for aspect in (-1.0, 0.0, float("nan"), float("inf"), "wide")),
    *({"windows": [box, box]} for box in ([0, 0, 0, 4], [0, 0, 1 << 40, 4], ["a", "b", "c", "d"])),
    {"windows": [[0.5, 0.5, 4.5, 4.5]] * 2},
    {"windows": [[0, 0, 4]] * 2},
    {"windows": []},
    {"size": [-3, -4]},
]


@pytest.mark.parametrize("facts", NONSENSE, ids=str)
def test_an_intact_file_with_nonsense_in_it_is_none_at_all(facts):
    data = encoded(picture_of(7), key_of(7))
    magic, _, count = _HEAD.unpack_from(data)
    words, pixels = data[_HEAD.size :][:count], data[_HEAD.size + count :]
    words = json.dumps(json.loads(words) | facts).encode()
    check = zlib.crc32(pixels, zlib.crc32(words))
    assert decoded(_HEAD.pack(magic, check, len(words)) + words + pixels, key_of(7)) is None


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_kept_picture_has_only_numbers(value):
    picture = picture_of(7)
    picture.pixels[1, 1, 0] = value
    assert decoded(encoded(picture, key_of(7)), key_of(7)) is None


def test_what_is_kept_of_confidential_shots_is_for_the_user_alone(tmp_path):
    store = DiskStore(tmp_path / "cache" / "frames")
    store.save(key_of(1), picture_of(1))
    (path,) = store.folder.iterdir()
    assert (path.stat().st_mode & 0o777, store.folder.stat().st_mode & 0o777) == (0o600, 0o700)


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_a_pipe_or_device_among_the_frames_is_not_read(tmp_path, make):
    make(tmp_path / f"{key_of(1)}.frame")
    store = DiskStore(tmp_path)
    assert store.load(key_of(1)) is None and list(tmp_path.iterdir()) == []


def test_two_windows_share_a_folder(tmp_path):
    one, two = DiskStore(tmp_path, 10**6), DiskStore(tmp_path, 10**6)
    one.save(key_of(1), picture_of(1))
    two.look()
    assert same(two.load(key_of(1)), picture_of(1))
    two.clear()
    assert one.load(key_of(1)) is None


def test_files_of_others_in_the_folder_stay(tmp_path):
    other = tmp_path / "notes.txt"
    other.write_text("mine", "utf-8")
    store = DiskStore(tmp_path, 0)
    store.look()
    store.clear()
    assert other.read_text("utf-8") == "mine"


def test_half_floats_are_the_nearest_and_what_they_cannot_reach_is_the_most_they_can():
    pixels = np.array([[[0.1, 1e9, -1e9, 1.0]]], np.float32)
    half = half_of(pixels)
    assert half[0, 0, 0] == np.float16(0.1)
    assert half[0, 0, 1:3].tolist() == [65504.0, -65504.0]


def rendered(number: int) -> RenderedPicture:
    kept = picture_of(number)
    return RenderedPicture(kept.pixels.astype(np.float32), *WINDOWS, pixel_aspect=1.25)


def test_what_memory_gave_up_comes_back_from_disk(tmp_path):
    store = FrameStore(MemoryStore(2 * picture_of(0).pixels.nbytes), DiskStore(tmp_path, 10**6))
    for number in (1, 2, 3):
        store.put(key_of(number), rendered(number))
    store.wait()
    assert store.known() == {key_of(n) for n in (1, 2, 3)}
    assert store.memory.get(key_of(1)) is None
    version = store.version
    store.fetch([key_of(1), key_of(9)])
    store.wait()
    assert same(store.memory.get(key_of(1)), picture_of(1)) and store.version > version
    store.close()


def test_frames_of_the_window_before_are_there(tmp_path):
    first = FrameStore(MemoryStore(10**6), DiskStore(tmp_path, 10**6))
    first.put(key_of(1), rendered(1))
    first.close()
    second = FrameStore(MemoryStore(10**6), DiskStore(tmp_path, 10**6))
    second.wait()
    assert second.known() == {key_of(1)}
    second.fetch([key_of(1)])
    second.wait()
    assert same(second.memory.get(key_of(1)), picture_of(1))
    second.clear()
    second.wait()
    assert second.known() == set() and list(tmp_path.iterdir()) == []
    second.close()


def test_a_folder_that_cannot_be_written_is_said_once_and_memory_goes_on(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way", "utf-8")
    store = FrameStore(MemoryStore(10**6), DiskStore(blocked / "frames", 10**6))
    for number in (1, 2):
        store.put(key_of(number), rendered(number))
    store.wait()
    assert store.known() == {key_of(1), key_of(2)}
    assert str(blocked / "frames") in store.problem
    store.close()


def test_capacity_is_that_of_the_larger_one():
    one = picture_of(0).pixels.nbytes
    memory = MemoryStore(3 * one)
    assert FrameStore(memory).capacity(one) == 3
    both = FrameStore(memory, DiskStore(Path("unused"), 10 * (one + 4096)))
    assert both.capacity(one) == 10


@pytest.mark.parametrize("failing", ["encoded", "kept"])
def test_pictures_that_cannot_be_kept_leave_room_for_others_and_a_sentence(
    tmp_path, monkeypatch, failing
):
    def no_memory(*_):
        raise MemoryError

    whose = "encoded" if failing == "encoded" else "RenderedPicture.kept"
    monkeypatch.setattr(f"heatlens.render.rendered_frames.kept_pictures.{whose}", no_memory)
    store = FrameStore(MemoryStore(10**6), DiskStore(tmp_path / "frames"))
    store.wait()
    for number in range(3):
        store.put(key_of(number), rendered(number))
    store.wait()
    assert store.has_room and not store.is_busy
    assert "not enough memory" in store.problem
    assert len(store.memory.keys()) == (3 if failing == "encoded" else 0)
    store.close()


def test_a_picture_that_cannot_be_read_is_asked_for_once(tmp_path, monkeypatch):
    disk, reads = DiskStore(tmp_path), []
    disk.save(key_of(1), picture_of(1))

    def no_memory(*_):
        reads.append(1)
        raise MemoryError

    monkeypatch.setattr(disk, "load", no_memory)
    store = FrameStore(MemoryStore(10**6), disk)
    for _ in range(3):
        store.fetch([key_of(1)])
        store.wait()
    assert reads == [1] and not store.is_busy and "could not be read" in store.problem
    store.put(key_of(2), rendered(2))
    store.wait()
    assert key_of(2) in disk.keys()  # writing goes on
    store.close()


def test_a_folder_that_cannot_be_listed_bars_nothing(tmp_path, monkeypatch, expects_faults):
    disk = DiskStore(tmp_path)
    monkeypatch.setattr(disk, "look", lambda: {}["no such key"])
    store = FrameStore(MemoryStore(10**6), disk)
    store.wait()
    assert store.has_room and "could not be listed" in store.problem
    store.close()


def test_a_quarter_of_the_free_memory_is_taken_and_a_fixed_part_where_it_is_unknown(
    tmp_path, monkeypatch
):
    facts = tmp_path / "meminfo"
    monkeypatch.setattr(free_memory, "_FACTS", facts)
    for text, free_bytes in (("MemAvailable:  4096 kB\n", 4096 * 1024), ("MemFree: 1 kB\n", None)):
        facts.write_text(text)
        assert free_memory.free_memory_bytes() == free_bytes
        assert default_memory_bytes() == (1 << 30 if free_bytes is None else free_bytes // 4)
    facts.unlink()
    assert free_memory.free_memory_bytes() is None
