"""Prepare a plate for the blur: proxy size, circle of confusion, crops and alpha."""

from collections.abc import Collection, Iterator

from heatlens.core.model.focus.coc import CocLine
from heatlens.render.defocus.pixel_list import PixelBands
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Texture


def proxy_size(size: tuple[int, int], proxy: float) -> tuple[int, int]:
    """Return the size of a picture at a proxy scale, at least 1 x 1 pixels."""
    return max(1, round(size[0] * proxy)), max(1, round(size[1] * proxy))


class CocPass:
    """Converts depth in meters to the signed circle of confusion in pixels."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/coc.comp.glsl")
        self._shift = ComputeProgram(ctx, "defocus/coc_shift.comp.glsl")
        self._bands = PixelBands(ctx)

    def steps(
        self, depth: Texture, line: CocLine | None, out_coc: Texture, shift_px: float = 0.0
    ) -> Iterator[None]:
        """Write the disc diameter of every pixel, negative in front of the focus plane.

        Without a `line`, `depth` is the diameter already, to which `shift_px` is added.
        """
        if line is None:
            program, in_textures = self._shift, {"coc_tx": depth}
            uniforms: dict[str, object] = {"shift_px": shift_px}
        else:
            program, in_textures = self._program, {"depth_tx": depth}
            uniforms = line.uniforms
        out_images = {"out_coc_img": out_coc}
        return self._bands.run(
            program, out_coc.size, uniforms, textures=in_textures, images=out_images
        )


class CropPass:
    """Copies a part of a picture to another picture, at the same or a smaller scale."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/crop.comp.glsl")

    def run(
        self,
        full_size: Texture,
        origin: tuple[int, int],
        out: Texture,
        reduction: int = 1,
        light_scale: float = 1.0,
    ) -> None:
        """Copy the pixels from `origin` on to `out`, whose size decides how many.

        Each pixel of `out` is the mean of `reduction` x `reduction` pixels, with rgb multiplied by
        `light_scale`.
        """
        self._program.dispatch(
            pixel_groups(out.size),
            textures={"from_tx": full_size},
            images={"out_img": out},
            uniforms={"origin": origin, "reduction": reduction, "light_scale": light_scale},
        )

    def release(self) -> None:
        """Release the program."""
        self._program.release()


class RescalePass:
    """Scales a picture about a point, or a whole number of times."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/rescale.comp.glsl")
        self._enlarge = ComputeProgram(ctx, "defocus/enlarge.comp.glsl")

    def enlarge(self, picture: Texture, out: Texture) -> None:
        """Enlarge the whole picture to `out`, which is twice or three times as large."""
        program = self._enlarge.version(FACTOR=out.width // picture.width)
        program.dispatch(
            pixel_groups(picture.size), textures={"from_tx": picture}, images={"out_img": out}
        )

    def run(
        self, picture: Texture, center: tuple[float, float], ratio: float, out: Texture
    ) -> None:
        """Scale the picture by 1/`ratio` about `center` (x, y), to `out` of the same size."""
        self._program.dispatch(
            pixel_groups(out.size),
            textures={"from_tx": picture},
            images={"out_img": out},
            uniforms={"center": center, "ratio": ratio},
        )

    def release(self) -> None:
        """Release the programs."""
        self._program.release()
        self._enlarge.release()


class AlphaPass:
    """Copies alpha to a picture of its own, which is blurred as a color is, and back."""

    def __init__(self, ctx: Device) -> None:
        self._as_color = ComputeProgram(ctx, "defocus/alpha_as_color.comp.glsl")
        self._join = ComputeProgram(ctx, "defocus/alpha_join.comp.glsl")

    def as_color(self, color: Texture, out_color: Texture) -> None:
        """Copy the alpha of `color` to the rgb of `out_color`."""
        self._as_color.dispatch(
            pixel_groups(color.size),
            textures={"color_tx": color},
            images={"out_color_img": out_color},
        )

    def join(self, alpha: Texture, color: Texture) -> None:
        """Copy the red of `alpha` to the alpha of `color`."""
        self._join.dispatch(
            pixel_groups(color.size), textures={"alpha_tx": alpha}, images={"color_img": color}
        )


class ColorPass:
    """Copies single channels of one picture to another."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/channels_copy.comp.glsl")

    def copy_channels(self, picture: Texture, channels: Collection[int], out: Texture) -> None:
        """Copy these `channels` of `picture`, 0 to 3, to `out`; its other channels stay."""
        self._program.dispatch(
            pixel_groups(out.size),
            textures={"picture_tx": picture},
            images={"out_color_img": out},
            uniforms={"copied_channels": tuple(float(channel in channels) for channel in range(4))},
        )


class ProxyPass:
    """Reduces a plate: color is averaged, depth is sampled."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "defocus/proxy.comp.glsl")

    def run(
        self,
        color: Texture,
        depth: Texture,
        depth_scale: float,
        out_color: Texture,
        out_depth: Texture,
        out_positions: Texture | None = None,
    ) -> None:
        """Reduce color and depth; `depth_scale` is 1 for meters, the proxy scale for coc.

        `out_positions`, RGBA, gets the position of the light of each highlight in its pixel.
        """
        images = {"out_color_img": out_color, "out_depth_img": out_depth}
        if out_positions is not None:
            images["out_positions_img"] = out_positions
        self._program.version(POSITIONS=out_positions is not None).dispatch(
            pixel_groups(out_color.size),
            textures={"color_tx": color, "depth_tx": depth},
            images=images,
            uniforms={"depth_scale": depth_scale},
        )
