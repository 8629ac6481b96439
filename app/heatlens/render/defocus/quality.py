"""Define the cost of each quality: kernel, steps and number of layers."""

from dataclasses import dataclass, replace
from typing import assert_never

from heatlens.core.model.shot.settings import (
    LAYERS_MAX,
    PARTS,
    Bokeh,
    DefocusSettings,
    Method,
    Quality,
)
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.kernels import Kernel, gaussian_kernel, named_kernel, rim_kernel


@dataclass(frozen=True)
class _QualityCost:
    """The settings of a quality that decide its cost.

    disc            name of the kernel of a disc
    gaussian_steps  steps of the kernel of a Gaussian
    layers          largest number of depth layers
    parts           parts of the lens, where surfaces overlap; 1 for layers only
    """

    disc: str
    gaussian_steps: int
    layers: int
    parts: int = 1


# Qualities differ mainly in the poles of the disc. Light that varies inside the disc, and stray
# light outside it: 18 % and 18 % with two poles, 9 and 8 % with three, 6 and 6 % with four. A
# preview has as many layers as the film picture, which brings it closer to that.
def _cost_of(quality: Quality) -> _QualityCost:
    """Return the kernel, steps, layers and parts of a quality."""
    match quality:
        case Quality.DRAFT:
            return _QualityCost("disc_2", gaussian_steps=2, layers=4)
        case Quality.PREVIEW:
            return _QualityCost("disc_3", gaussian_steps=3, layers=LAYERS_MAX)
        case Quality.FILM:
            return _QualityCost("disc_4", gaussian_steps=5, layers=LAYERS_MAX)
        case Quality.FINAL:
            return replace(_cost_of(Quality.FILM), parts=PARTS[2])
        case _:
            assert_never(quality)


GUESSED_PARTS = PARTS[1]  # more of them cost much and gain little


def kernel_for(settings: DefocusSettings, rim: float = 0.0) -> Kernel:
    """Return the kernel of a bokeh at a quality; all kernels of a disc have the same variance.

    `rim` is the rim of discs on one side of the focus, see `Aperture`.
    """
    if settings.method is Method.HEAT:
        return named_kernel("heat")
    cost = _cost_of(settings.effective_quality)
    match settings.bokeh:
        case Bokeh.HEAT:
            return named_kernel("heat")
        case Bokeh.GAUSSIAN:
            return gaussian_kernel(cost.gaussian_steps)
        case Bokeh.DISC:
            return rim_kernel(cost.disc, rim)
        case _:
            assert_never(settings.bokeh)


def layers_for(settings: DefocusSettings) -> int:
    """Return the largest number of depth layers."""
    if settings.method is not Method.DIFFUSION:
        return 1
    return settings.layers or _cost_of(settings.effective_quality).layers


def parts_for(settings: DefocusSettings, is_guessed: bool = False) -> int:
    """Return into how many parts the lens is cut where surfaces of different blur overlap.

    A number above 1 in the settings overrides that of the quality. For surfaces that are only
    guessed, a quality uses fewer parts.
    """
    quality_parts = _cost_of(settings.effective_quality).parts
    used_parts = min(quality_parts, GUESSED_PARTS) if is_guessed else quality_parts
    return settings.parts if settings.parts > 1 else used_parts


def unused_behind_notes(plate: Plate, settings: DefocusSettings) -> tuple[str, ...]:
    """Return sentences if the method cannot use the surfaces behind a plate, or lacks them."""
    notes = []
    if plate.fragments is not None and layers_for(settings) == 1:
        notes.append(
            f"The method {settings.method} blurs in one layer and guesses what lies behind; only "
            "diffusion can take that from files."
        )
    if settings.parts > 1 and plate.has_alpha:
        notes.append(
            f"{settings.parts} parts of the lens change nothing: they need a picture without alpha."
        )
    return tuple(notes)
