"""Compare the deep samples that our own reader unpacks with those of the OpenEXR library."""

import struct

import numpy as np
import OpenEXR
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.plate.deep import deep_chunks
from heatlens.media.plate.deep.deep_chunks import DeepPart
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, tiled_header, window, write_file, write_parts

SIZE = (9, 13)  # tiles of 4 x 4 are cut at two edges
NAMES = ("A", "B", "G", "R", "Z", "ZBack")
DEEP = {"type": OpenEXR.deepscanline}
TILED = tiled_header() | {"type": OpenEXR.deeptile}


def random_deep_channels(seed=0, most=5):
    """Return pixels of 0 to `most` - 1 samples; even rows are random, odd rows compress well."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, most, SIZE)
    channels = {name: np.empty(SIZE, object) for name in NAMES}
    for at in np.ndindex(*SIZE):
        for name in NAMES:
            values = rng.random(counts[at]) if at[0] % 2 else np.full(counts[at], 0.5)
            channels[name][at] = values.astype(
                np.float16 if len(name) == 1 and name != "Z" else "<f4"
            )
    return channels


def write_deep_file(path, compression="NO", layout=DEEP, **header):
    kind = getattr(OpenEXR, f"{compression}_COMPRESSION")
    return write_file(path, random_deep_channels(), compression=kind, **layout, **header)


def assert_samples_equal(path, part, expected_channels):
    deep = DeepPart(path, part)
    bands = list(deep.bands([deep.channel_numbers[name] for name in NAMES]))
    lists = [expected_channels["Z"][at] for at in np.ndindex(*SIZE)]
    counts = np.concatenate([band.counts for band in bands])
    assert counts.tolist() == [len(values) for values in lists]
    for name in NAMES:
        found = np.concatenate([band.values[deep.channel_numbers[name]] for band in bands])
        expected = np.concatenate([expected_channels[name][at] for at in np.ndindex(*SIZE)])
        assert np.array_equal(found, expected.astype(np.float32)), name


@pytest.mark.parametrize("layout", [DEEP, TILED], ids=["scanlines", "tiles"])
@pytest.mark.parametrize("compression", ["NO", "RLE", "ZIPS"])
def test_deep_part_reads_same_samples_as_library(tmp_path, compression, layout, monkeypatch):
    monkeypatch.setattr(deep_chunks, "_BAND_SAMPLES", 40)  # several bands
    path = write_deep_file(
        tmp_path / "deep.exr", compression, layout, dataWindow=window(-3, 5, 10, 14)
    )
    stored = OpenEXR.File(str(path), separate_channels=True).parts[0].channels
    expected_channels = {name: stored[name].pixels for name in NAMES}
    for (
        values
    ) in expected_channels.values():  # the library gives nothing for a pixel without samples
        for at in np.ndindex(*SIZE):
            values[at] = np.empty(0, np.float32) if values[at] is None else values[at]
    assert_samples_equal(path, 0, expected_channels)


def test_deep_part_is_found_among_other_parts(tmp_path):
    deep = DEEP | {"name": "deep", "compression": OpenEXR.ZIPS_COMPRESSION}
    flat, deep_channels = rgb(*SIZE), random_deep_channels(7)
    path = write_parts(tmp_path / "parts.exr", ({"name": "flat"}, flat), (deep, deep_channels))
    assert_samples_equal(path, 1, deep_channels)


def test_deep_part_reads_samples_at_highest_compression(tmp_path):
    """ZIP packs at most 1032 to 1, and such a ratio is no sign of damage."""
    samples = np.empty((1, 1), object)
    samples[0, 0] = np.zeros(4_000_000, np.float32)
    header = DEEP | {"compression": OpenEXR.ZIPS_COMPRESSION}
    path = write_file(tmp_path / "black.exr", {"Z": samples}, **header)
    assert samples[0, 0].nbytes > 950 * path.stat().st_size
    deep = DeepPart(path, 0)
    (band,) = deep.bands([deep.channel_numbers["Z"]])
    values = band.values[deep.channel_numbers["Z"]]
    assert values.size == 4_000_000 and not values.any()


# Damage: the file is not compressed, and its chunks begin with y, three lengths, and the counts.


@pytest.fixture
def deep(tmp_path):
    return write_deep_file(tmp_path / "deep.exr")


def chunk_offsets_of(path):
    """Return the position of the chunk table in the file, and the offsets in it."""
    data = path.read_bytes()
    first = data.index(struct.pack("<i", 0) + struct.pack("<Q", 4 * SIZE[1]))
    table = first - 8 * SIZE[0]
    return table, struct.unpack_from(f"<{SIZE[0]}Q", data, table)


def write_patched(path, at, form, *values):
    data = bytearray(path.read_bytes())
    struct.pack_into(form, data, at, *values)
    path.write_bytes(data)
    return path


# Where fields of a chunk lie, in bytes: a head, a table of sample counts, the samples.
UNPACKED_SIZE_AT, TABLE_AT = 20, 28
LAST_COUNT_AT = TABLE_AT + 4 * (SIZE[1] - 1)
# Name: (bytes from the start of the chunk, form, values written there, words of the message).
DAMAGE = {
    "counts that sink": (TABLE_AT, "<2i", (5, 1), "negative number of samples"),
    "counts that are too high": (LAST_COUNT_AT, "<i", (900,), "count 900 samples"),
    "huge counts": (LAST_COUNT_AT, "<i", (2_000_000_000,), "more than 100,000,000 samples"),
    "a row outside": (0, "<i", (77,), "outside the picture"),
    "a row above": (0, "<i", (-1,), "outside the picture"),
    "a row just below": (0, "<i", (SIZE[0],), "outside the picture"),
    "a row twice": (0, "<i", (1,), "stored twice"),
    "a huge table": (4, "<Q", (1 << 60,), "table of counts is longer than it can be"),
    "huge samples": (12, "<Q", (1 << 60,), "longer than unpacked ones"),
    "too many bytes claimed": (UNPACKED_SIZE_AT, "<Q", (1 << 60,), "give their size"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_read_plate_reports_damaged_deep_chunk_in_one_line(deep, name):
    at, form, values, words = DAMAGE[name]
    _, (first_chunk, *_) = chunk_offsets_of(deep)
    with pytest.raises(InputError, match=words) as caught:
        read_plate(write_patched(deep, first_chunk + at, form, *values))
    assert "deep.exr" in str(caught.value) and len(str(caught.value).splitlines()) == 1


def test_deep_part_rejects_sample_count_that_its_chunk_cannot_hold(deep):
    """The chunk of about a hundred bytes claims two million samples; none of it is unpacked."""
    _, (first_chunk, *_) = chunk_offsets_of(deep)
    write_patched(deep, first_chunk + LAST_COUNT_AT, "<i", 2_000_000)
    bytes_per_sample = 4 * 2 + 2 * 4  # A, B, G, R are half floats; Z, ZBack floats
    write_patched(deep, first_chunk + UNPACKED_SIZE_AT, "<Q", 2_000_000 * bytes_per_sample)
    with pytest.raises(InputError, match="hold the 2,000,000"):
        DeepPart(deep, 0)


@pytest.mark.parametrize("chunk_offset", [0, 1 << 50])
def test_read_plate_reports_deep_rows_never_written(deep, chunk_offset):
    """A row that was never written has offset 0 in the table, or one beyond the end."""
    table, _ = chunk_offsets_of(deep)
    with pytest.raises(InputError, match="1 of its 9 rows"):
        read_plate(write_patched(deep, table + 8, "<Q", chunk_offset))


def test_read_plate_rejects_deep_header_larger_than_file(deep):
    data = deep.read_bytes()
    at = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    with pytest.raises(InputError, match="cannot hold what its header claims"):
        read_plate(write_patched(deep, at, "<4i", 0, 0, 16000, 16000))


def test_read_plate_rejects_too_many_deep_samples_naming_what_fits(deep, monkeypatch):
    monkeypatch.setattr(deep_chunks, "SAMPLES_MOST", 150)
    with pytest.raises(InputError, match=r"more than 150 samples.*: about 1 a pixel"):
        read_plate(deep)
    monkeypatch.setattr(deep_chunks, "SAMPLES_MOST", 10_000)
    monkeypatch.setattr(deep_chunks, "_BAND_MOST", 10)
    with pytest.raises(InputError, match=r"heatlens takes 10 at once.*smaller tiles"):
        read_plate(deep)
