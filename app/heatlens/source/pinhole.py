"""The pinhole picture on the GPU: a plate of a file or a stream, or a drawn scene."""

from dataclasses import dataclass

import moderngl
import numpy as np
import numpy.typing as npt

from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.model.value_bins import ValueBins, bins_of
from heatlens.plate.plate import Plate
from heatlens.scene_gpu.overscan import Overscan
from heatlens.scene_gpu.peel import Peeled


@dataclass(frozen=True, eq=False)
class Pinhole:
    """One frame without a lens, as the defocus passes read it.

    color  RGBA, premultiplied
    depth  metres, or the signed circle of confusion in pixels if the plate holds that
    bins   the distribution of its depths, see `bins_of_plate`
    fragments  what is known behind the picture; None where nothing is
    overscan   of a scene: the same picture with a margin; plates have theirs in their data window
    peeled     of a scene: what is known behind all of that; None for a hurried picture
    light_scale  what `color` is multiplied by before it is blurred, and the picture divided by
                 afterwards; `fragments` are multiplied already
    """

    plate: Plate
    color: moderngl.Texture
    depth: moderngl.Texture
    bins: ValueBins
    fragments: FragmentBuffers | None = None
    overscan: Overscan | None = None
    peeled: Peeled | None = None
    light_scale: float = 1.0

    @property
    def occupied(self) -> npt.NDArray[np.float64]:
        """Return the ends of the bins that hold a surface, ascending."""
        return self.bins.occupied


def bins_of_plate(plate: Plate) -> ValueBins:
    """Return the distribution of the plate's surfaces, including those behind it.

    The bins are in dioptres, or in pixels if the plate holds circles of confusion.
    """
    if plate.coc_px is not None:
        return bins_of(plate.coc_px)
    assert plate.depth_m is not None
    dioptres = np.float32(1.0) / plate.depth_m
    if plate.fragments is not None:
        dioptres = np.concatenate([dioptres.ravel(), plate.fragments.dioptres])
    return bins_of(dioptres)
