"""`heatlens bench`: how long a frame takes on this machine, and where the time goes."""

import argparse
import sys
import time
from statistics import median

from heatlens.bench.synthetic_plate import LENS, scene_plate
from heatlens.commands.render import add_blur_options, settings_of
from heatlens.gpu.context import headless_context
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `bench` to the command line."""
    parser = commands.add_parser("bench", help="measure how long a frame takes on this machine")
    add_blur_options(parser)
    parser.add_argument("--runs", type=int, default=5, help="frames to take the median of")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Render a synthetic plate `runs` times after a warm-up; print the median."""
    renderer = FrameRenderer(headless_context())
    renderer.load(scene_plate((1920, 1080)))
    shot = Shot(LENS, settings_of(args))
    seconds = []
    for _ in range(args.runs + 1):
        start = time.perf_counter()
        renderer.render(shot)
        renderer.ctx.finish()
        seconds.append(time.perf_counter() - start)
    print(f"heatlens: {renderer.ctx.info['GL_RENDERER']}", file=sys.stderr)
    print(f"frame {1e3 * median(seconds[1:]):.1f} ms")
    return 0
