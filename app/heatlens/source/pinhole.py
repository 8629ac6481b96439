"""The pinhole picture on the GPU: a plate of a file or a stream, or a drawn scene."""

from dataclasses import dataclass

import moderngl

from heatlens.defocus.cutout_pass import CutoutTextures
from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.model.value_bins import ValueBins
from heatlens.plate.plate import Plate
from heatlens.scene_gpu.overscan import Overscan
from heatlens.scene_gpu.peel import Peeled


@dataclass(frozen=True, eq=False)
class Pinhole:
    """One frame without a lens, as the defocus passes read it.

    color  RGBA, premultiplied
    depth  metres, or the signed circle of confusion in pixels if the plate holds that
    bins   the distribution of its depths, see `Plate.bins`
    fragments  the known surfaces behind the picture; None if there are none
    overscan   of a scene: the same picture with a margin; plates have theirs in their data window
    peeled     of a scene: the known surfaces behind all of that; None for a hurried picture
    beyond     of a plate: the same with a margin that other frames showed, see `Plate.beyond`
    light_scale  the factor on `color` before the blur; the picture is divided by it
                 afterwards, and `fragments` and `cutout` are multiplied already
    cutout     of a plate: what a matte keeps from the blur
    """

    plate: Plate
    color: moderngl.Texture
    depth: moderngl.Texture
    bins: ValueBins
    fragments: FragmentBuffers | None = None
    overscan: Overscan | None = None
    peeled: Peeled | None = None
    light_scale: float = 1.0
    beyond: "Pinhole | None" = None
    cutout: CutoutTextures | None = None
