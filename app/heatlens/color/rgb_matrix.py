"""Compute the matrix from any RGB primaries to linear Rec.709.

RGB to XYZ is derived as in SMPTE RP 177; white points are adapted by the Bradford transform, as in
the configs of OpenColorIO (Lam 1985; ICC.1:2022, annex E).
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from heatlens.plate.header.primaries import REC709, XYZ, Primaries

Matrix = npt.NDArray[np.floating[Any]]

_BRADFORD: Matrix = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)


def to_rec709(primaries: Primaries) -> Matrix:
    """Return M (3, 3) with linear Rec.709 = M light, for columns.

    White stays white; the D65 white of XYZ becomes white.
    """
    back: Matrix = np.linalg.inv(_to_xyz(REC709))
    if primaries == XYZ:
        return back
    matrix: Matrix = back @ _adapted(_white(primaries), _white(REC709)) @ _to_xyz(primaries)
    return matrix


def _to_xyz(primaries: Primaries) -> Matrix:
    """Return the XYZ of red, green and blue as columns, which sum to the white with Y = 1."""
    red, green, blue, _ = np.reshape(primaries.chromaticities, (4, 2))
    columns = np.stack([_xyz(*xy) for xy in (red, green, blue)], axis=1)
    matrix: Matrix = columns * np.linalg.solve(columns, _white(primaries))
    return matrix


def _white(primaries: Primaries) -> Matrix:
    x, y = primaries.chromaticities[6:]
    return _xyz(x, y) / y


def _xyz(x: float, y: float) -> Matrix:
    """Return XYZ with the sum 1, because blue of AP0 has almost no luminance."""
    return np.array([x, y, 1.0 - x - y])


def _adapted(white: Matrix, wanted: Matrix) -> Matrix:
    gain = (_BRADFORD @ wanted) / (_BRADFORD @ white)
    matrix: Matrix = np.linalg.inv(_BRADFORD) @ np.diag(gain) @ _BRADFORD
    return matrix
