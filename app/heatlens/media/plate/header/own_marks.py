"""Tell of a plate whether it is the picture of a lens already, by the marks of heatlens in it."""

from collections.abc import Mapping
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.media.files.marks import BLURRED_ATTRIBUTE, JOB_ATTRIBUTE, YES
from heatlens.media.plate.header.channels import Header


def is_blurred(header: Mapping[str, object]) -> bool:
    """Return whether the file is marked as one that went through a lens of heatlens."""
    return header.get(BLURRED_ATTRIBUTE) == YES


def blurred_notes(path: Path, header: Header, is_strict: bool = False) -> tuple[str, ...]:
    """Return a sentence if a lens of heatlens has blurred the picture, or may have.

    Raises InputError instead if it has, and `is_strict`. Exports of older versions tell only that
    they are exports, which pinhole plates are too.
    """
    if is_blurred(header):
        told = (
            f"{path} is already blurred: heatlens rendered it through a lens, and another lens "
            "blurs it once more. Give the pinhole picture that it was made from"
        )
        if is_strict:
            raise InputError(f"{told}, or leave --strict out.")
        return (f"{told}.",)
    if JOB_ATTRIBUTE in header and BLURRED_ATTRIBUTE not in header:
        return (
            f"{path} was exported by an older heatlens, which did not tell whether through a lens: "
            "unless it is a pinhole plate, it is already blurred.",
        )
    return ()
