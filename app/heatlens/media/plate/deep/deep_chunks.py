"""Read the samples of a deep EXR part from the bytes of the file, a few rows at a time.

OpenEXR for Python makes an object for every pixel, and OpenImageIO needs a call for every value:
for a frame in high definition that takes 3 GB of memory, or twice the time of all other work.
Source: OpenEXR, "File Layout" and "Interpreting OpenEXR Deep Pixels".
"""

import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file, unreadable_error
from heatlens.core.model.boxes import Box
from heatlens.media.plate.exr.exr_scan import (
    CutError,
    RawChannel,
    RawHeader,
    parse_channels,
    scan_headers,
)

SAMPLES_MOST = 100_000_000  # samples in a part
_BAND_SAMPLES = 1 << 19  # unpacked at once; a single row, or row of tiles, may have more
_BAND_MOST = 12_000_000  # samples in a row or row of tiles
_SMALLER_MOST = 1100  # greatest ratio of unpacked to packed bytes, measured on black deep pixels
_NONE, _RLE, _ZIPS = 0, 1, 2


@dataclass(frozen=True, eq=False)
class DeepBand:
    """The samples of some rows, pixel after pixel.

    first_row  counted from the top of the data window
    counts     (rows * W,) number of samples in each pixel
    values     (N,) float32 values of each channel, by the channel's number in the header
    """

    first_row: int
    counts: NDArray[np.int64]
    values: dict[int, NDArray[np.float32]]


@dataclass(frozen=True, eq=False)
class _Chunk:
    """A row or a tile: its position in the picture, and that of its samples in the file.

    counts  (h, w) number of samples in each pixel
    offset  bytes from the start of the file to the packed samples
    """

    x: int
    y: int
    counts: NDArray[np.int64]
    offset: int
    packed_bytes: int


