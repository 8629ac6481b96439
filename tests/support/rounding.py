"""Tolerances for fixed functions of GPUs, which round more coarsely than a software rasterizer.

GPUs place vertices at 1/256 of a pixel and mix texels by weights of 8 bits; OpenGL 4.6 allows both
(sections 14.6.1 and 8.14.3). Figures of GPUs are those of an NVIDIA H200, rounded up.
"""

from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device


def tolerance_for(ctx: Device, software: float, gpu: float) -> float:
    """Return the tolerance for this renderer."""
    return software if is_software(ctx) else gpu
