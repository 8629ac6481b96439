"""Make the device that the program draws with, and check that its limits suffice."""

import os

from heatlens.core.base.errors import GpuError, InputError
from heatlens.core.base.memory import free_memory_bytes
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.opengl import gl_device

_DEVICE = "GLCONTEXT_DEVICE_INDEX"  # read by glcontext, here and in processes of this one


def choose_device(number: int) -> None:
    """Let contexts without a window use EGL's device `number`, in new processes of this one too.

    Devices are counted from 0. Raises InputError for a number below it.
    """
    if number < 0:
        raise InputError(f"--device counts from 0, got {number}.")
    os.environ[_DEVICE] = str(number)


def headless_context() -> Device:
    """Make a device that needs no window. Raises GpuError that says what to install."""
    return gl_device.headless_device()


def window_device() -> Device:
    """Return the device of the current window."""
    return gl_device.window_device()


def is_software(ctx: Device) -> bool:
    """Return True where the processor draws: no fast memory, and timers are wrong."""
    return ctx.is_software


# Measured for a 1920x1080 film render: textures, the plate in both memories, the downloaded result.
BYTES_PER_PIXEL = 300


def check_plate_fits(ctx: Device, width: int, height: int) -> None:
    """Raise GpuError for a plate with a side over the largest texture.

    OpenGL would not complain by itself.
    """
    limit = ctx.limits.texture_side_px
    if max(width, height) > limit:
        raise GpuError(
            f"The plate is {width}x{height}; this OpenGL ({ctx.name}) takes at most "
            f"{limit} pixels a side. Scale it down first."
        )


def check_texture_fits(ctx: Device, picture: tuple[int, int], needed: tuple[int, int]) -> None:
    """Raise GpuError if a picture needs a texture beyond the largest one.

    `picture` is its size, and `needed` that of the texture.
    """
    limit = ctx.limits.texture_side_px
    if max(needed) > limit:
        raise GpuError(
            f"Blurring a picture of {picture[0]}x{picture[1]} needs a texture of {needed[0]}x"
            f"{needed[1]}; this OpenGL takes {limit} pixels a side. A smaller --proxy fits."
        )


def check_work_fits(ctx: Device, width: int, height: int) -> None:
    """Raise GpuError for a picture too large for OpenGL's storage blocks or the free memory.

    The memory counts only where the processor draws.
    """
    list_limit = ctx.limits.storage_block_bytes // 4 - 4  # a word a pixel
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


def check_storage_fits(ctx: Device, size_bytes: int, content: str) -> None:
    """Raise GpuError for a buffer larger than OpenGL's storage blocks.

    `content` names what it holds, for the message.
    """
    limit = ctx.limits.storage_block_bytes
    if size_bytes > limit:
        raise GpuError(
            f"There are {size_bytes / 1e6:.0f} MB of {content}; this OpenGL's storage blocks hold "
            f"{limit / 1e6:.0f} MB. A smaller picture or fewer surfaces fit."
        )
