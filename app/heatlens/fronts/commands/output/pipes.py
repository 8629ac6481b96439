"""Accept `-` for a file: standard input as a plate, standard output for a picture."""

import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.stopping import mark_unfinished
from heatlens.media.files.picture_formats import FORMATS

DASH = "-"


@contextmanager
def stdin_as_file(path: Path) -> Iterator[Path]:
    """Yield `path`; for `-` a temporary file with the content of standard input.

    Raises InputError if it is not a picture, or if standard input is a terminal.
    """
    if str(path) != DASH:
        yield path
        return
    if sys.stdin is None or sys.stdin.isatty():
        raise InputError("The name - is standard input, but nothing is piped into it.")
    from heatlens.media.files.opened_by_ending import suffix_of_content

    with _temporary_folder() as folder:
        data = sys.stdin.buffer.read()
        suffix = suffix_of_content(data)
        if not suffix:
            format_names = ", ".join(it.word for it in FORMATS if it.begins)
            fault = (
                "is empty" if not data else f"is neither an EXR nor one of these: {format_names}"
            )
            raise InputError(f"Standard input {fault}.")
        spooled = folder / f"stdin{suffix}"
        spooled.write_bytes(data)
        yield spooled


@contextmanager
def file_for_output(path: Path) -> Iterator[Path]:
    """Yield `path`; for `-` an EXR to write, which then goes to standard output.

    Raises InputError if that is a terminal.
    """
    if str(path) != DASH:
        yield path
        return
    if sys.stdout.isatty():
        raise InputError(
            "The name - is standard output, and a terminal cannot show an EXR: pipe it into a "
            "program or file."
        )
    with _temporary_folder() as folder:
        spooled = folder / "stdout.exr"
        yield spooled
        sys.stdout.buffer.write(spooled.read_bytes())
        sys.stdout.buffer.flush()


@contextmanager
def _temporary_folder() -> Iterator[Path]:
    """Yield a temporary folder, and remove it in any case."""
    folder = Path(tempfile.mkdtemp(prefix="heatlens-"))
    with mark_unfinished(folder):
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)
