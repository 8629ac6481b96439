"""Average the part of a plate that is in focus, at the size of a preview."""

import moderngl

from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.model.focus.coc import NO_LINE, CocLine


class FocusMeanPass:
    """Averages the pixels in focus under each pixel of a preview."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._program = ComputeProgram(ctx, "focus_mean.comp.glsl")

    def run(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        line: CocLine | None,
        mean: moderngl.Texture,
        out: moderngl.Texture,
    ) -> None:
        """Write the mean of the focused part of `color` to `out`.

        `depth` holds metres, or signed coc in pixels if `line` is None. `mean` holds the mean of
        all of `color`, and has the size of `out`.
        """
        self._program.dispatch(
            pixel_groups(out.size),
            textures={"color_tx": color, "depth_tx": depth, "mean_tx": mean},
            images={"out_img": out},
            uniforms=focus_uniforms(line, depth.width / out.width),
        )


def focus_uniforms(line: CocLine | None, texel_px: float) -> dict[str, object]:
    """Return the uniforms of lib/focus_share.lib.glsl."""
    return {
        "is_coc": line is None,
        **(line or NO_LINE).uniforms,
        "texel_px": texel_px,
    }
