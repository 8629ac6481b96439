"""What each quality spends."""

from heatlens.defocus.kernels import Kernel, gaussian_kernel, named_kernel
from heatlens.model.settings import LAYERS_MAX, Bokeh, DefocusSettings, Method, Quality

_DISC = {Quality.DRAFT: "disc_2", Quality.PREVIEW: "disc_3", Quality.FILM: "disc_4"}
_GAUSSIAN_STEPS = {Quality.DRAFT: 2, Quality.PREVIEW: 3, Quality.FILM: 5}


def kernel_for(settings: DefocusSettings) -> Kernel:
    """The kernel of a bokeh at a quality; all have the same variance for the same disc."""
    if settings.method is Method.HEAT or settings.bokeh is Bokeh.HEAT:
        return named_kernel("heat")
    if settings.bokeh is Bokeh.GAUSSIAN:
        return gaussian_kernel(_GAUSSIAN_STEPS[settings.quality])
    return named_kernel(_DISC[settings.quality])


_LAYERS = {Quality.DRAFT: 3, Quality.PREVIEW: 4, Quality.FILM: LAYERS_MAX}


def layers_for(settings: DefocusSettings) -> int:
    """How many depth layers at most."""
    if settings.method is not Method.DIFFUSION:
        return 1
    return settings.layers or _LAYERS[settings.quality]
