"""Damage to files, the same for the same seed: bytes, numbers, words and lines of them."""

import random
import re
import struct

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_MOST_DIGITS = 4300  # of the numbers that Python reads or writes
_DEEP = 20_000  # more brackets than a parser can follow, in less than a datagram
_PADDING = re.compile(rb"#+|%0?\d*d")
_TYPE = re.compile(rb"(?<=\0)(?:float|string|v2f|v2i|v3f|m44f|rational|timecode|chlist)(?=\0)")
_EXTREMES = (
    *(b"0", b"-1", b"1", b"2", b"1e-30", b"1e30", b"3.4e38", b"1e308", b"1e999", b"-1e30", b"nan"),
    *(b"inf", b"65535", b"2147483647", b"4294967295", b"9007199254740993", b"", b"1.5", b"null"),
    *(b"[]", b"{}", b'"x"', b"true", b"9" * 40, b"9" * (_MOST_DIGITS + 1)),
    *(b"[" * _DEEP, b"[" * _DEEP + b"]" * _DEEP, b'{"a":' * 1000),
)
_WORDS = tuple(
    struct.pack("<i", value)
    for value in (0, 1, -1, 2, 255, 256, 65535, 65536, 2**24, 2**31 - 1, -(2**31), 0x7F800000)
)


def mutated(data: bytes, chance: random.Random) -> bytes:
    """Return `data` with one to four kinds of damage."""
    for _ in range(chance.choice((1, 1, 1, 2, 3, 4))):
        data = chance.choice(_KINDS)(data, chance)
    return data


def _bit(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    flipped = bytes(value ^ (1 << chance.randrange(8)) for value in data[at : at + 1])
    return data[:at] + flipped + data[at + 1 :]


def _byte(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    return data[:at] + bytes([chance.randrange(256)]) + data[at + 1 :]


def _word(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    return data[:at] + chance.choice(_WORDS) + data[at + 4 :]


def _cut(data: bytes, chance: random.Random) -> bytes:
    return data[: _place(data, chance)]


def _gone(data: bytes, chance: random.Random) -> bytes:
    at = _place(data, chance)
    return data[:at] + data[at + chance.choice((1, 1, 2, 4, 16, 100)) :]


def _twice(data: bytes, chance: random.Random) -> bytes:
    at, length = _place(data, chance), chance.choice((1, 4, 16, 100, 400))
    return data[:at] + data[at : at + length] + data[at:]


def _number(data: bytes, chance: random.Random) -> bytes:
    """Replace a number of a text by an extreme one, or by no number at all."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return _word(data, chance)
    one = chance.choice(found)
    return data[: one.start()] + chance.choice(_EXTREMES) + data[one.end() :]


def _width(data: bytes, chance: random.Random) -> bytes:
    """Give the number of a frame in a name another width, up to one of billions of digits."""
    found = list(_PADDING.finditer(data))
    if not found:
        return _number(data, chance)
    one, digits = chance.choice(found), chance.choice((0, 1, 9, 20, 21, 2**31, 4 * 10**9, 10**30))
    return data[: one.start()] + b"%%%dd" % digits + data[one.end() :]


def _type(data: bytes, chance: random.Random) -> bytes:
    """Give an attribute of an EXR header a type that no program knows, nor UTF-8."""
    found = list(_TYPE.finditer(data))
    if not found:
        return _byte(data, chance)
    one = chance.choice(found)
    return data[: one.start()] + chance.randbytes(len(one[0])) + data[one.end() :]


def _line(data: bytes, chance: random.Random) -> bytes:
    """Remove a line, cut it, or put it in the place of another."""
    lines = data.split(b"\n")
    at, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    kept = lines[at][: chance.randrange(len(lines[at]) + 1)]
    lines[at] = chance.choice((b"", kept, lines[other]))
    return b"\n".join(lines)


def _place(data: bytes, chance: random.Random) -> int:
    """Choose a place, often near the beginning, where headers are."""
    most = max(len(data) - 1, 0)
    return chance.randint(0, min(most, 600) if chance.random() < 0.6 else most)


_KINDS = (
    _bit,
    _byte,
    _byte,
    _word,
    _word,
    _cut,
    _gone,
    _twice,
    _number,
    _number,
    _line,
    _width,
    _type,
)
