"""Mixed silhouette pixels split into a near and a far fragment."""

import moderngl

from heatlens.defocus.plate_passes import tiles
from heatlens.gpu.program import ComputeProgram


class FragmentPass:
    """Colour and coc to far fragments (rgb, coverage of the near one) and near ones (rgb, coc)."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "fragments.comp.glsl")

    def run(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        at_infinity_px: float,
        out_far: moderngl.Texture,
        out_near: moderngl.Texture,
    ) -> None:
        """`at_infinity_px`: the coc of what is infinitely far away."""
        self._program.dispatch(
            tiles(color.size),
            textures={"color_tx": color, "coc_tx": coc},
            images={"out_far_img": out_far, "out_near_img": out_near},
            uniforms={"at_infinity_px": at_infinity_px},
        )
