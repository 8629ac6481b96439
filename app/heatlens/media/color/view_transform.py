"""The view transform from scene-linear light to display values, for the GPU and the CPU.

On the GPU it is GLSL with tables. On both, light is multiplied by 2^exposure_stops and transformed,
and the result is raised to the power 1/gamma.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import ocio
from heatlens.core.base.paths import data_dir
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.view.view import PLAIN_VIEW
from heatlens.media.color.color_config import ColorConfig, check_known, one_line
from heatlens.media.plate.header.primaries import KNOWN, REC709, XYZ, Primaries
from heatlens.media.plate.picture.display import srgb_encoded
from heatlens.media.plate.plate import FloatImage

Matrix = npt.NDArray[np.floating[Any]]

_BRADFORD: Matrix = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)


def to_rec709(primaries: Primaries) -> Matrix:
    """Return the matrix (3, 3) that converts columns of light to linear Rec. 709.

    White stays white; the D65 white of XYZ becomes white.
    """
    back: Matrix = np.linalg.inv(_to_xyz(REC709))
    if primaries == XYZ:
        return back
    matrix: Matrix = back @ _adapted(_white(primaries), _white(REC709)) @ _to_xyz(primaries)
    return matrix


def _to_xyz(primaries: Primaries) -> Matrix:
    """Return the XYZ of red, green and blue as columns, which sum to the white with Y = 1."""
    red, green, blue, _ = np.reshape(primaries.chromaticities, (4, 2))
    columns = np.stack([_xyz(*xy) for xy in (red, green, blue)], axis=1)
    matrix: Matrix = columns * np.linalg.solve(columns, _white(primaries))
    return matrix


def _white(primaries: Primaries) -> Matrix:
    x, y = primaries.chromaticities[6:]
    return _xyz(x, y) / y


def _xyz(x: float, y: float) -> Matrix:
    """Return XYZ with the sum 1, because blue of AP0 has almost no luminance."""
    return np.array([x, y, 1.0 - x - y])


def _adapted(white: Matrix, wanted: Matrix) -> Matrix:
    gain = (_BRADFORD @ wanted) / (_BRADFORD @ white)
    matrix: Matrix = np.linalg.inv(_BRADFORD) @ np.diag(gain) @ _BRADFORD
    return matrix


# Light is clamped to the largest half float, of either sign: infinity would become NaN.
LIGHT_MAX = 65504.0
_FUNCTION = "view_transform"


@dataclass(frozen=True, eq=False)
class Lut:
    """A table that the GLSL samples."""

    sampler: str  # its name in the GLSL, ends in _tx
    values: FloatImage  # (H, W) or (H, W, 3), or (N, N, N, 3) with red fastest
    is_linear: bool  # True for linear interpolation, False for the nearest entry


@dataclass(frozen=True)
class ViewTransform:
    """A view on a display for pictures in an input space. Equal transforms draw the same."""

    display: str
    view: str
    input_space: str
    key: str  # identifies the calculation; changes with the contents of the config
    glsl: str = field(repr=False)  # defines vec4 view_transform(vec4 light)
    luts: tuple[Lut, ...] = field(repr=False, compare=False)
    encode: Callable[[FloatImage], FloatImage] = field(repr=False, compare=False)

    def apply_cpu(
        self, rgb: FloatImage, exposure_stops: float = 0.0, gamma: float = 1.0
    ) -> FloatImage:
        """Convert scene-linear `rgb` to display values, both (H, W, 3) float32.

        NaN counts as black. A tone-mapped view stays inside 0..1, Raw does not.
        """
        light = np.clip(np.nan_to_num(rgb, nan=0.0), -LIGHT_MAX, LIGHT_MAX)
        shown = self.encode(np.float32(2.0**exposure_stops) * light.astype(np.float32))
        if gamma == 1.0:
            return shown
        bent: FloatImage = np.sign(shown) * np.abs(shown) ** np.float32(1.0 / gamma)
        return bent


def srgb_transform(
    input_space: str = REC709.name, turned_from: Primaries | None = None
) -> ViewTransform:
    """Return the plain curve of IEC 61966-2-1, clipped at white; it needs no library.

    `input_space`: name of one of the primaries in `plate.primaries`; raises InputError for others.
    `turned_from`: the light's own primaries, where they have no name.
    """
    check_known("Input space", input_space, tuple(known.name for known in KNOWN))
    glsl = (data_dir("shaders") / "lib" / "srgb_view.lib.glsl").read_text()
    encode: Callable[[FloatImage], FloatImage] = srgb_encoded
    key = "sRGB"
    if turned_from is not None or input_space != REC709.name:
        own = turned_from or next(known for known in KNOWN if known.name == input_space)
        key = f"sRGB of {own.name} {own.chromaticities}"
        matrix = to_rec709(own)
        glsl, encode = _in_rec709(glsl, matrix), _encoder_after(matrix)
    return ViewTransform("sRGB", PLAIN_VIEW, input_space, key, glsl, (), encode)


def _in_rec709(glsl: str, matrix: Matrix) -> str:
    """Return the same GLSL with a matrix applied first. GLSL matrices are column-major."""
    values = ", ".join(f"{value:.9g}" for value in matrix.T.flat)
    return (
        glsl.replace(_FUNCTION, "srgb_view")
        + f"\nvec4 {_FUNCTION}(vec4 light) {{\n"
        + f"    return srgb_view(vec4(mat3({values}) * light.rgb, light.a));\n}}\n"
    )


def _encoder_after(matrix: Matrix) -> Callable[[FloatImage], FloatImage]:
    def encode(light: FloatImage) -> FloatImage:
        finite = np.clip(np.nan_to_num(light, nan=0.0), -LIGHT_MAX, LIGHT_MAX)
        return srgb_encoded(finite @ matrix.T.astype(np.float32))

    return encode


def view_transform(
    config: ColorConfig,
    display: str,
    view: str,
    input_space: str,
    turned_from: Primaries | None = None,
    grade: Grade | None = None,
) -> ViewTransform:
    """Return the transform of `view` on `display` for light in `input_space`.

    `turned_from`: the light's own primaries, if it must first be converted to linear Rec. 709.
    `grade`: applied before the view, but for views of raw numbers.
    Raises InputError if the config lacks one of the names or cannot build the transform.
    """
    check_known(f"{config.source}: view of {display}", view, config.views(display))
    library = ocio()
    try:
        parts = [] if turned_from is None else [_matrix_transform(library, turned_from)]
        space = input_space
        if grade is not None and not config.is_data_view(display, view):
            space = config.grading_space(input_space)
            parts.append(library.ColorSpaceTransform(src=input_space, dst=space))
            parts.append(_grade_transform(library, grade))
        parts.append(library.DisplayViewTransform(src=space, display=display, view=view))
        processor = config.config.getProcessor(library.GroupTransform(parts))
        glsl, luts, key = _for_gpu(library, processor)
        on_cpu = processor.getDefaultCPUProcessor()
    except (library.Exception, library.ExceptionMissingFile) as error:
        raise InputError(
            f"{config.source}: {view} on {display} from {input_space} cannot be built: "
            f"{one_line(error)}"
        ) from error
    return ViewTransform(display, view, input_space, key, glsl, luts, _encoder(on_cpu))


def _grade_transform(library: ModuleType, grade: Grade) -> object:
    slope, offset, power = map(list, (grade.slope, grade.offset, grade.power))
    return library.CDLTransform(slope=slope, offset=offset, power=power, sat=grade.saturation)


def _matrix_transform(library: ModuleType, primaries: Primaries) -> object:
    """Return the transform from light of these primaries to linear Rec. 709."""
    matrix = np.eye(4)
    matrix[:3, :3] = to_rec709(primaries)
    return library.MatrixTransform(matrix=matrix.ravel().tolist())


def _encoder(on_cpu: Any) -> Callable[[FloatImage], FloatImage]:
    def encode(light: FloatImage) -> FloatImage:
        shown = np.array(light, np.float32, order="C")  # because the library writes in place
        on_cpu.applyRGB(shown)
        return shown

    return encode


# Every file gets its values by this shader too, not by OpenColorIO on the CPU: both differ in about
# one pixel of 1,500 by one code, and the shader took 0.2 s where the CPU took 1.3 s for a picture
# in high definition.
def _for_gpu(library: ModuleType, processor: Any) -> tuple[str, tuple[Lut, ...], str]:
    """Return GLSL, its tables, and a key that identifies both."""
    on_gpu = processor.getDefaultGPUProcessor()
    shader = library.GpuShaderDesc.CreateShaderDesc(
        language=library.GPU_LANGUAGE_GLSL_4_0, functionName=_FUNCTION, resourcePrefix="ocio_"
    )
    shader.setAllowTexture1D(False)  # the GPU binds none; the picture would be black
    on_gpu.extractGpuShaderInfo(shader)
    luts = [_lut(t, (t.edgeLen,) * 3 + (3,), library) for t in shader.get3DTextures()]
    for table in shader.getTextures():
        is_red = table.channel == library.GpuShaderDesc.TEXTURE_RED_CHANNEL
        size = (max(table.height, 1), table.width)
        luts.append(_lut(table, size if is_red else (*size, 3), library))
    glsl = str(shader.getShaderText())
    for lut in luts:
        glsl = glsl.replace(lut.sampler.removesuffix("_tx"), lut.sampler)
    return glsl, tuple(luts), str(on_gpu.getCacheID())


def _lut(table: Any, shape: tuple[int, ...], library: ModuleType) -> Lut:
    values = np.array(table.getValues(), np.float32).reshape(shape)
    is_linear = table.interpolation != library.INTERP_NEAREST
    return Lut(f"{table.samplerName}_tx", values, is_linear)
