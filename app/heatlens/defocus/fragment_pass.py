"""Mixed silhouette pixels split into a near and a far fragment."""

import moderngl

from heatlens.defocus.pixel_list import clear_list
from heatlens.defocus.plate_passes import tiles
from heatlens.gpu.program import ComputeProgram


class FragmentPass:
    """Colour and coc to far fragments (rgb, coverage of the near one) and near ones (rgb, coc)."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._find = ComputeProgram(ctx, "fragments_find.comp.glsl")
        self._split = ComputeProgram(ctx, "fragments_split.comp.glsl")

    def run(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        at_infinity_px: float,
        rim: moderngl.Texture,
        pixels: moderngl.Buffer,
        out_far: moderngl.Texture,
        out_near: moderngl.Texture,
    ) -> None:
        """`at_infinity_px`: coc of what is infinitely far; `rim` (one channel), `pixels`: scratch."""
        clear_list(pixels)
        textures = {"color_tx": color, "coc_tx": coc, "rim_tx": rim}
        images = {"out_far_img": out_far, "out_near_img": out_near, "out_rim_img": rim}
        uniforms = {"at_infinity_px": at_infinity_px}
        self._find.dispatch(
            tiles(color.size),
            textures=textures,
            images=images,
            buffers={0: pixels},
            uniforms=uniforms,
        )
        self._split.dispatch_indirect(
            pixels, textures=textures, images=images, buffers={0: pixels}, uniforms=uniforms
        )
