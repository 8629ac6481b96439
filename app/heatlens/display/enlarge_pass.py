"""A small picture made ready to be drawn large without more softness than it must have."""

import moderngl

from heatlens.gpu.program import ComputeProgram, groups_for

_TILE = 16


class EnlargePass:
    """Adds beforehand what bilinear enlarging takes away."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "enlarge_ready.comp.glsl")

    def run(self, picture: moderngl.Texture, out: moderngl.Texture) -> None:
        """Write `picture`, display values, to `out` of the same size, RGBA of 8 bits."""
        self._program.dispatch(
            (groups_for(out.width, _TILE), groups_for(out.height, _TILE)),
            textures={"picture_tx": picture},
            images={"out_img": out},
        )