class DeepPart:
    """One deep part of a file: `__init__` reads the sample counts, and `bands` the samples."""

    def __init__(self, path: Path, part: int) -> None:
        """Find the samples of part number `part`, and count those of each pixel.

        Raises InputError for a damaged file and for one with more than SAMPLES_MOST samples.
        """
        self._path = path
        try:
            with open_regular_file(path) as file:
                headers = scan_headers(file)
                self._read_header(headers[part])
                offsets = self._read_offsets(file, headers, part)
                self._chunks = self._read_chunks(file, offsets, len(headers) > 1)
        except OSError as error:
            raise unreadable_error(path, error) from error
        except (CutError, struct.error, zlib.error, LookupError) as error:
            raise self._damage_error(error) from error
        self._check_stored_once()

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the data window, pixels."""
        return self._window.height, self._window.width

    @property
    def channel_numbers(self) -> dict[str, int]:
        """The number of each channel by its name in the part."""
        return {channel.name.decode(): k for k, channel in enumerate(self._channels)}

    def bands(self, channels: Sequence[int]) -> Iterator[DeepBand]:
        """Yield the samples of all rows, band by band from top to bottom.

        `channels` holds the numbers of the channels to read, as in `channel_numbers`.

        Raises InputError for damaged samples.
        """
        with open_regular_file(self._path) as file:
            for chunks in self._group_chunks():
                try:
                    yield self._read_band(file, chunks, channels)
                except OSError as error:
                    raise unreadable_error(self._path, error) from error
                except (CutError, zlib.error) as error:
                    raise self._damage_error(error) from error

    # The headers

    def _read_header(self, header: RawHeader) -> None:
        """Store window, channels, tile size and compression. Raises CutError if that is unknown."""
        x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
        self._window = Box(x0, y0, x1 + 1, y1 + 1)
        self._channels: list[RawChannel] = parse_channels(header)
        self._sample_bytes = sum(channel.bytes_each for channel in self._channels)
        self._compression = header["compression"][0]
        self._tile: tuple[int, int] | None = None
        if header.get("type", b"").startswith(b"deeptile"):
            width, height, _mode = struct.unpack("<IIB", header["tiles"])
            self._tile = width, height
        if self._compression not in (_NONE, _RLE, _ZIPS):
            raise CutError(f"deep pixels cannot have compression number {self._compression}")

    # A header that claims more pixels than the file can hold is refused before their memory is
    # allocated: no deep compression shrinks even black pixels by more than _SMALLER_MOST, which was
    # measured.
    def _read_offsets(self, file: BinaryIO, headers: list[RawHeader], part: int) -> list[int]:
        """Return the offsets in the file, in bytes, at which the chunks of the part begin."""
        size = file.seek(0, 2)
        counts = [self._chunk_count(header) for header in headers]
        height, width = self.shape
        if sum(counts) * 8 > size or 4 * height * width > size * _SMALLER_MOST:
            raise CutError(f"its {size:,} bytes cannot hold what its header claims")
        file.seek(0)
        scan_headers(file)
        file.seek(8 * sum(counts[:part]), 1)
        stored = file.read(8 * counts[part])
        if len(stored) < 8 * counts[part]:
            raise CutError("the list of its chunks is cut off")
        return [int(offset) for offset in np.frombuffer(stored, "<u8") if 0 < offset < size]

    def _chunk_count(self, header: RawHeader) -> int:
        """Return the number of chunks of a part: as stored, or one for each row or tile."""
        if "chunkCount" in header:
            return int(struct.unpack("<I", header["chunkCount"])[0])
        height, width = self.shape
        if self._tile is None:
            return height
        return -(-height // self._tile[1]) * -(-width // self._tile[0])

    # The counts

    def _read_chunks(self, file: BinaryIO, offsets: list[int], has_parts: bool) -> list[_Chunk]:
        """Return the chunks at these offsets with their sample counts, from top left to bottom."""
        chunks, samples_left = [], SAMPLES_MOST
        most_possible = file.seek(0, 2) * _SMALLER_MOST // self._sample_bytes
        for offset in offsets:
            # In a file with several parts, the number of its part precedes a chunk in four bytes.
            file.seek(offset + (4 if has_parts else 0))
            box = self._read_chunk_box(file)
            if box is None:
                continue
            chunk = self._read_chunk(file, box)
            samples_left -= int(chunk.counts.sum())
            if samples_left < 0:
                self._raise_too_many()
            if SAMPLES_MOST - samples_left > most_possible:
                raise CutError(
                    f"it cannot hold the {SAMPLES_MOST - samples_left:,} samples that it claims"
                )
            chunks.append(chunk)
        return sorted(chunks, key=lambda chunk: (chunk.y, chunk.x))

    def _read_chunk_box(self, file: BinaryIO) -> Box | None:
        """Return the pixels of the chunk at the file's position; None for a smaller mipmap."""
        height, width = self.shape
        if self._tile is None:
            (row,) = struct.unpack("<i", file.read(4))
            box = Box(0, row - self._window.y0, width, row - self._window.y0 + 1)
        else:
            column, row, x_level, y_level = struct.unpack("<4i", file.read(16))
            if x_level or y_level:
                return None
            x, y = column * self._tile[0], row * self._tile[1]
            box = Box(x, y, min(x + self._tile[0], width), min(y + self._tile[1], height))
        if not (0 <= box.x0 < box.x1 and 0 <= box.y0 < box.y1 <= height):
            raise CutError("a chunk lies outside the picture")
        return box

    # The counts are read for the whole part before any samples: they are small, and decide how much
    # memory the picture takes. Each is stored as the sum of its row so far, so a value that
    # decreases along a row is damage.
    def _read_chunk(self, file: BinaryIO, box: Box) -> _Chunk:
        """Read the sample counts of the chunk at the file's position, whose pixels are `box`."""
        table_bytes, packed_bytes, data_bytes = struct.unpack("<3Q", file.read(24))
        size = 4 * box.width * box.height
        most = size if self._tile is None else 4 * self._tile[0] * self._tile[1]
        if table_bytes > max(most, size):
            raise CutError("a table of counts is longer than it can be")
        # A tile at the edge of the picture may have a table for all of its pixels, with the valid
        # ones at the beginning; packed data are always shorter.
        table = _unpack(file.read(min(table_bytes, size)), size, self._compression)
        file.seek(max(table_bytes - size, 0), 1)
        so_far = table.view("<i4").reshape(box.height, box.width).astype(np.int64)
        counts = np.diff(so_far, axis=1, prepend=0)
        if counts.min() < 0:
            raise CutError("a pixel has a negative number of samples")
        if counts.sum() > SAMPLES_MOST:
            self._raise_too_many()
        if counts.sum() * self._sample_bytes != data_bytes:
            raise CutError(
                f"the rows from {box.y0} on count {counts.sum():,} samples, but give their size "
                f"as {data_bytes:,} bytes"
            )
        if packed_bytes > data_bytes:
            raise CutError("packed samples are longer than unpacked ones")
        return _Chunk(box.x0, box.y0, counts, file.tell(), packed_bytes)

    def _check_stored_once(self) -> None:
        """Raise InputError for a part in which a pixel has no chunk, or two of them."""
        is_stored = np.zeros(self.shape, bool)
        for chunk in self._chunks:
            height, width = chunk.counts.shape
            area = is_stored[chunk.y : chunk.y + height, chunk.x : chunk.x + width]
            if area.any():
                raise self._damage_error("some pixels are stored twice")
            area[:] = True
        if not is_stored.all():
            missing = int((~is_stored.all(axis=1)).sum())
            raise self._damage_error(f"{missing} of its {len(is_stored)} rows are missing")

    # The samples

    def _group_chunks(self) -> Iterator[list[_Chunk]]:
        """Yield the chunks of one band at a time: whole rows, or whole rows of tiles."""
        band: list[_Chunk] = []
        band_samples = 0
        for chunk in self._chunks:
            if band and band_samples >= _BAND_SAMPLES and chunk.y != band[-1].y:
                yield band
                band, band_samples = [], 0
            band.append(chunk)
            band_samples += int(chunk.counts.sum())
        if band:
            yield band

    def _read_band(self, file: BinaryIO, chunks: list[_Chunk], channels: Sequence[int]) -> DeepBand:
        """Read the samples of the chunks of one band, in the order of their pixels."""
        count = sum(int(chunk.counts.sum()) for chunk in chunks)
        if count > _BAND_MOST:
            raise InputError(
                f"{self._path} holds {count:,} samples in the rows from {chunks[0].y} on; heatlens "
                f"takes {_BAND_MOST:,} at once. Write it as scan lines, or with smaller tiles."
            )
        first, last = chunks[0].y, chunks[-1].y + len(chunks[-1].counts)
        counts = np.empty((last - first, self.shape[1]), np.int64)
        row_pieces: list[list[tuple[NDArray[np.generic], ...]]] = [[] for _ in range(last - first)]
        for chunk in chunks:
            height, width = chunk.counts.shape
            counts[chunk.y - first : chunk.y - first + height, chunk.x : chunk.x + width] = (
                chunk.counts
            )
            for row, piece in enumerate(self._read_rows(file, chunk, channels), chunk.y - first):
                row_pieces[row].append(piece)
        pieces_in_order = [piece for row in row_pieces for piece in row]
        values = {
            channel: np.concatenate([piece[k] for piece in pieces_in_order]).astype(np.float32)
            for k, channel in enumerate(channels)
        }
        return DeepBand(first_row=first, counts=counts.ravel(), values=values)

    def _read_rows(
        self, file: BinaryIO, chunk: _Chunk, channels: Sequence[int]
    ) -> Iterator[tuple[NDArray[np.generic], ...]]:
        """Yield the samples of every row of a chunk, one array for each channel."""
        row_counts = chunk.counts.sum(axis=1)
        size = int(row_counts.sum()) * self._sample_bytes
        file.seek(chunk.offset)
        data = _unpack(file.read(chunk.packed_bytes), size, self._compression)
        channel_offsets = np.cumsum([0, *(channel.bytes_each for channel in self._channels)])
        row_start = 0
        for count in map(int, row_counts):
            yield tuple(
                np.frombuffer(
                    data,
                    self._channels[c].numpy_type,
                    count,
                    row_start + count * int(channel_offsets[c]),
                )
                for c in channels
            )
            row_start += count * self._sample_bytes

    # Refusals

    def _damage_error(self, reason: object) -> InputError:
        return InputError(f"{self._path} is damaged or cut short: {reason}. Write it again.")

    def _raise_too_many(self) -> None:
        """Raise InputError for a part with more than SAMPLES_MOST samples."""
        height, width = self.shape
        raise InputError(
            f"{self._path} holds more than {SAMPLES_MOST:,} samples, the most that heatlens "
            f"takes: about {SAMPLES_MOST // (height * width):,} a pixel. Merge samples where it is "
            "written, or write a smaller picture."
        )


