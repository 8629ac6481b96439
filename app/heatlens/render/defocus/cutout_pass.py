"""Composite the part of a picture that a matte keeps sharp among the layers, by its depth."""

from dataclasses import dataclass

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Texture

_EVERYWHERE = (-1e30, 1e30)  # a range that contains every signed circle of confusion, in pixels


@dataclass(frozen=True)
class CutoutTextures:
    """A cutout on the GPU (`plate.plate.Cutout`), at the size of a picture.

    light        RGBA: rgb times its share of the pixel, and the share
    alpha        the same with the plate's alpha as its light; None for a plate without alpha
    depth        depth of the cutout, or, once a lens is known, its signed circle of confusion
    clean_color  RGBA of the picture without the cutout
    clean_depth  depth of the picture without the cutout, as that of a plate
    backdrop     RGBA, sharp, behind the clean picture, which then has alpha; None if it covers all
    """

    light: Texture
    alpha: Texture | None
    depth: Texture
    clean_color: Texture
    clean_depth: Texture
    backdrop: Texture | None = None

    def lights_of(self, other: "CutoutTextures") -> list[tuple[Texture, Texture]]:
        """Return the pairs (texture of `other`, same texture of this cutout) that both have."""
        pairs = [
            (other.light, self.light),
            (other.alpha, self.alpha),
            (other.backdrop, self.backdrop),
        ]
        return [(a, b) for a, b in pairs if a is not None and b is not None]

    def release(self) -> None:
        """Release the textures."""
        for texture in (
            self.light,
            self.alpha,
            self.depth,
            self.clean_color,
            self.clean_depth,
            self.backdrop,
        ):
            if texture is not None:
                texture.release()


@dataclass(frozen=True)
class SharpPart:
    """What stays sharp in a picture that is being blurred.

    light, alpha  as those of `CutoutTextures`
    coc           signed, pixels: its place among the layers
    """

    light: Texture
    alpha: Texture | None
    coc: Texture

    def of_alpha(self) -> "SharpPart":
        """Return the part with the plate's alpha in place of its light.

        With it, alpha is blurred as a picture of its own, in the same way as the light.
        """
        return SharpPart(self.alpha or self.light, self.alpha, self.coc)


class CutoutPass:
    """Composites a sharp part over what is behind it."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/cutout_over.comp.glsl")
        self._backdrop = ComputeProgram(ctx, "defocus/cutout_backdrop.comp.glsl")

    def over_layers(
        self, sharp: SharpPart, coc_range_px: tuple[float, float], color: Texture
    ) -> None:
        """Composite over `color`, which keeps its alpha, the part with a coc in `coc_range_px`.

        The range holds its lower end, not its upper one.
        """
        self._run(sharp, sharp.coc, coc_range_px, color, is_on_top=False)

    def on_top(self, sharp: SharpPart, coc: Texture, color: Texture) -> None:
        """Composite over `color` all that a picture with this signed `coc` does not hide."""
        self._run(sharp, coc, _EVERYWHERE, color, is_on_top=True)

    def over_backdrop(self, backdrop: Texture, color: Texture, is_opaque: bool) -> None:
        """Put `backdrop` behind `color`; `is_opaque` makes alpha exactly 1."""
        self._backdrop.dispatch(
            pixel_groups(color.size),
            textures={"backdrop_tx": backdrop},
            images={"color_img": color},
            uniforms={"is_opaque": is_opaque},
        )

    def _run(
        self,
        sharp: SharpPart,
        coc: Texture,
        coc_range_px: tuple[float, float],
        color: Texture,
        is_on_top: bool,
    ) -> None:
        """Composite over `color` the part with a coc in `coc_range_px`.

        `coc` is that of the picture without the part; it is used only if `is_on_top`.
        """
        self._program.dispatch(
            pixel_groups(color.size),
            textures={
                "cutout_tx": sharp.light,
                "cutout_alpha_tx": sharp.alpha or sharp.light,
                "cutout_coc_tx": sharp.coc,
                "coc_tx": coc,
            },
            images={"out_color_img": color},
            uniforms={"coc_range_px": coc_range_px, "is_on_top": is_on_top},
        )
