"""Tolerances where the fixed functions of GPUs round more coarsely than a software rasteriser.

GPUs place vertices at 1/256 of a pixel and mix texels by weights of 8 bits; OpenGL 4.6 allows both
(sections 14.6.1 and 8.14.3). Figures of GPUs are those of an NVIDIA H200, rounded up.
"""

from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device


def within(ctx: Device, software: float, gpu: float) -> float:
    """Return the tolerance for this renderer."""
    return software if is_software(ctx) else gpu
