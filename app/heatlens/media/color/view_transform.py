"""The view transform from scene-linear light to display values, for the GPU and the CPU.

On the GPU it is GLSL with tables. On both, light is multiplied by 2^exposure_stops and transformed,
and the result is raised to the power 1/gamma.
"""

import re
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
from heatlens.media.color.color_config import ColorConfig, check_known, error_text
from heatlens.media.plate.header.primaries import KNOWN, REC709, XYZ, Primaries
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.plate import FloatImage

Matrix = npt.NDArray[np.floating[Any]]

_BRADFORD: Matrix = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)


def to_rec709(primaries: Primaries) -> Matrix:
    """Return the matrix (3, 3) that converts columns of light to linear Rec. 709.

    White stays white; the D65 white of XYZ becomes white.
    """
    xyz_to_rec709: Matrix = np.linalg.inv(_to_xyz(REC709))
    if primaries == XYZ:
        return xyz_to_rec709
    matrix: Matrix = (
        xyz_to_rec709 @ _adapt_white(_white_xyz(primaries), _white_xyz(REC709)) @ _to_xyz(primaries)
    )
    return matrix


def _to_xyz(primaries: Primaries) -> Matrix:
    """Return the matrix (3, 3) from linear RGB of these primaries to XYZ; white has Y = 1."""
    red, green, blue, _ = np.reshape(primaries.chromaticities, (4, 2))
    columns = np.stack([_xyz(*xy) for xy in (red, green, blue)], axis=1)
    matrix: Matrix = columns * np.linalg.solve(columns, _white_xyz(primaries))
    return matrix


def _white_xyz(primaries: Primaries) -> Matrix:
    """Return the XYZ of the white with Y = 1."""
    x, y = primaries.chromaticities[6:]
    return _xyz(x, y) / y


def _xyz(x: float, y: float) -> Matrix:
    """Return the XYZ of a chromaticity, scaled so that X + Y + Z = 1.

    Y is not scaled to 1, because the blue of AP0 has almost no luminance.
    """
    return np.array([x, y, 1.0 - x - y])


def _adapt_white(white: Matrix, target_white: Matrix) -> Matrix:
    """Return the Bradford matrix (3, 3) that adapts XYZ from one white to another."""
    gain = (_BRADFORD @ target_white) / (_BRADFORD @ white)
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


_ARRAY = re.compile(r"const float (?P<name>\w+)\[\d+\] = float\[\d+\]\((?P<numbers>[^)]*)\);")


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
        display_values = self.encode(np.float32(2.0**exposure_stops) * light.astype(np.float32))
        if gamma == 1.0:
            return display_values
        gamma_applied: FloatImage = np.sign(display_values) * np.abs(display_values) ** np.float32(
            1.0 / gamma
        )
        return gamma_applied


def srgb_transform(
    input_space: str = REC709.name, source_primaries: Primaries | None = None
) -> ViewTransform:
    """Return the plain curve of IEC 61966-2-1, clipped at white; it needs no library.

    `input_space`: name of one of the primaries in `plate.primaries`; raises InputError for others.
    `source_primaries`: the light's own primaries, where they have no name.
    """
    check_known(
        "Input space", input_space, tuple(named_primaries.name for named_primaries in KNOWN)
    )
    glsl = (data_dir("shaders") / "lib" / "srgb_view.lib.glsl").read_text(encoding="utf-8")
    encode: Callable[[FloatImage], FloatImage] = encode_srgb
    key = "sRGB"
    if source_primaries is not None or input_space != REC709.name:
        primaries = source_primaries or next(
            named_primaries for named_primaries in KNOWN if named_primaries.name == input_space
        )
        key = f"sRGB of {primaries.name} {primaries.chromaticities}"
        matrix = to_rec709(primaries)
        glsl, encode = _prepend_matrix(glsl, matrix), _encoder_with_matrix(matrix)
    return ViewTransform(
        display="sRGB",
        view=PLAIN_VIEW,
        input_space=input_space,
        key=key,
        glsl=glsl,
        luts=(),
        encode=encode,
    )


def _prepend_matrix(glsl: str, matrix: Matrix) -> str:
    """Return the same GLSL with a matrix applied first. GLSL matrices are column-major."""
    values = ", ".join(f"{value:.9g}" for value in matrix.T.flat)
    return (
        glsl.replace(_FUNCTION, "srgb_view")
        + f"\nvec4 {_FUNCTION}(vec4 light) {{\n"
        + f"    return srgb_view(vec4(mat3({values}) * light.rgb, light.a));\n}}\n"
    )


def _encoder_with_matrix(matrix: Matrix) -> Callable[[FloatImage], FloatImage]:
    """Return a function that applies a matrix and then the sRGB curve to light (H, W, 3)."""

    def encode(light: FloatImage) -> FloatImage:
        finite = np.clip(np.nan_to_num(light, nan=0.0), -LIGHT_MAX, LIGHT_MAX)
        return encode_srgb(finite @ matrix.T.astype(np.float32))

    return encode


