"""A headless OpenGL 4.3 context: EGL, no display, a GPU or Mesa's software rasteriser."""

from typing import Any

import moderngl

from heatlens.errors import GpuError

_EGL: dict[str, Any] = {"backend": "egl"}  # reaches glcontext; moderngl's stub has no name for it
_HELP = "On Debian or Ubuntu: apt-get install libgl1 libegl1"


def headless_context() -> moderngl.Context:
    """A context that needs no window; raises GpuError that says what to install."""
    try:
        ctx = moderngl.create_context(standalone=True, require=430, **_EGL)
    except Exception as error:  # moderngl and glcontext raise bare Exception
        raise GpuError(f"No OpenGL 4.3 ({error}). {_HELP}") from error
    return ctx


def is_software(ctx: moderngl.Context) -> bool:
    """True on a software rasteriser: timer queries lie there, shared memory is plain memory."""
    renderer = str(ctx.info["GL_RENDERER"]).lower()
    return any(name in renderer for name in ("llvmpipe", "softpipe", "swrast", "swiftshader"))


def check_picture_fits(ctx: moderngl.Context, width: int, height: int) -> None:
    """Refuse a picture with a side over the largest texture: moderngl itself would not complain."""
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise GpuError(
            f"The picture is {width}x{height}; this OpenGL ({ctx.info['GL_RENDERER']}) "
            f"takes at most {limit} pixels a side. A smaller --proxy fits."
        )
