"""`heatlens render`: one plate through a lens, to an EXR or a PNG."""

import argparse
import sys
import time
from itertools import pairwise
from pathlib import Path

from heatlens.commands.layer_progress import layer_progress
from heatlens.commands.lens_options import add_lens_options, lens_of
from heatlens.commands.plate_options import add_plate_options, plate_options
from heatlens.defocus.solver_choice import settled_solver
from heatlens.gpu.context import headless_context
from heatlens.image.exr_read import read_plate
from heatlens.image.picture_write import check_output, write_picture
from heatlens.model.settings import LAYERS_MAX, PROXY_MIN, Bokeh, DefocusSettings, Method, Quality
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer

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
  heatlens render plate.exr -o scatter.exr --f-stop 2 --focus-distance 2.24 --method scatter
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
    """--method, --bokeh, --quality, --layers, --proxy."""
    group = parser.add_argument_group("blur", "How it is computed, never how much of it there is.")
    group.add_argument(
        "--method",
        choices=[str(method) for method in Method],
        default=str(Method.DIFFUSION),
        help="diffusion (default) costs the same for every blur, as do heat, its basic form in one "
        "layer, and pyramid, blurred copies at smaller sizes; gather, which averages the disc "
        "around each pixel, and scatter, which draws each pixel as a disc, far to near, cost four "
        "times as much for twice the blur. The last four are for comparison and take neither "
        "--bokeh nor --quality nor --layers",
    )
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
    return DefocusSettings(
        Bokeh(args.bokeh), Quality(args.quality), args.layers, args.proxy, Method(args.method)
    )


def run(args: argparse.Namespace) -> int:
    """Read, render, write; say what was decided on the way."""
    start = time.perf_counter()
    check_output(args.output, args.plate)
    settings = settings_of(args)
    plate = read_plate(args.plate, plate_options(args))
    lens, said = lens_of(args, plate)
    depth = plate.depth
    _say(f"depth: {depth.channel} taken as {depth.convention}, {depth.kind}. {depth.why}")
    _say(*plate.notes, "lens: " + ", ".join(said))
    read_done = time.perf_counter()
    ctx = headless_context()
    renderer = FrameRenderer(ctx, settled_solver(ctx))
    renderer.stopwatch.on = args.stats
    renderer.load(plate)
    with layer_progress(renderer):
        pixels = renderer.pixels(Shot(lens, settings))
    render_done = time.perf_counter()
    write_picture(args.output, pixels, plate, lens, args.proxy, half=not args.float)
    if args.stats:
        _say_stats(renderer, (start, read_done, render_done, time.perf_counter()))
    print(args.output)
    return 0


def _say(*sentences: str) -> None:
    for sentence in sentences:
        print(f"heatlens: {sentence}", file=sys.stderr)


def _say_stats(renderer: FrameRenderer, at: tuple[float, float, float, float]) -> None:
    read, render, write = (1e3 * (b - a) for a, b in pairwise(at))
    _say(f"read {read:.0f} ms, render {render:.0f} ms, write {write:.0f} ms")
    _say(f"on {renderer.ctx.info['GL_RENDERER']}, solver {renderer.solver.name}")
    for name, entry in renderer.stopwatch.times.items():
        _say(f"  {name:24} {1e3 * entry.seconds:8.1f} ms  {entry.runs:3d} x")
