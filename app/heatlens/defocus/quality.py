"""What each quality spends."""

from dataclasses import dataclass
from typing import assert_never

from heatlens.defocus.kernels import Kernel, gaussian_kernel, named_kernel, rim_kernel
from heatlens.model.settings import LAYERS_MAX, Bokeh, DefocusSettings, Method, Quality


@dataclass(frozen=True)
class _Spent:
    """The cost of a quality: the disc's kernel, steps of a Gaussian, depth layers at most."""

    disc: str
    gaussian_steps: int
    layers: int


def _spent(quality: Quality) -> _Spent:
    match quality:
        case Quality.DRAFT:
            return _Spent("disc_2", gaussian_steps=2, layers=3)
        case Quality.PREVIEW:
            return _Spent("disc_3", gaussian_steps=3, layers=4)
        case Quality.FILM:
            return _Spent("disc_4", gaussian_steps=5, layers=LAYERS_MAX)
        case _:
            assert_never(quality)


def kernel_for(settings: DefocusSettings, rim: float = 0.0) -> Kernel:
    """Return the kernel of a bokeh at a quality; all have the same variance for the same disc.

    `rim` is that of discs on one side of the focus, as `Aperture` has it for those behind.
    """
    if settings.method is Method.HEAT:
        return named_kernel("heat")
    spent = _spent(settings.quality)
    match settings.bokeh:
        case Bokeh.HEAT:
            return named_kernel("heat")
        case Bokeh.GAUSSIAN:
            return gaussian_kernel(spent.gaussian_steps)
        case Bokeh.DISC:
            return rim_kernel(spent.disc, rim)
        case _:
            assert_never(settings.bokeh)


def layers_for(settings: DefocusSettings) -> int:
    """Return how many depth layers there are at most."""
    if settings.method is not Method.DIFFUSION:
        return 1
    return settings.layers or _spent(settings.quality).layers
