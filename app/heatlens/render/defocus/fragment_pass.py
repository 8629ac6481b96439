"""Split mixed pixels of silhouettes into a near and a far fragment."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.listed_fragments import (
    ListedFragments,
    ListProgram,
    list_buffers,
    list_uniforms,
)
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import OF_BACK, OF_FRONT, PixelBands, Slices, clear_list
from heatlens.render.gpu.device import Buffer, Device, Texture
from heatlens.render.gpu.program import ComputeProgram


@dataclass(frozen=True)
class Fragments:
    """The picture with its silhouette pixels split, in textures of one size.

    color   rgb
    coc     signed diameter, pixels
    kind    whole, far rim, near rim or listed; with lists also the coc at which each begins
    far     far rim: rgb of the far fragment, a = coverage of the near one; near rim: its own rgb
            and coverage; elsewhere not written. Half float is enough: pixels in focus do not use it
    near    far rim: rgb of the near fragment, a = its coc; near rim: a = coc of the surface behind
    lists   the surfaces behind, if the plate has fragment lists
    around  luminance around each block of 2 x 2 pixels, which highlights exceed; None if the
            picture still has its highlights
    """

    color: Texture
    coc: Texture
    kind: Texture
    far: Texture
    near: Texture
    lists: ListedFragments | None = None
    around: Texture | None = None

    def textures(self) -> dict[str, Texture]:
        """Return the textures by their sampler names."""
        return {
            "color_tx": self.color,
            "coc_tx": self.coc,
            "kind_tx": self.kind,
            "far_tx": self.far,
            "near_tx": self.near,
        }


_Images = dict[str, Texture]
_Buffers = dict[str, Buffer]
_Uniforms = dict[str, object]


# An anti-aliased pixel of a silhouette has a mixed colour and the depth of one sample. Left alone,
# it leaks the nearer colour into the blurred background. Splitting it was the largest single gain
# behind wires (FLIP .109 -> .081). The middle of a rim pixel is known to be seen, so that its near
# surface covers at most half of a far rim and at least half of a near one: mean FLIP of eleven
# lenses .0432 -> .0419.
class FragmentPass:
    """Computes kind, far and near of a `Fragments` from its colour and coc."""

    def __init__(self, ctx: Device) -> None:
        self._find = ListProgram(ctx, "defocus/fragments_find.comp.glsl")
        self._own = ListProgram(ctx, "defocus/fragments_own.comp.glsl")
        self._far = ListProgram(ctx, "defocus/fragments_far.comp.glsl")
        self._thin = ComputeProgram(ctx, "defocus/fragments_thin.comp.glsl")
        self._near = ListProgram(ctx, "defocus/fragments_near.comp.glsl")
        self._bands, self._slices = PixelBands(ctx), Slices(ctx)

    # Each pass has its own end of a list, far rims in front and near ones in the back, because a
    # software rasteriser runs both sides of every branch. One pass for both took 238 ms in place of
    # 115. The near rim comes first: its own colour is found once, where each far rim beside it
    # looked for it before. Hair has a list of its own for the same reason.
    def steps(
        self, picture: Fragments, optics: Optics, pixels: Buffer, thin: Buffer
    ) -> Iterator[None]:
        """Split the silhouette pixels of `picture`; `pixels` and `thin` are scratch memory."""
        clear_list(pixels)
        clear_list(thin)
        rims: _Buffers = {"two_lists_block": pixels}
        uniforms = optics.infinity_uniforms
        textures = {"color_tx": picture.color, "coc_tx": picture.coc, "kind_tx": picture.kind}
        lists = picture.lists
        yield from self._found(picture, uniforms, rims | list_buffers(lists))
        programs = self._own, self._far, self._near
        own, far, near = (each.version(lists is not None) for each in programs)
        split: _Images = {"far_img": picture.far, "near_img": picture.near}
        begun: _Images = {"out_far_img": picture.far, "out_near_img": picture.near}
        to_thin: _Buffers = {"pixel_list_block": thin}
        known, of_lists = rims | list_buffers(lists), list_uniforms(lists)
        on_rims: tuple[tuple[ComputeProgram, Buffer, int, _Images, _Buffers, _Uniforms], ...]
        on_rims = (
            (own, pixels, OF_BACK, begun, known | to_thin, of_lists),
            (far, pixels, OF_FRONT, split, known | to_thin, of_lists),
            (self._thin, thin, OF_FRONT, split, to_thin, {}),
            (near, pixels, OF_BACK, split, known, of_lists),
        )
        for program, listed, offset, images, buffers, more in on_rims:
            for part in self._slices.of(picture.color.size):
                program.dispatch(
                    listed,
                    offset=offset,
                    textures=textures,
                    images=images,
                    buffers=buffers,
                    uniforms=uniforms | part | more,
                )
                yield

    def _found(self, picture: Fragments, uniforms: _Uniforms, written: _Buffers) -> Iterator[None]:
        """Find the kind of each pixel, and list the rims."""
        lists = picture.lists
        of_lists = {} if lists is None else {"is_measured": lists.is_measured}
        return self._bands.run(
            self._find.version(lists is not None),
            picture.color.size,
            uniforms | list_uniforms(lists) | of_lists,
            textures={"coc_tx": picture.coc},
            images={"out_kind_img": picture.kind},
            buffers=written,
        )
