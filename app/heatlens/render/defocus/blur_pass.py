"""Diffuse one image along rows, then columns, with the poles of a kernel."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.line_solver import Axis, Bindings, LineSolver, LineSystem
from heatlens.render.defocus.tile_mask import TileMask
from heatlens.render.gpu.resources import Buffer, StorageBuffer, Texture, TextureArray
from heatlens.render.gpu.textures import Storage

PACKED: Storage = "u4"  # eight halves of a pole's image in the four words of a texel


@dataclass(frozen=True)
class Over:
    """The picture that a blurred layer of the same size is composited over, in place."""

    color: Texture  # RGBA
    is_farthest: bool  # the layer replaces what is behind it


# An image of four floats is slow to write for a processor: llvmpipe takes 20 ns for a pixel, and
# 4 ns for the same pixel in a buffer.
@dataclass(frozen=True)
class PackedPicture:
    """RGBA as half floats in two words a pixel, row by row (lib/halves.lib.glsl)."""

    words: Buffer
    size: tuple[int, int]

    @staticmethod
    def bytes_for(size: tuple[int, int]) -> int:
        """Return the bytes of a picture."""
        return 8 * size[0] * size[1]


Picture = Texture | PackedPicture


@dataclass(frozen=True)
class BlurTargets:
    """The scratch and result pictures of the blur, at least of the picture's size."""

    poles: TextureArray  # `pole_layers` of `PACKED`, or of float32
    out_color: Picture  # RGBA; a packed picture is blurred in place
    over: Over | None = None  # takes the result instead of `out_color`, which is scratch then


@dataclass(frozen=True)
class Diffusion:
    """The picture to diffuse, and how far.

    color          RGBA
    coc            diameter in pixels; the sign is ignored
    kernel         the shape to which a point of light spreads
    axis_scales    diameter along x and y, relative to `coc`
    least_px       lower limit of the coc
    resampled_px_2 squared diameter of the blur that the picture has already
    shape          the shape of the discs in pixels of the picture; None for ellipses
    is_in_front    all of the picture is in front of the focus, regardless of the sign of `coc`
    corner         width and height of the picture, if it fills only the corner of the textures
    """

    color: Picture
    coc: Texture
    kernel: Kernel
    axis_scales: tuple[float, float]
    least_px: float = 0.0
    resampled_px_2: float = 0.0
    shape: DiscShape | None = None
    is_in_front: bool = False
    corner: tuple[int, int] | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture in pixels."""
        return self.corner or self.color.size

    @property
    def shape_uniforms(self) -> dict[str, object]:
        """The uniforms of a shape that is not an ellipse; empty for ellipses."""
        if self.shape is None or self.shape.is_plain:
            return {}
        uniforms = self.shape.diffusion_uniforms
        if self.is_in_front:
            front, _ = self.shape.side_variances
            uniforms = uniforms | {"side_variances": (front, front)}
        return uniforms


def pole_layers(kernel: Kernel, storage: Storage = PACKED) -> int:
    """Return the number of layers of the intermediate image between rows and columns.

    A pole has one layer, or two if complex values are not packed: real and imaginary parts.
    """
    return len(kernel.poles) * (2 if kernel.is_complex and storage != PACKED else 1)


class BlurPass:
    """Blurs a picture by solving the systems of a kernel along its rows, then its columns.

        y = Re sum_ab M_ab (1 + kappa_b L_y)^-1 (1 + kappa_a L_x)^-1 x

    x is the picture and y the result. The kernel (`kernels.py`) has the poles kappa and the mixing
    weights M. L_x and L_y are the Laplacians along rows and columns, with squared diameters as
    conductances; for discs they are compact (shaders/lib/compact.lib.glsl).
    """

    def __init__(self, solver: LineSolver) -> None:
        self._solver = solver

    def run(self, diffusion: Diffusion, targets: BlurTargets, mask: TileMask | None = None) -> None:
        """Diffuse a picture, or only its tiles in `mask`.

        The target may be `diffusion.color` itself; pixels in focus keep their values.
        """
        for _ in self.steps(diffusion, targets, mask):
            pass

    def steps(
        self, diffusion: Diffusion, targets: BlurTargets, mask: TileMask | None = None
    ) -> Iterator[None]:
        """Do what `run` does in short steps, so that a window can answer in between."""
        kernel = diffusion.kernel
        system = LineSystem(
            "lib/blur_system.lib.glsl",
            poles=len(kernel.poles),
            is_complex=kernel.is_complex,
            defines=_defines(diffusion, targets),
        )
        source = diffusion.color
        for steps_left in reversed(range(kernel.steps)):
            # only the last step is composited over the picture behind
            over = None if steps_left else targets.over
            for axis, bindings in _bindings_of_axes(diffusion, source, replace(targets, over=over)):
                yield from self._solver.steps(system, axis, diffusion.size, bindings, mask)
            source = targets.out_color


def _defines(diffusion: Diffusion, targets: BlurTargets) -> tuple[tuple[str, object], ...]:
    """Return the shader's defines for packed poles and pictures, and for discs, not ellipses."""
    defines = {
        "HALF_POLES": targets.poles.dtype == PACKED,
        "PACKED_PICTURE": isinstance(diffusion.color, PackedPicture),
        "SHAPED": bool(diffusion.shape_uniforms),
    }
    return tuple((name, 1) for name, is_defined in defines.items() if is_defined)


