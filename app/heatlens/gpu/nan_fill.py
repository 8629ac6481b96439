"""Fill new textures and buffers with NaN, to find passes that read before they write.

Mesa's llvmpipe returns zeroed memory, other drivers old contents. With HEATLENS_FILL_NAN=1 in the
environment, such a mistake is visible in every picture and test.
"""

from collections.abc import Callable
from typing import Any

import moderngl

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
        has_content = any(isinstance(a, bytes | memoryview) for a in args) or options.get("data")
        if not has_content and not options.get("samples"):
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
