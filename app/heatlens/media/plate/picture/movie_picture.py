"""Describe frames of movies as pictures: their values, colors, frame rate and timecode."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.model.timecode import try_parse_timecode
from heatlens.media.files.movie_read import Movie, MovieFrame, movie_at
from heatlens.media.plate.header.primaries import P3_D65, REC2020
from heatlens.media.plate.plate import FloatImage

Curve = Callable[[FloatImage], FloatImage]

# The numbers of primaries and curves are those of ITU-T H.273, tables 2 and 3.
_PRIMARIES = {9: REC2020, 12: P3_D65}
_LINEAR, _PQ, _HLG = 8, 16, 18
_PQ_WHITE_NITS = 203.0  # diffuse white of PQ: ITU-R BT.2408, table 1
_HLG_WHITE = 0.75  # signal of diffuse white in HLG, by the same table


def read_movie_values(path: Path, number: int) -> tuple[NDArray[Any], float, dict[str, Any]]:
    """Return the stored values of a frame, the value of white, and facts about the movie.

    Raises InputError that names the file if it cannot be decoded.
    """
    movie = movie_at(path)
    frame = movie.frame(number)
    return frame.values, frame.white, _movie_facts(path, movie, frame, number)


def read_movie_info(path: Path, number: int) -> tuple[tuple[int, int], dict[str, Any]]:
    """Return (width, height) of a frame, and facts about the movie."""
    values, _, info = read_movie_values(path, number)
    return (values.shape[1], values.shape[0]), info


def _movie_facts(path: Path, movie: Movie, frame: MovieFrame, number: int) -> dict[str, Any]:
    """Return facts about a movie and its frame: header entries, a note, the curve of its light."""
    header: dict[str, object] = {"pixelAspectRatio": np.float32(movie.pixel_aspect)}
    primaries = _PRIMARIES.get(frame.primaries)
    if primaries is not None:
        header["chromaticities"] = primaries.chromaticities
    start = try_parse_timecode(movie.timecode)
    if movie.rate is not None:
        header["framesPerSecond"] = movie.rate
        if start is not None and start.fits(float(movie.rate)):
            header["timecode"] = str(start.add_frames(number, float(movie.rate)))
    curve, words = _curve_of(frame.transfer)
    return {
        "header": header,
        "comment": movie.comment,
        "note": f"{path}: {_describe_movie(movie, frame)}.",
        "curve": curve,
        "curve_words": words,
        "bits": frame.bits,
        "is_light": curve is not None,
    }


def _describe_movie(movie: Movie, frame: MovieFrame) -> str:
    """Return a phrase with the frame count, frame rate, codec, bits and timecode of a movie."""
    rate = "" if movie.rate is None else f" at {float(movie.rate):.5g} a second"
    uneven_words = "" if movie.is_even else " on average, which are taken in order"
    timecode = f", timecode {movie.timecode}" if movie.timecode else ""
    plural_ending = "" if movie.count == 1 else "s"
    return (
        f"{movie.count} frame{plural_ending}{rate}{uneven_words}, {movie.codec}, {frame.bits} "
        f"bits{timecode}"
    )


def _curve_of(transfer: int) -> tuple[Curve | None, str]:
    """Return the function from signals of 0 to 1 to light, and a phrase; (None, "") for sRGB.

    `transfer` is the number of the curve in the tags of the movie.
    """
    curves: dict[int, tuple[Curve, str]] = {
        _LINEAR: (lambda signal: signal, "tagged as linear light"),
        _PQ: (_pq_light, "tagged as PQ, of which 203 nits become 1"),
        _HLG: (_hlg_light, "tagged as HLG, of which a signal of 75 % becomes 1"),
    }
    return curves.get(transfer, (None, ""))


def _pq_light(signal: FloatImage) -> FloatImage:
    """Return light of a PQ signal. Source: SMPTE ST 2084, equation 4.1."""
    m1, m2 = 2610 / 16384, 2523 / 4096 * 128
    c1, c2, c3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
    root = np.clip(signal, 0.0, 1.0).astype(np.float64) ** (1 / m2)
    nits = 10_000 * (np.maximum(root - c1, 0.0) / (c2 - c3 * root)) ** (1 / m1)
    light: FloatImage = (nits / _PQ_WHITE_NITS).astype(np.float32)
    return light


def _hlg_light(signal: FloatImage) -> FloatImage:
    """Return scene light of an HLG signal. Source: ITU-R BT.2100, table 5."""
    light: FloatImage = (
        _hlg_inverse_curve(signal) / _hlg_inverse_curve(np.float32(_HLG_WHITE))
    ).astype(np.float32)
    return light


def _hlg_inverse_curve(signal: ArrayLike) -> NDArray[np.float64]:
    """Return the scene light of an HLG signal, without the scale of diffuse white."""
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    values = np.clip(np.asarray(signal, np.float64), 0.0, None)
    return np.where(values <= 0.5, values**2 / 3, (np.exp((values - c) / a) + b) / 12)
