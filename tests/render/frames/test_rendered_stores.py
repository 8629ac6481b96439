"""Stores of rendered frames in memory and on disk: size limits, eviction and damaged files."""

import json
import os
import tempfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base import memory
from heatlens.core.model.boxes import Box
from heatlens.render.rendered_frames.cached_pictures import (
    _HEAD,
    CachedPicture,
    DiskStore,
    MemoryStore,
    RenderedPicture,
    decode_picture,
    default_memory_bytes,
    encode_picture,
    to_half,
)
from heatlens.render.rendered_frames.frame_store import FrameStore

WINDOWS = Box(-2, 3, 10, 9), Box(0, 0, 12, 8)


def key_of(number: int) -> str:
    return f"{number:032x}"


def picture_of(number: int, height: int = 4, width: int = 6) -> CachedPicture:
    """Return a picture whose pixels have the value `number`, so that each number is unique."""
    pixels = np.full((height, width, 4), number, np.float16)
    pixels[0, 0] = np.arange(4)
    return CachedPicture(pixels, *WINDOWS, pixel_aspect=1.25)


def are_equal_pictures(first: CachedPicture, second: CachedPicture) -> bool:
    headers = [(it.data_window, it.display_window, it.pixel_aspect) for it in (first, second)]
    return headers[0] == headers[1] and np.array_equal(first.pixels, second.pixels)


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
def test_memory_store_keeps_limit_and_returns_stored_pictures(limit, use):
    store, put = MemoryStore(limit), {}
    for action, number, size in use:
        if action == "put":
            put[number] = picture_of(number, *size)
            store.put(key_of(number), put[number])
            is_small = put[number].pixels.nbytes <= store.limit_bytes
            assert (store.get(key_of(number)) is put[number]) == is_small
        elif action == "get":
            assert store.get(key_of(number)) in (None, put.get(number))
        elif action == "resize":
            store.resize(number)
        else:
            store.clear()
            assert store.bytes_in_use == 0
        cached_pictures = [store.get(key) for key in store.keys()]
        assert store.bytes_in_use == sum(picture.pixels.nbytes for picture in cached_pictures)
        assert store.bytes_in_use <= store.limit_bytes


def test_memory_store_evicts_least_recently_used():
    store = MemoryStore(3 * picture_of(0).pixels.nbytes)
    for number in (1, 2, 3):
        store.put(key_of(number), picture_of(number))
    store.get(key_of(1))
    store.put(key_of(4), picture_of(4))
    assert store.keys() == {key_of(n) for n in (1, 3, 4)}


@settings(max_examples=30)
@given(st.integers(0, 6000), USE)
def test_disk_store_keeps_limit_and_returns_stored_pictures(limit, use):
    with tempfile.TemporaryDirectory() as folder:
        store, put = DiskStore(Path(folder) / "frames", limit), {}
        for action, number, size in use:
            if action == "put":
                put[number] = picture_of(number, *size)
                store.save(key_of(number), put[number])
            elif action == "get":
                found = store.load(key_of(number))
                assert found is None or are_equal_pictures(found, put[number])
            elif action == "resize":
                store.resize(number)
            else:
                store.clear()
            files = list(store.folder.iterdir()) if store.folder.exists() else []
            assert {path.stem for path in files} == store.keys()
            assert sum(path.stat().st_size for path in files) == store.bytes_in_use
            assert store.bytes_in_use <= store.limit_bytes


def test_disk_store_evicts_least_recently_used(tmp_path):
    file_bytes = len(encode_picture(picture_of(1), key_of(1)))
    store = DiskStore(tmp_path, 3 * file_bytes)
    for number in (1, 2, 3):
        store.save(key_of(number), picture_of(number))
        os.utime(tmp_path / f"{key_of(number)}.frame", (number, number))
    assert store.load(key_of(1)) is not None
    store.save(key_of(4), picture_of(4))
    assert store.keys() == {key_of(n) for n in (1, 3, 4)}


