"""`heatlens render`: one plate through a lens, to an EXR or a PNG."""

import argparse
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

from heatlens.commands.layer_progress import layer_progress
from heatlens.commands.lens_options import add_lens_options, lens_of
from heatlens.commands.plate_options import add_plate_options, plate_options
from heatlens.errors import InputError
from heatlens.gpu.context import headless_context
from heatlens.gpu.textures import FloatArray
from heatlens.image.exr_read import read_plate
from heatlens.image.exr_write import lens_attributes, write_exr
from heatlens.image.plate import Plate
from heatlens.image.png_write import write_png
from heatlens.model.boxes import Box
from heatlens.model.lens import Lens
from heatlens.model.settings import LAYERS_MAX, PROXY_MIN, Bokeh, DefocusSettings, Quality
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer

_SUFFIXES = (".exr", ".png")
_DESCRIPTION = """\
Puts a lens in front of a pinhole plate (EXR with colour and depth) and writes the picture:
EXR scene-linear with the lens in its header, or PNG for a look.
"""
_EPILOG = """\
examples:
  heatlens render plate.exr -o out.exr --f-stop 2 --focus-distance 2.24 \\
      --focal-length 50 --sensor-width 36
  heatlens render plate.exr -o out.png --focus-at 960,540 --f-stop 1.4
  heatlens render plate.exr -o quick.png --f-stop 2 --focus-distance 6'3" \\
      --quality draft --proxy 0.5
"""


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `render` to the command line."""
    parser = commands.add_parser(
        "render",
        help="render a plate with depth of field",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("plate", type=Path, help="EXR with colour and depth")
    parser.add_argument("-o", "--output", type=Path, required=True, help=".exr or .png to write")
    add_lens_options(parser)
    add_blur_options(parser)
    add_plate_options(parser)
    parser.add_argument("--float", action="store_true", help="32-bit float EXR (default: half)")
    parser.add_argument("--stats", action="store_true", help="say where the time goes")
    parser.set_defaults(run=run)


def add_blur_options(parser: argparse.ArgumentParser) -> None:
    """--bokeh, --quality, --layers, --proxy."""
    group = parser.add_argument_group("blur", "How it is computed, never how much of it there is.")
    group.add_argument(
        "--bokeh",
        choices=[str(bokeh) for bokeh in Bokeh],
        default=str(Bokeh.DISC),
        help="shape of a point of light: disc as a lens (default), gaussian, or heat, "
        "the fastest, a four-pointed star",
    )
    group.add_argument(
        "--quality",
        choices=[str(quality) for quality in Quality],
        default=str(Quality.FILM),
        help="how closely that shape is met; the amount of blur is the same (default film)",
    )
    group.add_argument(
        "--layers",
        type=int,
        metavar="N",
        help=f"depth layers, 1 (nothing uncovers) to {LAYERS_MAX}; default: as the quality says",
    )
    group.add_argument(
        "--proxy",
        type=float,
        default=1.0,
        metavar="SCALE",
        help=f"work on a smaller picture, {PROXY_MIN:g} to 1; blur scales with it",
    )


def settings_of(args: argparse.Namespace) -> DefocusSettings:
    """The blur options as a value."""
    return DefocusSettings(Bokeh(args.bokeh), Quality(args.quality), args.layers, args.proxy)


def run(args: argparse.Namespace) -> int:
    """Read, render, write; say what was decided on the way."""
    start = time.perf_counter()
    _check_output(args.output, args.plate)
    settings = settings_of(args)
    plate = read_plate(args.plate, plate_options(args))
    lens, said = lens_of(args, plate)
    depth = plate.depth
    _say(f"depth: {depth.channel} taken as {depth.convention}, {depth.kind}. {depth.why}")
    _say(*plate.notes, "lens: " + ", ".join(said))
    read_done = time.perf_counter()
    renderer = FrameRenderer(headless_context())
    renderer.stopwatch.on = args.stats
    renderer.load(plate)
    with layer_progress(renderer):
        pixels = renderer.pixels(Shot(lens, settings))
    render_done = time.perf_counter()
    write_picture(args, plate, lens, pixels)
    if args.stats:
        _say_stats(renderer, (start, read_done, render_done, time.perf_counter()))
    print(args.output)
    return 0


def write_picture(args: argparse.Namespace, plate: Plate, lens: Lens, pixels: FloatArray) -> None:
    """Write `pixels` (H, W, 4) as the suffix of --output asks."""
    if args.output.suffix.lower() == ".png":
        write_png(args.output, pixels if plate.has_alpha else pixels[..., :3])
        return
    names = "RGBA" if plate.has_alpha else "RGB"
    write_exr(
        args.output,
        {name: pixels[..., i] for i, name in enumerate(names)},
        _scaled(plate.data_window, args.proxy, pixels.shape[1::-1]),
        _scaled(plate.display_window, args.proxy),
        plate.pixel_aspect_ratio,
        plate.attributes | _lens_header(plate, lens),
        half=not args.float,
    )


def _lens_header(plate: Plate, lens: Lens) -> dict[str, Any]:
    """The lens as header attributes; none where the plate brought its circle of confusion.

    The height of the sensor is known only to the header, and only for the width that it tells.
    """
    if plate.coc_px is not None:
        return {}
    camera = plate.camera
    height_mm = camera.sensor_height_mm if camera.sensor_width_mm == lens.sensor_width_mm else None
    return lens_attributes(
        lens.focal_length_mm, lens.f_stop, lens.focus_distance_m, lens.sensor_width_mm, height_mm
    )


def _scaled(box: Box, scale: float, size: tuple[int, ...] | None = None) -> Box:
    """A window at proxy size; the data window's size is the picture's own."""
    x0, y0 = round(box.x0 * scale), round(box.y0 * scale)
    width, height = size or (max(1, round(box.width * scale)), max(1, round(box.height * scale)))
    return Box(x0, y0, x0 + width, y0 + height)


def _check_output(path: Path, plate: Path) -> None:
    """What would only fail after the rendering, or destroy what is rendered."""
    if path.suffix.lower() not in _SUFFIXES:
        raise InputError(f"{path}: the output must end in {' or '.join(_SUFFIXES)}.")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}.")
    if path.is_dir():
        raise InputError(f"{path} is a folder: give the name of a file to write.")
    if path.exists() and plate.exists() and path.samefile(plate):
        raise InputError(f"{path} is the plate itself: give another name for the output.")


def _say(*sentences: str) -> None:
    for sentence in sentences:
        print(f"heatlens: {sentence}", file=sys.stderr)


def _say_stats(renderer: FrameRenderer, at: tuple[float, float, float, float]) -> None:
    read, render, write = (1e3 * (b - a) for a, b in pairwise(at))
    _say(f"read {read:.0f} ms, render {render:.0f} ms, write {write:.0f} ms")
    _say(f"on {renderer.ctx.info['GL_RENDERER']}, solver {renderer.solver.name}")
    for name, entry in renderer.stopwatch.times.items():
        _say(f"  {name:24} {1e3 * entry.seconds:8.1f} ms  {entry.runs:3d} x")
