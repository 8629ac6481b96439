"""The command `heatlens`: chooses the subcommand and turns errors into exit codes.

Exit codes: 0 done, 1 `compare` found the pictures further apart than allowed, 2 something the
user can mend, 130 stopped with Ctrl-C.
"""

import argparse
import sys
from collections.abc import Sequence

from heatlens import __version__
from heatlens.commands import bench, compare, info, render
from heatlens.errors import HeatlensError

_EPILOG = """\
examples:
  heatlens render plate.exr -o out.exr --focal-length 50 --sensor-width 36 --f-stop 2 --focus-distance 2.24
  heatlens render plate.exr -o out.png --focus-at 960,540 --f-stop 1.4
  heatlens info plate.exr
  heatlens compare out.exr truth.exr --min-psnr 30

`heatlens COMMAND --help` explains each command.
"""


def build_parser() -> argparse.ArgumentParser:
    """The whole command line."""
    parser = argparse.ArgumentParser(
        prog="heatlens",
        description="Puts a real lens in front of a pinhole render: depth of field by diffusion.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"heatlens {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in (render, info, compare, bench):
        command.register(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`; returns the exit code."""
    args = build_parser().parse_args(argv)
    try:
        return int(args.run(args))
    except HeatlensError as error:
        print(f"heatlens: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("heatlens: stopped", file=sys.stderr)
        return 130
