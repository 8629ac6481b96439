"""Make a headless OpenGL 4.3 context with EGL, and check the limits of the machine.

New textures and buffers can be filled with NaN, to find passes that read before they write: Mesa's
llvmpipe returns zeroed memory, other drivers old contents. With HEATLENS_FILL_NAN=1 in the
environment, such a mistake is visible in every picture and test.
"""

import os
import re
from collections.abc import Callable
from typing import Any

import moderngl

from heatlens.base.errors import GpuError, InputError
from heatlens.base.free_memory import free_memory_bytes

_EGL: dict[str, Any] = {"backend": "egl"}  # reaches glcontext; moderngl's stub has no name for it
_DEVICE = "GLCONTEXT_DEVICE_INDEX"  # read by glcontext, here and in processes of this one
_INSTALL = "On Debian or Ubuntu: apt-get install libgl1 libegl1"
_TOO_OLD = (
    "The installed driver has an older version: a newer driver may help, and "
    "LIBGL_ALWAYS_SOFTWARE=1 draws with the processor"
)


def choose_device(number: int) -> None:
    """Let contexts without a window use EGL's device `number`, in new processes of this one too.

    Devices are counted from 0. Raises InputError for a number below it.
    """
    if number < 0:
        raise InputError(f"--device counts from 0, got {number}.")
    os.environ[_DEVICE] = str(number)


def headless_context() -> moderngl.Context:
    """Make a context that needs no window. Raises GpuError that says what to install."""
    try:
        ctx = moderngl.create_context(standalone=True, require=430, **_EGL)
    except Exception as error:  # moderngl and glcontext raise bare Exception
        why = re.sub(r"\b1 devices\b", "1 device", str(error))
        raise GpuError(f"No OpenGL 4.3 ({why}). {_help(why)}") from error
    if os.environ.get(VARIABLE):
        fill_new_with_nan(ctx)
    return ctx


def _help(why: str) -> str:
    """Return what to install, or what to try if the installed driver is too old."""
    if "device index" in why:
        return "--device counts the devices of EGL from 0."
    return _TOO_OLD if "eglCreateContext" in why else _INSTALL


def is_software(ctx: moderngl.Context) -> bool:
    """Return True on a software rasteriser.

    Its timer queries are wrong, and it has no fast memory.
    """
    renderer = str(ctx.info["GL_RENDERER"]).lower()
    return any(name in renderer for name in ("llvmpipe", "softpipe", "swrast", "swiftshader"))


# Measured for a 1920x1080 film render: textures, the plate in both memories, the downloaded result.
BYTES_PER_PIXEL = 300


def check_plate_fits(ctx: moderngl.Context, width: int, height: int) -> None:
    """Refuse a plate with a side over the largest texture; OpenGL would not complain by itself."""
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise GpuError(
            f"The plate is {width}x{height}; this OpenGL ({ctx.info['GL_RENDERER']}) takes at most "
            f"{limit} pixels a side. Scale it down first."
        )


def check_texture_fits(
    ctx: moderngl.Context, picture: tuple[int, int], needed: tuple[int, int]
) -> None:
    """Refuse a picture that needs a texture beyond the largest. Raises GpuError."""
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    if max(needed) > limit:
        raise GpuError(
            f"Blurring a picture of {picture[0]}x{picture[1]} needs a texture of {needed[0]}x"
            f"{needed[1]}; this OpenGL takes {limit} pixels a side. A smaller --proxy fits."
        )


def check_work_fits(ctx: moderngl.Context, width: int, height: int) -> None:
    """Refuse a picture that does not fit OpenGL's storage blocks or the machine's memory."""
    list_limit = int(ctx.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]) // 4 - 4  # a word a pixel
    if width * height > list_limit:
        raise GpuError(
            f"The picture has {width * height / 1e6:.1f} million pixels; this OpenGL's storage "
            f"blocks hold {list_limit / 1e6:.1f} million. A smaller --proxy fits."
        )
    need, free = width * height * BYTES_PER_PIXEL, free_memory_bytes()
    if free is not None and is_software(ctx) and need > free:
        raise GpuError(
            f"The picture needs about {need / 1e9:.1f} GB; {free / 1e9:.1f} GB of memory are free. "
            "A smaller --proxy fits."
        )


def check_storage_fits(ctx: moderngl.Context, size_bytes: int, what: str) -> None:
    """Refuse a buffer beyond OpenGL's storage blocks."""
    limit = int(ctx.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"])
    if size_bytes > limit:
        raise GpuError(
            f"There are {size_bytes / 1e6:.0f} MB of {what}; this OpenGL's storage blocks hold "
            f"{limit / 1e6:.0f} MB. A smaller picture or fewer surfaces fit."
        )


VARIABLE = "HEATLENS_FILL_NAN"
# All bits set: NaN in float16 and float32, the largest number in unsigned integers.
_BYTE = b"\xff"
_SIZES = {"f1": 1, "f2": 2, "f4": 4, "i1": 1, "i2": 2, "i4": 4, "u1": 1, "u2": 2, "u4": 4}
_Texture = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D


def fill_new_with_nan(ctx: moderngl.Context) -> None:
    """Make `ctx` fill all textures and buffers that it creates without content with NaN."""
    made: Any = ctx  # its methods are replaced for this one context
    for name in ("texture", "texture_array", "texture3d"):
        setattr(made, name, _filled(getattr(ctx, name), fill_texture))
    made.buffer = _filled(ctx.buffer, _fill_buffer_always)


def _filled(make: Callable[..., object], fill: Callable[[Any], None]) -> Callable[..., Any]:
    def filling(*args: object, **options: object) -> object:
        made = make(*args, **options)
        content = [it for it in args if not isinstance(it, int | tuple | None)]
        if not content and options.get("data") is None and not options.get("samples"):
            fill(made)
        return made

    return filling


def fill_texture(texture: _Texture) -> None:
    """Write NaN into every texel, or the largest number if these are unsigned integers."""
    texels = 1
    for side in texture.size:
        texels *= side
    texture.write(_BYTE * (texels * texture.components * _SIZES[texture.dtype]))


def fill_buffer(buffer: moderngl.Buffer) -> None:
    """Write NaN into the whole buffer."""
    buffer.write(_BYTE * buffer.size)


def _fill_buffer_always(buffer: Any) -> None:
    """Fill a buffer now, and whenever it is resized, which discards its content."""
    fill_buffer(buffer)
    orphan = buffer.orphan

    def filling(size: int = -1) -> None:
        orphan(size)
        buffer.write(_BYTE * buffer.size)

    buffer.orphan = filling