@given(st.data())
def test_decode_picture_returns_none_for_damaged_data(data):
    whole = encode_picture(picture_of(7), key_of(7))
    assert are_equal_pictures(decode_picture(whole, key_of(7)), picture_of(7))
    assert decode_picture(whole, key_of(8)) is None  # another file under this name
    cut = data.draw(st.integers(0, len(whole) - 1))
    assert decode_picture(whole[:cut], key_of(7)) is None
    bits = bytearray(whole)
    at = data.draw(st.integers(0, len(whole) - 1))
    bits[at] ^= data.draw(st.integers(1, 255))
    assert decode_picture(bytes(bits), key_of(7)) is None
    assert decode_picture(data.draw(st.binary(max_size=80)), key_of(7)) is None


@pytest.mark.parametrize("damage", [b"", b"no picture", None])
def test_disk_store_removes_damaged_file_on_load(tmp_path, damage):
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
def test_decode_picture_returns_none_for_invalid_header(facts):
    data = encode_picture(picture_of(7), key_of(7))
    magic, _, count = _HEAD.unpack_from(data)
    words, pixels = data[_HEAD.size :][:count], data[_HEAD.size + count :]
    words = json.dumps(json.loads(words) | facts).encode()
    check = zlib.crc32(pixels, zlib.crc32(words))
    assert decode_picture(_HEAD.pack(magic, check, len(words)) + words + pixels, key_of(7)) is None


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_decode_picture_returns_none_for_non_finite_pixels(value):
    picture = picture_of(7)
    picture.pixels[1, 1, 0] = value
    assert decode_picture(encode_picture(picture, key_of(7)), key_of(7)) is None


def test_disk_store_files_are_private_to_user(tmp_path):
    store = DiskStore(tmp_path / "cache" / "frames")
    store.save(key_of(1), picture_of(1))
    (path,) = store.folder.iterdir()
    assert (path.stat().st_mode & 0o777, store.folder.stat().st_mode & 0o777) == (0o600, 0o700)


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_disk_store_removes_pipe_or_device_unread(tmp_path, make):
    make(tmp_path / f"{key_of(1)}.frame")
    store = DiskStore(tmp_path)
    assert store.load(key_of(1)) is None and list(tmp_path.iterdir()) == []


def test_two_disk_stores_share_a_folder(tmp_path):
    first_store, second_store = DiskStore(tmp_path, 10**6), DiskStore(tmp_path, 10**6)
    first_store.save(key_of(1), picture_of(1))
    second_store.list_folder()
    assert are_equal_pictures(second_store.load(key_of(1)), picture_of(1))
    second_store.clear()
    assert first_store.load(key_of(1)) is None


def test_disk_store_keeps_foreign_files(tmp_path):
    other = tmp_path / "notes.txt"
    other.write_text("mine", "utf-8")
    store = DiskStore(tmp_path, 0)
    store.list_folder()
    store.clear()
    assert other.read_text("utf-8") == "mine"


def test_to_half_rounds_to_nearest_and_clamps_to_range():
    pixels = np.array([[[0.1, 1e9, -1e9, 1.0]]], np.float32)
    half = to_half(pixels)
    assert half[0, 0, 0] == np.float16(0.1)
    assert half[0, 0, 1:3].tolist() == [65504.0, -65504.0]


def rendered_picture_of(number: int) -> RenderedPicture:
    kept_picture = picture_of(number)
    return RenderedPicture(kept_picture.pixels.astype(np.float32), *WINDOWS, pixel_aspect=1.25)


def test_fetch_loads_evicted_picture_from_disk(tmp_path):
    store = FrameStore(MemoryStore(2 * picture_of(0).pixels.nbytes), DiskStore(tmp_path, 10**6))
    for number in (1, 2, 3):
        store.put(key_of(number), rendered_picture_of(number))
    store.wait()
    assert store.known_keys() == {key_of(n) for n in (1, 2, 3)}
    assert store.memory.get(key_of(1)) is None
    version = store.version
    store.fetch([key_of(1), key_of(9)])
    store.wait()
    assert (
        are_equal_pictures(store.memory.get(key_of(1)), picture_of(1)) and store.version > version
    )
    store.close()


