"""Split mixed pixels of silhouettes into a near and a far surface."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.listed_fragments import (
    ListedFragments,
    list_buffers,
    list_uniforms,
)
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import OF_FIRST, OF_SECOND, PixelBands, Slices, clear_list
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram
from heatlens.render.gpu.resources import Buffer, Texture


@dataclass(frozen=True)
class UnmixedPicture:
    """The picture with its silhouette pixels split, in textures of one size.

    An edge pixel lies on a silhouette, where anti-aliasing has mixed the colors of a near and a far
    surface. At its middle, a far edge shows the far surface, and a near edge the near one.

    color   rgb
    coc     signed diameter, pixels
    kind    unmixed, far edge, near edge or listed; the coc of the nearest surface in the pixel;
            with lists also the coc at which each begins
    far     far edge: rgb of the far surface, a = coverage of the near one; near edge: its own rgb
            and coverage; elsewhere not written. Half float is enough: pixels in focus do not use it
    near    far edge: rgb of the near surface, a = its coc; near edge: a = coc of the surface behind
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


# Splits the anti-aliased pixels of silhouettes, which have a mixed color and the depth of one
# sample. Left whole, such a pixel leaks the nearer color into the blurred background; splitting it
# was the largest single gain behind wires (FLIP .109 -> .081). An edge pixel has the depth of what
# is seen at its middle: the near surface covers at most half of a far edge pixel, and at least half
# of a near edge pixel. That limit: mean FLIP of eleven lenses .0432 -> .0419.
class UnmixPass:
    """Computes `kind`, `far` and `near` of an `UnmixedPicture` from its color and coc."""

    def __init__(self, ctx: Device) -> None:
        self._find = ComputeProgram(ctx, "defocus/unmix_find.comp.glsl")
        self._own = ComputeProgram(ctx, "defocus/unmix_own.comp.glsl")
        self._far = ComputeProgram(ctx, "defocus/unmix_far.comp.glsl")
        self._thin = ComputeProgram(ctx, "defocus/unmix_thin.comp.glsl")
        self._near = ComputeProgram(ctx, "defocus/unmix_near.comp.glsl")
        self._bands, self._slices = PixelBands(ctx), Slices(ctx)

    # Far edges are in the first list and near edges in the second, and each kind has its own pass,
    # because a software rasterizer runs both sides of every branch: one pass for both took 238 ms
    # instead of 115. Near edges come first: their own color is found once, and far edges next to
    # them read it. Hair has a list of its own for the same reason.
    def steps(
        self, picture: UnmixedPicture, optics: Optics, pixels: Buffer, thin: Buffer
    ) -> Iterator[None]:
        """Split the silhouette pixels of `picture`, in short steps.

        `pixels` and `thin` are scratch memory: the lists of edge pixels and of pixels of hair.
        """
        clear_list(pixels)
        clear_list(thin)
        edge_buffers: _Buffers = {"two_lists_block": pixels}
        uniforms = optics.infinity_uniforms
        textures = {"color_tx": picture.color, "coc_tx": picture.coc, "kind_tx": picture.kind}
        lists = picture.lists
        yield from self._classify_pixels(picture, uniforms, edge_buffers | list_buffers(lists))
        programs = self._own, self._far, self._thin, self._near
        own, far, thin_split, near = (each.version(LISTS=lists is not None) for each in programs)
        split_images: _Images = {"far_img": picture.far, "near_img": picture.near}
        first_images: _Images = {"out_far_img": picture.far, "out_near_img": picture.near}
        thin_buffers: _Buffers = {"pixel_list_block": thin}
        behind, list_values = list_buffers(lists), list_uniforms(lists)
        edges, edges_and_thin = edge_buffers | behind, edge_buffers | behind | thin_buffers
        # A program, the list that it works through, the byte offset of its workgroups there, and
        # the images, buffers and uniforms that it needs besides those of all passes.
        passes: tuple[tuple[ComputeProgram, Buffer, int, _Images, _Buffers, _Uniforms], ...]
        passes = (
            (own, pixels, OF_SECOND, first_images, edges_and_thin, list_values),
            (far, pixels, OF_FIRST, split_images, edges_and_thin, list_values),
            (thin_split, thin, OF_FIRST, split_images, thin_buffers | behind, list_values),
            (near, pixels, OF_SECOND, split_images, edges, list_values),
        )
        for program, pixel_buffer, offset, images, buffers, extra_uniforms in passes:
            for slice_uniforms in self._slices.of(picture.color.size):
                program.dispatch(
                    pixel_buffer,
                    offset=offset,
                    textures=textures,
                    images=images,
                    buffers=buffers,
                    uniforms=uniforms | slice_uniforms | extra_uniforms,
                )
                yield

    def _classify_pixels(
        self, picture: UnmixedPicture, uniforms: _Uniforms, out_buffers: _Buffers
    ) -> Iterator[None]:
        """Write the kind of each pixel, and list the edge pixels in `out_buffers`."""
        lists = picture.lists
        list_values = {} if lists is None else {"is_measured": lists.is_measured}
        return self._bands.run(
            self._find.version(LISTS=lists is not None),
            picture.color.size,
            uniforms | list_uniforms(lists) | list_values,
            textures={"coc_tx": picture.coc},
            images={"out_kind_img": picture.kind},
            buffers=out_buffers,
        )
