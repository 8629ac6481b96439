"""Points of a lens and of a pixel, spread so evenly that few of them are enough.

Sobol's sequence in four dimensions, the first two for the lens, scrambled as Owen 1995 does by the
hash of Laine and Karras 2011 with the constants of Burley 2020. Any stretch of it that starts
where the one before it stopped goes on filling the gaps.
"""

import numpy as np
from numpy.typing import NDArray

from heatlens.model.pupil import Pupil

Array = NDArray[np.float64]
Words = NDArray[np.uint32]

_BITS = 32
# Joe and Kuo 2008, new-joe-kuo-6.21201: coefficients of the polynomial and first odd numbers, for
# each dimension after the first, which is van der Corput's.
_POLYNOMIALS = (((), (1,)), ((1,), (1, 3)), ((0, 1), (1, 3, 1)))
_FACTORS = (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6)


def lens_samples(
    count_from: int, count_to: int, pupil: Pupil, seed: int = 0
) -> tuple[Array, Array]:
    """Return the offsets and jitters, (n, 2) each, of samples `count_from` to `count_to` - 1.

    Offsets are uniform over `pupil`, in metres, jitters over the pixel, [-0.5, 0.5). Equal numbers
    and an equal seed, 0 to 2^32 - 1, give equal points.
    """
    points = _sobol(np.arange(count_from, count_to, dtype=np.uint32), seed)
    return pupil.points_m(points[:, :2]), points[:, 2:] - 0.5


def _sobol(numbers: Words, seed: int) -> Array:
    """Return (n, 4) scrambled points in [0, 1)."""
    words = np.stack([_digits(numbers, column) for column in _DIRECTIONS], axis=-1)
    salts = _mixed(np.arange(1, 5, dtype=np.uint32) ^ _mixed(np.array([seed], np.uint32)))
    return np.asarray(_scrambled(words, salts) / 2.0**_BITS)


def _directions() -> Words:
    """Return (4, 32) words: what each bit of a number flips in each dimension."""
    first = [1 << (_BITS - 1 - bit) for bit in range(_BITS)]
    rows = [first, *(_direction_row(*polynomial) for polynomial in _POLYNOMIALS)]
    return np.array(rows, np.uint32)


def _direction_row(inner: tuple[int, ...], start: tuple[int, ...]) -> list[int]:
    """Return the recurrence of Bratley and Fox 1988 for one primitive polynomial."""
    degree = len(start)
    row = [number << (_BITS - 1 - bit) for bit, number in enumerate(start)]
    for bit in range(degree, _BITS):
        word = row[bit - degree] ^ (row[bit - degree] >> degree)
        for back, coefficient in enumerate(inner, start=1):
            word ^= coefficient * row[bit - back]
        row.append(word)
    return row


_DIRECTIONS = _directions()


def _digits(numbers: Words, directions: Words) -> Words:
    """Return the points of one dimension as fractions of 2^32."""
    words = np.zeros_like(numbers)
    for bit, direction in enumerate(directions):
        words ^= (numbers >> np.uint32(bit) & np.uint32(1)) * direction
    return words


def _scrambled(words: Words, salts: Words) -> Words:
    """Flip each bit by a hash of the bits above it, which keeps a net a net."""
    hashed = _reversed(words) + salts
    for factor in _FACTORS:
        hashed ^= hashed * np.uint32(factor)
    return _reversed(hashed)


def _reversed(words: Words) -> Words:
    """Return the words with their bits in reverse order."""
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        step, low = np.uint32(shift), np.uint32(mask)
        words = ((words >> step) & low) | ((words & low) << step)
    return (words >> np.uint32(16)) | (words << np.uint32(16))


def _mixed(words: Words) -> Words:
    """Hash neighbouring numbers to unlike ones by the finaliser of MurmurHash3."""
    words = (words ^ (words >> np.uint32(16))) * np.uint32(0x85EBCA6B)
    words = (words ^ (words >> np.uint32(13))) * np.uint32(0xC2B2AE35)
    return words ^ (words >> np.uint32(16))
