"""What is in focus, taken from the plate, over a preview that was made smaller."""

import moderngl

from heatlens.defocus.optics import Optics
from heatlens.gpu.program import ComputeProgram, groups_for

_TILE = 16


class SharpPass:
    """The plate's own pixels where a small preview is softer than they are."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "sharp_over.comp.glsl")

    def run(
        self,
        plate: moderngl.Texture,
        depth: moderngl.Texture,
        optics: Optics,
        proxy: float,
        out: moderngl.Texture,
    ) -> None:
        """`plate` as the display shows it, to `out` with straight alpha; all of the plate's size.

        `optics` in full-size pixels, `proxy` the size of the preview against the plate.
        """
        line = optics.line
        self._program.dispatch(
            (groups_for(out.width, _TILE), groups_for(out.height, _TILE)),
            textures={"plate_tx": plate, "depth_tx": depth},
            images={"out_sharp_img": out},
            uniforms={
                "is_coc": line is None,
                "at_infinity_px": line.at_infinity_px if line else 0.0,
                "per_dioptre_px": line.per_dioptre_px if line else 0.0,
                "texel_px": 1.0 / proxy,
            },
        )
