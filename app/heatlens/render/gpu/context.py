"""Make the device that the program draws with, and check that its limits suffice."""

import os
from enum import Enum

from heatlens.core.base.errors import GpuError, InputError, MissingPackageError
from heatlens.core.base.extras import OnUse, extra
from heatlens.core.base.memory import free_memory_bytes
from heatlens.render.gpu.device import Device

# Read here, and in processes that this one starts; glcontext reads the second one too.
_GPU, _DEVICE = "HEATLENS_GPU", "GLCONTEXT_DEVICE_INDEX"
_opengl_device = OnUse("render.gpu.opengl.gl_device", "headless_device")
_wgpu_device = OnUse("render.gpu.wgpu.wgpu_device", "headless_device")


class Gpu(Enum):
    """The graphics library that draws."""

    AUTO = "auto"  # OpenGL where it has version 4.3, else wgpu
    OPENGL = "opengl"
    WGPU = "wgpu"  # Vulkan, Metal or Direct3D 12


def choose_gpu(gpu: Gpu) -> None:
    """Let all devices draw with `gpu`, in new processes of this one too."""
    os.environ[_GPU] = gpu.value


def choose_device(number: int) -> None:
    """Let devices use the one of this `number`, in new processes of this one too.

    Devices are counted from 0, by EGL or by wgpu. Raises InputError for a number below it.
    """
    if number < 0:
        raise InputError(f"--device counts from 0, got {number}.")
    os.environ[_DEVICE] = str(number)


def chosen_gpu() -> Gpu:
    """Return what was chosen. Raises InputError for an environment that names another library."""
    name = os.environ.get(_GPU) or Gpu.AUTO.value
    if name not in {gpu.value for gpu in Gpu}:
        names = ", ".join(gpu.value for gpu in Gpu)
        raise InputError(f"{_GPU} is {name!r}; it can be one of {names}.")
    return Gpu(name)


def library_of(device: Device) -> Gpu:
    """Return the library that a device belongs to."""
    return Gpu(device.library.lower())


def headless_context() -> Device:
    """Make a device that needs no window. Raises GpuError that says what to install."""
    gpu = chosen_gpu()
    if gpu is Gpu.WGPU:
        return new_wgpu_device()
    try:
        return _new_opengl_device()
    except GpuError as error:
        if gpu is Gpu.OPENGL:
            raise
        try:
            return new_wgpu_device()
        except (GpuError, MissingPackageError):
            raise error from None  # what to install for OpenGL helps more


def _new_opengl_device() -> Device:
    device: Device = _opengl_device()
    return device


def new_wgpu_device() -> Device:
    """Make a device of wgpu. Raises GpuError where it is not installed or finds no device."""
    with extra("wgpu").require():
        device: Device = _wgpu_device(int(os.environ.get(_DEVICE) or 0))
    return device


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
            f"The plate is {width}x{height}; this {ctx.library} ({ctx.name}) takes at most "
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
            f"{needed[1]}; this {ctx.library} takes {limit} pixels a side. A smaller --proxy fits."
        )


def check_work_fits(ctx: Device, width: int, height: int) -> None:
    """Raise GpuError for a picture too large for OpenGL's storage blocks or the free memory.

    The memory counts only where the processor draws.
    """
    list_limit = ctx.limits.storage_block_bytes // 4 - 4  # a word a pixel
    if width * height > list_limit:
        raise GpuError(
            f"The picture has {width * height / 1e6:.1f} million pixels; this {ctx.library}'s "
            f"storage blocks hold {list_limit / 1e6:.1f} million. A smaller --proxy fits."
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
            f"There are {size_bytes / 1e6:.0f} MB of {content}; this {ctx.library}'s storage "
            f"blocks hold {limit / 1e6:.0f} MB. A smaller picture or fewer surfaces fit."
        )
