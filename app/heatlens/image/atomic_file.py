"""Files appear whole or not at all: written beside the target, then renamed over it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from heatlens.errors import InputError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A path to write to; it takes the place of `path` when the block ends well, else it goes.

    What stood at `path` stays until then. A link keeps pointing where it did.
    Raises InputError where nothing can be written there.
    """
    target = Path(os.path.realpath(path))
    _check_target(target)
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield beside
        os.replace(beside, target)
    except (OSError, RuntimeError) as error:  # RuntimeError is what OpenEXR raises
        raise InputError(f"{target} could not be written: {error}") from error
    finally:
        beside.unlink(missing_ok=True)


def _check_target(target: Path) -> None:
    """Refuse what a rename would fail on, or destroy: folders and devices."""
    if not target.parent.is_dir():
        raise InputError(f"{target} cannot be written: the folder {target.parent} does not exist.")
    if target.exists() and not target.is_file():
        raise InputError(
            f"{target} cannot be written: it is a folder or a device, not a file. "
            "Give the name of a file."
        )