def test_frame_store_finds_pictures_of_earlier_store(tmp_path):
    first = FrameStore(MemoryStore(10**6), DiskStore(tmp_path, 10**6))
    first.put(key_of(1), rendered_picture_of(1))
    first.close()
    second = FrameStore(MemoryStore(10**6), DiskStore(tmp_path, 10**6))
    second.wait()
    assert second.known_keys() == {key_of(1)}
    second.fetch([key_of(1)])
    second.wait()
    assert are_equal_pictures(second.memory.get(key_of(1)), picture_of(1))
    second.clear()
    second.wait()
    assert second.known_keys() == set() and list(tmp_path.iterdir()) == []
    second.close()


def test_frame_store_reports_unwritable_folder_and_uses_memory(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way", "utf-8")
    store = FrameStore(MemoryStore(10**6), DiskStore(blocked / "frames", 10**6))
    for number in (1, 2):
        store.put(key_of(number), rendered_picture_of(number))
    store.wait()
    assert store.known_keys() == {key_of(1), key_of(2)}
    assert str(blocked / "frames") in store.problem
    store.close()


def test_capacity_is_larger_of_memory_and_disk():
    picture_bytes = picture_of(0).pixels.nbytes
    memory = MemoryStore(3 * picture_bytes)
    assert FrameStore(memory).capacity(picture_bytes) == 3
    two_stores = FrameStore(memory, DiskStore(Path("unused"), 10 * (picture_bytes + 4096)))
    assert two_stores.capacity(picture_bytes) == 10


@pytest.mark.parametrize("failing", ["encode_picture", "as_kept"])
def test_frame_store_reports_memory_error_and_stays_usable(tmp_path, monkeypatch, failing):
    def no_memory(*_):
        raise MemoryError

    whose = "encode_picture" if failing == "encode_picture" else "RenderedPicture.as_kept"
    monkeypatch.setattr(f"heatlens.render.rendered_frames.cached_pictures.{whose}", no_memory)
    store = FrameStore(MemoryStore(10**6), DiskStore(tmp_path / "frames"))
    store.wait()
    for number in range(3):
        store.put(key_of(number), rendered_picture_of(number))
    store.wait()
    assert store.can_take_picture and not store.is_busy
    assert "not enough memory" in store.problem
    assert len(store.memory.keys()) == (3 if failing == "encode_picture" else 0)
    store.close()


def test_fetch_tries_unreadable_picture_once(tmp_path, monkeypatch):
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
    store.put(key_of(2), rendered_picture_of(2))
    store.wait()
    assert key_of(2) in disk.keys()  # writing goes on
    store.close()


def test_frame_store_accepts_pictures_if_listing_fails(tmp_path, monkeypatch, expects_faults):
    disk = DiskStore(tmp_path)
    monkeypatch.setattr(disk, "list_folder", lambda: {}["no such key"])
    store = FrameStore(MemoryStore(10**6), disk)
    store.wait()
    assert store.can_take_picture and "could not be listed" in store.problem
    store.close()


def test_default_memory_is_quarter_of_free_or_one_gib_if_unknown(tmp_path, monkeypatch):
    facts = tmp_path / "meminfo"
    monkeypatch.setattr(memory, "_MEMINFO", facts)
    for text, free_bytes in (("MemAvailable:  4096 kB\n", 4096 * 1024), ("MemFree: 1 kB\n", None)):
        facts.write_text(text)
        assert memory.free_memory_bytes() == free_bytes
        assert default_memory_bytes() == (1 << 30 if free_bytes is None else free_bytes // 4)
    facts.unlink()
    assert memory.free_memory_bytes() is None
