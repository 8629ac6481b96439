"""Split a picture into its highlights and the light to diffuse."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.blur_pass import BlurPass, BlurTargets, Diffusion
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.listed_fragments import (
    ListedFragments,
    list_buffers,
    list_uniforms,
)
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import PixelBands
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.shader_constants import HIGHLIGHT_BLOCK

_SURROUNDINGS_PX = 16.0  # smallest diameter of the surroundings of a pixel


def block_count(size: tuple[int, int]) -> int:
    """Return how many blocks of 8 x 8 pixels cover a picture."""
    return groups_for(size[0], HIGHLIGHT_BLOCK) * groups_for(size[1], HIGHLIGHT_BLOCK)


@dataclass(frozen=True)
class Surroundings:
    """Scratch memory to measure the surroundings of a pixel, all of half the picture's size.

    luminance  RGBA
    coc        R, in the corner of the texture
    targets    of the diffusion; without lists into `luminance` itself
    """

    luminance: Texture
    coc: Texture
    targets: BlurTargets


@dataclass(frozen=True)
class ListsWithoutHighlights:
    """Fragment lists, and memory for the same lists without their highlights.

    with_highlights  the lists as they were
    diffuse_words    the words of the lists without them
    """

    with_highlights: ListedFragments
    diffuse_words: Buffer

    @property
    def lists_to_diffuse(self) -> ListedFragments:
        """The lists whose light is diffused with the layers."""
        return self.with_highlights.with_words(self.diffuse_words)


@dataclass(frozen=True)
class WithoutHighlights:
    """A picture split into its highlights and other light.

    diffuse     RGBA, the light to diffuse
    highlights  RGBA, the light to draw as discs and its signed coc; written only where `lit` is set
    lit         a bit for each pixel that has light to draw (lib/lit_bits.lib.glsl)
    around      R of half the size, the luminance of the surroundings
    lists       the same for fragment lists; None without lists
    """

    diffuse: Texture
    highlights: Texture
    lit: Buffer
    around: Texture
    lists: ListsWithoutHighlights | None = None

    @staticmethod
    def lit_bytes(size: tuple[int, int]) -> int:
        """Return the bytes of `lit` for a picture."""
        return block_count(size) * HIGHLIGHT_BLOCK**2 // 8

    @property
    def buffers(self) -> dict[str, Buffer]:
        """The storage blocks of the shaders that take highlights out or put them back."""
        lit, lists = {"lit_block": self.lit}, self.lists
        return lit if lists is None else lit | {"diffuse_fragment_block": lists.diffuse_words}


# Highlights are taken out of the picture, to be drawn as discs: FLIP .107 -> .050 in a still life
# with lamps. Diffused, a lamp 300 times as bright as the wall would show the few per cent of ripple
# that any short sum of exponentials has. Only what outshines most of its surroundings is a
# highlight; bright surfaces are diffused. Surroundings are measured at half size, with clipped
# light, because a lamp must not raise the level that it is compared with.
class HighlightSplitPass:
    """Splits a picture into its highlights and the light to diffuse."""

    def __init__(self, ctx: Device, blur: BlurPass) -> None:
        self._blur = blur
        self._luminance = ComputeProgram(ctx, "defocus/highlight_luminance.comp.glsl")
        self._split = ComputeProgram(ctx, "defocus/highlight_split.comp.glsl")
        self._bands = PixelBands(ctx)

    def steps(
        self,
        color: Texture,
        coc: Texture,
        optics: Optics,
        scratch: Surroundings,
        out: WithoutHighlights,
        has_positions: bool = False,
    ) -> Iterator[None]:
        """Split `color` and the colors of the lists into the textures and buffers of `out`.

        The luminance is measured at half size, then diffused to that of the surroundings of each
        pixel. What is brighter than its surroundings is a highlight. With `has_positions` the
        position of each light in its pixel is known, see `HighlightListPass`.
        """
        yield from self._measure_surroundings(color, coc, optics, scratch, out)
        lists = out.lists
        source_lists = None if lists is None else lists.with_highlights
        of_lists = {} if lists is None else {"luminance_tx": scratch.luminance}
        yield from self._bands.run(
            self._split.version(LISTS=lists is not None),
            color.size,
            list_uniforms(source_lists)
            | ({} if lists is None else {"has_positions": has_positions}),
            textures={"color_tx": color, "coc_tx": coc}
            | {"surroundings_tx": scratch.targets.out_color}
            | of_lists,
            images={
                "out_diffuse_img": out.diffuse,
                "out_highlight_img": out.highlights,
                "out_around_img": out.around,
            },
            buffers=list_buffers(source_lists) | out.buffers,
        )

    def _measure_surroundings(
        self,
        color: Texture,
        coc: Texture,
        optics: Optics,
        scratch: Surroundings,
        out: WithoutHighlights,
    ) -> Iterator[None]:
        """Measure the luminance at half size and diffuse it, and copy the lists to take light from.

        The shader takes the highlights out of the copy.
        """
        lists = out.lists
        source_lists = None if lists is None else lists.with_highlights
        yield from self._bands.run(
            self._luminance.version(LISTS=lists is not None),
            scratch.luminance.size,
            list_uniforms(source_lists),
            side=2,
            textures={"color_tx": color, "coc_tx": coc},
            images={"out_luminance_img": scratch.luminance, "out_coc_img": scratch.coc},
            buffers=list_buffers(source_lists) | {"lit_block": out.lit},
        )
        if lists is not None:
            lists.with_highlights.packed_lists.words.copy_to(lists.diffuse_words)
        diffusion = Diffusion(
            *(scratch.luminance, scratch.coc, named_kernel("heat"), optics.disc.spreads),
            least_px=_SURROUNDINGS_PX / 2,  # in pixels of the picture of half the size
        )
        yield from self._blur.steps(diffusion, scratch.targets)
