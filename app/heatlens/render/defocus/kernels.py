"""Kernels of the blur: rational functions of the line Laplacian.

They are fitted by `fit_kernels.py` (`kernel_error.py` has the mathematics) and stored in
`disc_kernels.json` and, for discs with a bright or a soft rim, in `rim_kernels.json`.

A kernel has J poles kappa (J,) and symmetric mixing weights M (J, J) with sum Re M = 1. It turns a
picture x into the blurred picture y:

    y = Re sum_ab M_ab (1 + kappa_b L_y)^-1 (1 + kappa_a L_x)^-1 x

L_x and L_y are the Laplacians along rows and columns. Their conductances are the squared diameters
of the discs, in pixels^2. `heat` is the one implicit step of Kass, Lefohn, Owens (2006); its kappa
1/32 gives it the variance d^2/16 of a disc of diameter d.
"""

import json
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

# The constant c of the compact Laplacian of discs. With this value, the radius at half height is
# within 3 % of the disc's from a diameter of 4 px on.
DISC_COMPACT = 0.1

# The rims for which there are kernels; kernels of other rims are mixed from the two nearest.
RIMS = tuple(step / 4 for step in range(-4, 5))

_FILE = Path(__file__).with_name("disc_kernels.json")
_RIM_FILE = Path(__file__).with_name("rim_kernels.json")


@dataclass(frozen=True, eq=False)
class Kernel:
    """A kernel of the blur; without complex numbers for heat and Gaussian.

    poles    kappa (J,), complex128
    mix      mixing weights M (J, J), complex128
    steps    how many times the kernel is applied, one after the other
    compact  c of the compact Laplacian L / (1 - c L), see shaders/lib/compact.lib.glsl; 0 for L
    """

    name: str
    poles: npt.NDArray[np.complex128]
    mix: npt.NDArray[np.complex128]
    steps: int = 1
    compact: float = 0.0

    @cached_property
    def is_complex(self) -> bool:
        """False for heat and gaussian: they are solved in real arithmetic."""
        return bool(np.any(self.poles.imag) or np.any(self.mix.imag))


@cache
def named_kernel(name: str) -> Kernel:
    """Return the fitted kernel `heat`, `disc_2` ... Raises KeyError for an unknown name."""
    entry = json.loads(_FILE.read_text(encoding="utf-8"))["kernels"][name]
    compact = DISC_COMPACT if name.startswith("disc") else 0.0
    return Kernel(name, _to_complex(entry["kappa"]), _to_complex(entry["M"]), compact=compact)


@lru_cache(maxsize=64)
def rim_kernel(name: str, rim: float) -> Kernel:
    """Return the kernel of a disc with a rim from -1, soft, to 1, bright; 0 is the flat disc's.

    Like all kernels it has the variance of a flat disc: a disc with a bright rim is smaller, and
    one with a soft rim larger. It has as many poles as the flat disc, and so a rim costs nothing.
    Raises KeyError for a kernel that is not a disc.
    """
    flat, kernels = named_kernel(name), _rim_kernels()[name]
    if rim == 0.0:
        return flat
    step = min(max((rim - RIMS[0]) / (RIMS[1] - RIMS[0]), 0.0), len(RIMS) - 1.0)
    low = min(int(step), len(RIMS) - 2)
    (poles_low, mix_low), (poles_high, mix_high) = kernels[low], kernels[low + 1]
    fraction = step - low
    poles = (1 - fraction) * poles_low + fraction * poles_high
    mix = (1 - fraction) * mix_low + fraction * mix_high
    variance = 2 * (mix.sum(axis=1) @ poles).real  # of a disc of diameter 1; made 1/16 below
    return replace(flat, name=f"{name}_rim", poles=poles / (16 * variance), mix=mix)


@cache
def _rim_kernels() -> dict[str, list[tuple[npt.NDArray[np.complex128], ...]]]:
    """Return poles and mixing weights for each of `RIMS`, by the names of the flat discs."""
    rims: dict[str, list[tuple[npt.NDArray[np.complex128], ...]]] = {}
    for entry in json.loads(_RIM_FILE.read_text(encoding="utf-8"))["kernels"]:
        rims.setdefault(entry["name"], []).append(
            (_to_complex(entry["kappa"]), _to_complex(entry["M"]))
        )
    return rims


@cache
def gaussian_kernel(steps: int) -> Kernel:
    """Return `steps` heat steps with the same variance in all, which tend to a round Gaussian."""
    heat = named_kernel("heat")
    return Kernel(f"gaussian_{steps}", heat.poles / steps, heat.mix, steps)


def _to_complex(pairs: object) -> npt.NDArray[np.complex128]:
    """Return pairs of real and imaginary parts as complex numbers."""
    values = np.asarray(pairs, np.float64)
    return np.ascontiguousarray(values).view(np.complex128)[..., 0]
