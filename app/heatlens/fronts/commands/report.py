"""`heatlens report`: what a bug report needs, in one zip file to read before it is sent."""

import argparse
import io
import os
import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.log import FILE_VARIABLE
from heatlens.core.base.own_command import own_command
from heatlens.core.base.paths import read_file_bytes, reports_dir
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.media.files.atomic_file import write_atomically

DESCRIPTION = """\
Packs what a bug report needs into one zip file: what `heatlens doctor` says, the newest reports of
faults, the log of HEATLENS_LOG, and what `heatlens info` says of your plates. It holds text alone,
with names of files and no pixels. Nothing is sent: read it, then send it to whom you choose.
"""
EPILOG = """\
examples:
  heatlens report -o report.zip plate.exr
  HEATLENS_LOG=heatlens.log heatlens view plate.exr   # first, to have a log of what happens
  HEATLENS_LOG=heatlens.log heatlens report -o report.zip
"""
_MOST_FAULTS = 3  # newest reports of faults
_MOST_LOG_BYTES = 2_000_000  # at the end of the log


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("plates", nargs="*", metavar="PLATE", help="plates, scenes or reels")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE.zip", help="the file to write"
    )
    parser.add_argument(
        "--no-doctor", action="store_true", help="leave out the checks, which take a minute or more"
    )


def run(args: argparse.Namespace) -> int:
    """Write the file, and print what lies in it. Raises InputError for another ending."""
    if args.output.suffix.lower() != ".zip":
        raise InputError(f"{args.output}: the report is a zip file: give a name that ends in .zip.")
    with io.BytesIO() as buffer:
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in _contents(args):
                archive.writestr(name, content)
                print_messages(f"{name}: {len(content):,} bytes")
        write_atomically(args.output, buffer.getvalue())
    print_result(f"{args.output}: text alone; read it before you send it")
    return 0


def _contents(args: argparse.Namespace) -> Iterator[tuple[str, bytes]]:
    """Yield the name and the content of each file of the report."""
    if not args.no_doctor:
        print_messages("heatlens doctor checks this machine, which takes a minute or more")
        yield "doctor.txt", _output_of("doctor")
    for number, plate in enumerate(args.plates, 1):
        yield f"info_{number}.txt", _output_of("info", plate)
    for path in sorted(reports_dir().glob("fault-*.log"))[-_MOST_FAULTS:]:
        yield path.name, read_file_bytes(path)
    log = Path(os.environ.get(FILE_VARIABLE, ""))
    if log.is_file():
        yield "log.txt", read_file_bytes(log)[-_MOST_LOG_BYTES:]


def _output_of(*words: str) -> bytes:
    """Return what a command prints; its own process may crash, which is told as well."""
    process = subprocess.run(own_command(*words), capture_output=True, check=False)
    ending = f"\nheatlens {' '.join(words)}: exit code {process.returncode}\n"
    return process.stdout + process.stderr + ending.encode(errors="replace")
