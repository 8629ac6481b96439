"""Damage files in their bytes, numbers, words and lines, reproducibly for each seed."""

import random
import re
import struct

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_MOST_DIGITS = 4300  # of the numbers that Python reads or writes
_BRACKET_DEPTH = 20_000  # more brackets than a parser can follow, in less than a datagram
_PADDING = re.compile(rb"#+|%0?\d*d")
_TYPE = re.compile(rb"(?<=\0)(?:float|string|v2f|v2i|v3f|m44f|rational|timecode|chlist)(?=\0)")
_EXTREMES = (
    *(b"0", b"-1", b"1", b"2", b"1e-30", b"1e30", b"3.4e38", b"1e308", b"1e999", b"-1e30", b"nan"),
    *(b"inf", b"65535", b"2147483647", b"4294967295", b"9007199254740993", b"", b"1.5", b"null"),
    *(b"[]", b"{}", b'"x"', b"true", b"9" * 40, b"9" * (_MOST_DIGITS + 1)),
    *(b"[" * _BRACKET_DEPTH, b"[" * _BRACKET_DEPTH + b"]" * _BRACKET_DEPTH, b'{"a":' * 1000),
)
_WORDS = tuple(
    struct.pack("<i", value)
    for value in (0, 1, -1, 2, 255, 256, 65535, 65536, 2**24, 2**31 - 1, -(2**31), 0x7F800000)
)


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Return `data` with one to four kinds of damage."""
    for _ in range(rng.choice((1, 1, 1, 2, 3, 4))):
        data = rng.choice(_KINDS)(data, rng)
    return data


def _flip_bit(data: bytes, rng: random.Random) -> bytes:
    offset = _random_offset(data, rng)
    flipped = bytes(value ^ (1 << rng.randrange(8)) for value in data[offset : offset + 1])
    return data[:offset] + flipped + data[offset + 1 :]


def _replace_byte(data: bytes, rng: random.Random) -> bytes:
    offset = _random_offset(data, rng)
    return data[:offset] + bytes([rng.randrange(256)]) + data[offset + 1 :]


def _replace_word(data: bytes, rng: random.Random) -> bytes:
    offset = _random_offset(data, rng)
    return data[:offset] + rng.choice(_WORDS) + data[offset + 4 :]


def _truncate(data: bytes, rng: random.Random) -> bytes:
    return data[: _random_offset(data, rng)]


def _delete_bytes(data: bytes, rng: random.Random) -> bytes:
    offset = _random_offset(data, rng)
    return data[:offset] + data[offset + rng.choice((1, 1, 2, 4, 16, 100)) :]


def _repeat_bytes(data: bytes, rng: random.Random) -> bytes:
    offset, length = _random_offset(data, rng), rng.choice((1, 4, 16, 100, 400))
    return data[:offset] + data[offset : offset + length] + data[offset:]


def _replace_number(data: bytes, rng: random.Random) -> bytes:
    """Replace a number in a text by an extreme number or by other text."""
    matches = list(_NUMBER.finditer(data))
    if not matches:
        return _replace_word(data, rng)
    match = rng.choice(matches)
    return data[: match.start()] + rng.choice(_EXTREMES) + data[match.end() :]


def _replace_padding(data: bytes, rng: random.Random) -> bytes:
    """Replace the padding of a frame number in a file name by one of 0 to billions of digits."""
    matches = list(_PADDING.finditer(data))
    if not matches:
        return _replace_number(data, rng)
    match = rng.choice(matches)
    digits = rng.choice((0, 1, 9, 20, 21, 2**31, 4 * 10**9, 10**30))
    return data[: match.start()] + b"%%%dd" % digits + data[match.end() :]


def _replace_attribute_type(data: bytes, rng: random.Random) -> bytes:
    """Replace the type of an EXR header attribute by random bytes, which need not be UTF-8."""
    matches = list(_TYPE.finditer(data))
    if not matches:
        return _replace_byte(data, rng)
    match = rng.choice(matches)
    return data[: match.start()] + rng.randbytes(len(match[0])) + data[match.end() :]


def _damage_line(data: bytes, rng: random.Random) -> bytes:
    """Remove a line, truncate it, or replace it by another line."""
    lines = data.split(b"\n")
    index, other_index = rng.randrange(len(lines)), rng.randrange(len(lines))
    cut_line = lines[index][: rng.randrange(len(lines[index]) + 1)]
    lines[index] = rng.choice((b"", cut_line, lines[other_index]))
    return b"\n".join(lines)


def _random_offset(data: bytes, rng: random.Random) -> int:
    """Return a random offset into `data`, often near the beginning, where headers are."""
    most = max(len(data) - 1, 0)
    return rng.randint(0, min(most, 600) if rng.random() < 0.6 else most)


_KINDS = (
    _flip_bit,
    _replace_byte,
    _replace_byte,
    _replace_word,
    _replace_word,
    _truncate,
    _delete_bytes,
    _repeat_bytes,
    _replace_number,
    _replace_number,
    _damage_line,
    _replace_padding,
    _replace_attribute_type,
)