# Rows mix their solutions to one image for each pole of the columns. Each image is divided by the
# weight that the columns give it: a uniform picture then has the same uniform value in each image
# and stays exact, also in half floats. Half floats halve the memory traffic between the two axes.
# The shader rounds them and packs them in words, since Mesa truncates.
def _bindings_of_axes(
    diffusion: Diffusion, source: Picture, targets: BlurTargets
) -> Iterator[tuple[Axis, Bindings]]:
    """Yield the axis and its shader inputs for the rows of `source`, then for the columns.

    Pixels in focus are taken from `diffusion.color`.
    """
    kernel, sums, over = diffusion.kernel, diffusion.kernel.mix.sum(axis=0), targets.over
    uniforms: dict[str, object] = {
        "kappa": _to_shader_numbers(kernel, kernel.poles),
        "mix_weights": _to_shader_numbers(kernel, kernel.mix / sums),
        "sum_weights": _to_shader_numbers(kernel, sums),
        "compact_c": kernel.compact,
        "least_px": diffusion.least_px,
        "resampled_px_2": diffusion.resampled_px_2,
        **diffusion.shape_uniforms,
    }
    coc, buffers = {"coc_tx": diffusion.coc}, _buffers(source)
    yield (
        "rows",
        Bindings(
            coc | _textures(source_tx=source),
            {"out_poles_img": targets.poles},
            uniforms | {"axis_scale": diffusion.axis_scales[0]},
            buffers,
        ),
    )
    written = targets.out_color if over is None else over.color
    yield (
        "columns",
        Bindings(
            {**coc, "poles_tx": targets.poles, **_textures(color_tx=diffusion.color)},
            _textures(color_img=written),
            uniforms | {"axis_scale": diffusion.axis_scales[1]} | _over_uniforms(source, over),
            buffers,
        ),
    )


def _textures(**pictures: Picture) -> dict[str, Texture]:
    """Return those of the pictures that are textures."""
    return {
        name: picture
        for name, picture in pictures.items()
        if not isinstance(picture, PackedPicture)
    }


def _buffers(picture: Picture) -> dict[str, StorageBuffer]:
    """Return the buffer of a packed picture, which is read and written."""
    return {"picture_block": picture.words} if isinstance(picture, PackedPicture) else {}


def _over_uniforms(picture: Picture, over: Over | None) -> dict[str, object]:
    """Return the uniforms that tell what becomes of the result; a packed picture is replaced."""
    if isinstance(picture, PackedPicture):
        return {}
    return {"is_over": over is not None, "is_farthest": over is not None and over.is_farthest}


def _to_shader_numbers(kernel: Kernel, values: npt.NDArray[np.complex128]) -> object:
    """Return a kernel's coefficients in the layout of the shader's `Num` array.

    A complex number is a pair (real, imaginary). A single number is returned without a list.
    """
    flat = values.ravel()
    numbers = [(z.real, z.imag) for z in flat] if kernel.is_complex else [z.real for z in flat]
    return numbers if len(numbers) > 1 else numbers[0]
