"""Sharpen a small picture before it is drawn enlarged, to compensate for bilinear filtering."""

import moderngl

from heatlens.gpu.program import ComputeProgram, pixel_groups


class EnlargePass:
    """Compensates in advance for the softness of bilinear enlargement."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "enlarge_ready.comp.glsl")

    def run(self, picture: moderngl.Texture, out: moderngl.Texture) -> None:
        """Write `picture`, display values, to `out` of the same size, RGBA of 8 bits."""
        self._program.dispatch(
            pixel_groups(out.size),
            textures={"picture_tx": picture},
            images={"out_img": out},
        )
