"""Kernels of the blur: rational functions of the line Laplacian (`disc_kernels.json`).

They are made by `fit_kernels.py`, which has their mathematics.

A kernel is poles kappa (J,) and mixing weights M (J, J), symmetric, sum Re M = 1:

    y = Re sum_ab M_ab (1 + kappa_b L_y)^-1 (1 + kappa_a L_x)^-1 x

with the conductances of L in pixels^2 of the disc's diameter. `heat` is the one implicit step of
Kass, Lefohn, Owens (2006); its kappa 1/32 gives it the variance d^2/16 of a disc of diameter d.
"""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

# With this one the radius at half height is within about 3 % of the disc's from d = 4 px on.
DISC_COMPACT = 0.1

_FILE = Path(__file__).with_name("disc_kernels.json")


@dataclass(frozen=True, eq=False)
class Kernel:
    """Poles (J,) and mixing weights (J, J), complex128; `steps` times one after the other.

    `compact` is c of the compact Laplacian L / (1 - c L), see shaders/lib/compact.lib.glsl; 0: L.
    """

    name: str
    poles: npt.NDArray[np.complex128]
    mix: npt.NDArray[np.complex128]
    steps: int = 1
    compact: float = 0.0

    @property
    def is_complex(self) -> bool:
        """False for heat and gaussian: they are solved in real arithmetic."""
        return bool(np.any(self.poles.imag) or np.any(self.mix.imag))


@cache
def named_kernel(name: str) -> Kernel:
    """Return the fitted kernel `heat`, `disc_2` ... Raises KeyError for an unknown name."""
    entry = json.loads(_FILE.read_text())["kernels"][name]
    compact = DISC_COMPACT if name.startswith("disc") else 0.0
    return Kernel(name, _complex(entry["kappa"]), _complex(entry["M"]), compact=compact)


@cache
def gaussian_kernel(steps: int) -> Kernel:
    """Return `steps` heat steps with the same variance in all, which tend to a round Gaussian."""
    heat = named_kernel("heat")
    return Kernel(f"gaussian_{steps}", heat.poles / steps, heat.mix, steps)


def _complex(pairs: object) -> npt.NDArray[np.complex128]:
    values = np.asarray(pairs, np.float64)
    return np.ascontiguousarray(values).view(np.complex128)[..., 0]
