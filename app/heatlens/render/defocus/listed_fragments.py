"""Keep the fragment lists of a plate on the GPU, and programs that can use them."""

from dataclasses import dataclass, replace

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine
from heatlens.render.defocus.optics import Optics
from heatlens.render.gpu.resources import Buffer


@dataclass(frozen=True)
class FragmentBuffers:
    """The fragment lists of a plate, packed as lib/fragment_list.lib.glsl reads them.

    starts       one word per pixel, and one more as the end
    words        three words per fragment
    size         width and height of the plate, pixels
    is_measured  the file has the coverage of visible surfaces, so that silhouettes are not guessed
    origin       x, y of the plate's first pixel in the larger picture whose lists these are
    stride       width of that larger picture; 0 if it is as wide as the plate
    is_exact     the lists were rendered with the picture, and need not be matched to it
    """

    starts: Buffer
    words: Buffer
    size: tuple[int, int]
    is_measured: bool
    origin: tuple[int, int] = (0, 0)
    stride: int = 0
    is_exact: bool = False

    def crop(self, box: Box) -> "FragmentBuffers":
        """Return the lists of the pixels in `box`, in the same buffers."""
        stride = self.stride or self.size[0]
        return replace(self, size=(box.width, box.height), origin=(box.x0, box.y0), stride=stride)

    def release(self) -> None:
        """Release the buffers."""
        self.starts.release()
        self.words.release()


@dataclass(frozen=True)
class ListedFragments:
    """The lists of a plate seen through a lens.

    is_open   nothing is behind the last fragment of a list, because the plate has alpha
    is_alpha  the picture is the plate's alpha: each fragment has the value 1
    """

    packed_lists: FragmentBuffers
    line: CocLine
    is_open: bool = False
    is_alpha: bool = False

    @property
    def is_exact(self) -> bool:
        """True if the lists need not be matched to the picture."""
        return self.packed_lists.is_exact or self.is_alpha

    @property
    def is_measured(self) -> bool:
        """True if silhouettes in the picture need not be guessed."""
        return self.packed_lists.is_measured

    @property
    def buffers(self) -> dict[str, Buffer]:
        """The storage blocks that shaders read the lists from."""
        return {"start_block": self.packed_lists.starts, "fragment_block": self.packed_lists.words}

    @property
    def depth_uniforms(self) -> dict[str, object]:
        """The uniform of lib/surface_depth.lib.glsl."""
        return {"fragment_line": (self.line.at_infinity_px, self.line.per_dioptre_px)}

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms that shaders need for the lists."""
        return {
            "lists_origin": self.packed_lists.origin,
            "lists_stride": self.packed_lists.stride or self.packed_lists.size[0],
            **self.depth_uniforms,
            **self.line.focus_offset_uniforms,
            "is_open": self.is_open,
            "is_alpha": self.is_alpha,
        }

    def with_words(self, words: Buffer) -> "ListedFragments":
        """Return the same lists with other `words`, whose colors differ."""
        return replace(self, packed_lists=replace(self.packed_lists, words=words))

    def of_alpha(self) -> "ListedFragments":
        """Return the same lists for the plate's alpha, which uses coverage instead of light."""
        return replace(self, is_alpha=True)


def listed_through(
    fragments: FragmentBuffers | None, optics: Optics, has_alpha: bool
) -> ListedFragments | None:
    """Return the lists seen through a lens; None without lists or without a known lens."""
    if fragments is None or optics.line is None:
        return None
    return ListedFragments(fragments, optics.line, is_open=has_alpha)


def list_buffers(lists: ListedFragments | None) -> dict[str, Buffer]:
    """Return the storage blocks of the lists; empty without lists."""
    return {} if lists is None else lists.buffers


def list_uniforms(lists: ListedFragments | None) -> dict[str, object]:
    """Return the uniforms of the lists; empty without lists."""
    return {} if lists is None else lists.uniforms
