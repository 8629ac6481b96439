"""The options that choose what draws, for every command that draws."""

import argparse

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.options.value_types import parse_whole_numbers
from heatlens.render.gpu.context import Gpu, choose_device, choose_gpu, chosen_gpu


def add_device_option(group: "argparse._ActionsContainer", has_processes: bool = False) -> None:
    """Add --gpu and --device; a command that `has_processes` can use several devices."""
    group.add_argument(
        "--gpu",
        choices=[gpu.value for gpu in Gpu],
        help="graphics library that draws: opengl, or wgpu (Vulkan, Metal, Direct3D 12); auto, "
        "which is the default, takes wgpu where there is no OpenGL 4.3",
    )
    several_text = "; several share the --processes" if has_processes else ""
    group.add_argument(
        "--device",
        type=parse_whole_numbers,
        default=(),
        metavar="N[,N]" if has_processes else "N",
        help=f"GPU to render with, as EGL or wgpu counts them from 0{several_text}",
    )


def use_device(args: argparse.Namespace) -> None:
    """Choose --gpu and the first of --device. Raises InputError for more devices than processes."""
    if args.gpu is not None:
        choose_gpu(Gpu(args.gpu))
    count, processes = len(args.device), getattr(args, "processes", 1) or 1
    if count > processes:
        advice = (
            "give one" if not hasattr(args, "processes") else f"give --processes {count} or more"
        )
        raise InputError(f"--device names {count} devices: {advice}.")
    if args.device:
        choose_device(args.device[0])


def use_device_of_window(args: argparse.Namespace) -> None:
    """Choose --gpu and --device for a window. Raises InputError for --device without wgpu."""
    use_device(args)
    if args.device and chosen_gpu() is not Gpu.WGPU:
        raise InputError("--device needs --gpu wgpu: OpenGL draws on the GPU of the screen.")
