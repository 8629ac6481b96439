"""Write the surfaces that were found behind a plate, as a picture that --behind reads."""

from collections.abc import Sequence
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.plate.exr.exr_write import write_exr
from heatlens.plate.plate import FloatImage, Plate
from heatlens.sequence.names import form_of, parse_pattern


def behind_path(pattern: Path, plate: Path) -> Path:
    """Return the file for a plate: a pattern takes the frame number in the plate's name.

    Raises InputError for a name that is not an EXR, and where the plate has no number.
    """
    if pattern.suffix.lower() != ".exr":
        raise InputError(f"{pattern}: --behind-out writes an EXR file, because it has a depth.")
    notation, frame = parse_pattern(pattern.name), form_of(plate.name)[1]
    if notation is None:
        return pattern
    if frame is None:
        raise InputError(f"{plate} has no frame number for {pattern}: name one file.")
    return pattern.with_name(notation[0].name_at(frame))


def write_behind(path: Path, layers: Sequence[Plate]) -> None:
    """Write R, G, B, A and Z of the nearest surfaces, and of the next as a layer `behind`.

    Raises InputError if there are none, or the file cannot be written.
    """
    if not layers:
        raise InputError(f"{path} is not written: no neighbouring frame shows a hidden surface.")
    channels: dict[str, FloatImage] = {}
    for layer, plate in zip(("", "behind."), layers, strict=False):
        assert plate.depth_m is not None
        channels |= {f"{layer}{name}": plate.color[..., at] for at, name in enumerate("RGBA")}
        channels[f"{layer}Z"] = plate.depth_m
    first = layers[0]
    windows = first.data_window, first.display_window
    write_exr(path, channels, *windows, first.pixel_aspect_ratio, first.attributes, half=False)