def _unpack(packed: bytes, size: int, compression: int) -> NDArray[np.uint8]:
    """Return the `size` unpacked bytes; data that would not shrink is stored unpacked.

    Raises CutError if the data has another size.
    """
    if len(packed) == size:
        return np.frombuffer(packed, np.uint8)
    if compression == _RLE:
        unpacked = _decode_runs(packed, size)
    elif compression == _ZIPS:
        unpacked = zlib.decompressobj().decompress(packed, size + 1)
    else:
        unpacked = packed
    if len(unpacked) != size:
        raise CutError(f"{len(unpacked):,} bytes were found instead of {size:,}")
    return _undo_predictor(np.frombuffer(unpacked, np.uint8))


# EXR reorders bytes before zip and run lengths so that similar ones meet: even and odd bytes lie in
# two halves, and each byte is the difference to the one before it. The sums must stay bytes,
# because they wrap around as the writer's differences do.
def _undo_predictor(differences: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Undo the predictor of EXR: sum up differences, then interleave the two halves."""
    sums = np.cumsum(differences, dtype=np.uint8)
    sums[1::2] ^= 0x80  # each difference is stored with 128 added
    unpacked = np.empty_like(sums)
    half = (len(sums) + 1) // 2
    unpacked[0::2], unpacked[1::2] = sums[:half], sums[half:]
    return unpacked


def _decode_runs(packed: bytes, size: int) -> bytes:
    """Undo run-length coding.

    A count above 127 stands for a negative one: -count literal bytes follow. Any other count is
    followed by one byte that is repeated count + 1 times.
    """
    unpacked, at = bytearray(), 0
    while at + 1 < len(packed) and len(unpacked) <= size:
        count = packed[at]
        if count > 127:
            unpacked += packed[at + 1 : at + 257 - count]
            at += 257 - count
        else:
            unpacked += packed[at + 1 : at + 2] * (count + 1)
            at += 2
    return bytes(unpacked)
