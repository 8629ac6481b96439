"""Draw the overlays, and focus peaking."""

from heatlens.core.model.focus.coc import NO_LINE
from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.core.model.view.guides import USUAL_PEAKING, Peaking, PeakingOn
from heatlens.core.model.view.overlays import overlay_of
from heatlens.render.defocus.optics import Optics
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Texture


class OverlayPass:
    """Converts depth to colors with alpha over the picture; programs are built on first use."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._program = ComputeProgram(ctx, "display/overlay.comp.glsl")

    def run(
        self,
        overlay: str,
        depth: Texture,
        optics: Optics,
        sharp_px: float,
        layer_limits_px: tuple[float, ...],
        out: Texture,
        color: Texture | None = None,
        peaking: Peaking | None = None,
    ) -> None:
        """Write the overlay of this name, straight alpha, to `out`: RGBA8, as large as `depth`.

        `depth` is meters, or coc in pixels if `optics.line` is None. A coc up to `sharp_px` counts
        as in focus; `layer_limits_px` are the signed diameters between the layers. `peaking` is
        drawn over the overlay; its edges come from `color`, scene-linear light of any size, which
        is stretched over `depth`.
        """
        line = optics.line
        near, far = optics.nearest_px, optics.farthest_px
        limits = (*layer_limits_px, *[1e30] * LAYERS_MAX)[:LAYERS_MAX]  # unused ones are farthest
        defines = {"MODE": overlay_of(overlay).function, "PEAKING": int(peaking is not None)}
        peaking = peaking or USUAL_PEAKING
        self._program.version(**defines).dispatch(
            pixel_groups(out.size),
            textures={"depth_tx": depth, "color_tx": color or depth},
            images={"out_overlay_img": out},
            uniforms={
                "is_coc": line is None,
                **(line or NO_LINE).uniforms,
                "sharp_px": sharp_px,
                "range_px": (near, far),
                "layer_limits_px": limits,
                "peaking_contrast": peaking.stops,
                "peaking_px": peaking.blur * sharp_px,
                "peaking_rgb": peaking.rgb,
                "is_peaking_all": peaking.on is PeakingOn.DEPTH,
            },
        )