def view_transform(
    config: ColorConfig,
    display: str,
    view: str,
    input_space: str,
    source_primaries: Primaries | None = None,
    grade: Grade | None = None,
) -> ViewTransform:
    """Return the transform of `view` on `display` for light in `input_space`.

    `source_primaries`: the light's own, if it must first be converted to linear Rec. 709.
    `grade`: applied before the view, except for views of raw numbers.
    Raises InputError if the config lacks one of the names or cannot build the transform.
    """
    check_known(f"{config.source}: view of {display}", view, config.views(display))
    library = ocio()
    try:
        transforms = (
            [] if source_primaries is None else [_matrix_transform(library, source_primaries)]
        )
        grading_space = input_space
        if grade is not None and not config.is_data_view(display, view):
            grading_space = config.grading_space(input_space)
            transforms.append(library.ColorSpaceTransform(src=input_space, dst=grading_space))
            transforms.append(_grade_transform(library, grade))
        transforms.append(
            library.DisplayViewTransform(src=grading_space, display=display, view=view)
        )
        processor = config.config.getProcessor(library.GroupTransform(transforms))
        glsl, luts, key = _gpu_shader(library, processor)
        cpu_processor = processor.getDefaultCPUProcessor()
    except (library.Exception, library.ExceptionMissingFile) as error:
        raise InputError(
            f"{config.source}: the view {view} on {display} cannot be used with {input_space} "
            f"({error_text(error)}). Choose another --view or --display, or mend the config."
        ) from error
    encode = _cpu_encoder(cpu_processor)
    return ViewTransform(display, view, input_space, key=key, glsl=glsl, luts=luts, encode=encode)


def _grade_transform(library: ModuleType, grade: Grade) -> object:
    """Return the CDL of a grade as a transform of the OpenColorIO library."""
    slope, offset, power = map(list, (grade.slope, grade.offset, grade.power))
    return library.CDLTransform(slope=slope, offset=offset, power=power, sat=grade.saturation)


def _matrix_transform(library: ModuleType, primaries: Primaries) -> object:
    """Return the transform from light of these primaries to linear Rec. 709."""
    matrix = np.eye(4)
    matrix[:3, :3] = to_rec709(primaries)
    return library.MatrixTransform(matrix=matrix.ravel().tolist())


def _cpu_encoder(cpu_processor: Any) -> Callable[[FloatImage], FloatImage]:
    """Return a function that converts light (H, W, 3) by OpenColorIO's processor."""

    def encode(light: FloatImage) -> FloatImage:
        """Return the display values of scene-linear light."""
        display_values = np.array(
            light, np.float32, order="C"
        )  # because the library writes in place
        cpu_processor.applyRGB(display_values)
        return display_values

    return encode


# Files get their values by this shader too, not by OpenColorIO on the CPU: the shader takes 0.2 s
# for a picture in high definition, the CPU 1.3 s. They differ in about one pixel of 1,500 by one
# code.
def _gpu_shader(library: ModuleType, processor: Any) -> tuple[str, tuple[Lut, ...], str]:
    """Return the GLSL of an OpenColorIO processor, its tables, and a key that identifies both."""
    gpu_processor = processor.getDefaultGPUProcessor()
    shader = library.GpuShaderDesc.CreateShaderDesc(
        language=library.GPU_LANGUAGE_GLSL_4_0, functionName=_FUNCTION, resourcePrefix="ocio_"
    )
    shader.setAllowTexture1D(False)  # the GPU binds none; the picture would be black
    gpu_processor.extractGpuShaderInfo(shader)
    luts = [
        _to_lut(table_3d, (table_3d.edgeLen,) * 3 + (3,), library)
        for table_3d in shader.get3DTextures()
    ]
    for table in shader.getTextures():
        is_red = table.channel == library.GpuShaderDesc.TEXTURE_RED_CHANNEL
        size = (max(table.height, 1), table.width)
        luts.append(_to_lut(table, size if is_red else (*size, 3), library))
    glsl = str(shader.getShaderText())
    for lut in luts:
        glsl = glsl.replace(lut.sampler.removesuffix("_tx"), lut.sampler)
    glsl, arrays = _arrays_as_luts(glsl)
    return glsl, (*luts, *arrays), str(gpu_processor.getCacheID())


# ACES 2.0 searches an array of 363 numbers. Translated by wgpu, it is copied for each element that
# is read: a small picture took minutes.
def _arrays_as_luts(glsl: str) -> tuple[str, list[Lut]]:
    """Return GLSL in which each constant array of numbers is a table."""
    luts = []
    for declaration in _ARRAY.finditer(glsl):
        name = declaration["name"]
        numbers = [float(word) for word in declaration["numbers"].split(",")]
        luts.append(Lut(f"{name}_tx", np.array([numbers], np.float32), is_linear=False))
        glsl = glsl.replace(declaration[0], f"uniform sampler2D {name}_tx;")
        element = re.compile(rf"\b{name}\[([^\]]+)\]")
        glsl = element.sub(rf"texelFetch({name}_tx, ivec2(\1, 0), 0).r", glsl)
    return glsl, luts


def _to_lut(table: Any, shape: tuple[int, ...], library: ModuleType) -> Lut:
    """Return a table of OpenColorIO as an array of this shape, with the name of its sampler."""
    values = np.array(table.getValues(), np.float32).reshape(shape)
    is_linear = table.interpolation != library.INTERP_NEAREST
    return Lut(f"{table.samplerName}_tx", values, is_linear)
