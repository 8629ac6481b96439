"""Read a picture file as the opening of a lens, also those that shots and lens kits name.

The paths in shots and kits are relative to the folders of their files.
"""

import hashlib
import math
import os
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import unreadable
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import LensKit
from heatlens.core.model.lens.opening_image import IMAGE_SIDE, OpeningImage, seen_light
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.header.channel_choice import choose_color
from heatlens.media.plate.header.channels import pixels_of
from heatlens.media.plate.read import color_file_parts

_RED, _GREEN, _BLUE = 0.2126, 0.7152, 0.0722  # weights of the luminance of Rec. 709
_COLORED = 0.02  # share of the brightest value: JPEG leaves grey slightly coloured
_NEAR_AXIS = 0.03  # in radii; a smaller distance from the axis is invisible
_DIGEST_BYTES = 16


def read_opening_image(path: str | os.PathLike[str]) -> OpeningImage:
    """Read the light that an opening lets through; `path` becomes absolute.

    The picture is centred in a square and scaled to IMAGE_SIDE cells on a side. Colours count by
    their luminance; transparent pixels are dark. A file that has not changed is not read again.

    Raises InputError that names the file where it cannot be read, holds no numbers, or lets no
    light through.
    """
    path = Path(os.path.abspath(path))
    try:
        status = path.stat()
    except OSError as error:
        raise unreadable(path, error) from error
    except ValueError:  # NUL, or what no file system can encode
        raise unreadable(path) from None
    return _read(path, (status.st_mtime_ns, status.st_size))


def opening_notes(image: OpeningImage, has_blades: bool) -> tuple[str, ...]:
    """Return the notes on an aperture image; `has_blades` if the lens has blades set."""
    unused = "The aperture image replaces the blades, which have no effect."
    return (unused, *image.notes) if has_blades else image.notes


@lru_cache(maxsize=8)
def _read(path: Path, stamp: tuple[int, int]) -> OpeningImage:
    """Read a file that has this time and size."""
    luminance, notes = _luminance(path)
    if not np.isfinite(luminance).all():
        raise InputError(
            f"{path} cannot be an aperture image: some of its pixels are not finite numbers (NaN "
            "or infinity)."
        )
    light = _in_square(np.maximum(luminance, 0.0))
    if seen_light(light).max() <= 0.0:
        raise InputError(
            f"{path} cannot be an aperture image: it is black inside the circle of the lens, so "
            "no light passes; the opening is the bright part of the picture."
        )
    light /= light.max()
    notes = (*notes, *_off_axis(path, light))
    digest = hashlib.blake2b(light.tobytes(), digest_size=_DIGEST_BYTES).hexdigest()
    return OpeningImage(str(path), digest, light, notes)


def _off_axis(path: Path, light: NDArray[np.float32]) -> tuple[str, ...]:
    """Return a note if the light is off-centre about the axis of the lens."""
    inside = seen_light(light)
    at = (np.arange(IMAGE_SIDE) + 0.5) * 2 / IMAGE_SIDE - 1
    x, y = (float((inside.sum(axis=axis) * at).sum() / inside.sum()) for axis in (0, 1))
    off = math.hypot(x, y)
    if off < _NEAR_AXIS:
        return ()
    return (
        (
            f"{path}: the centre of its light is {100 * off:.0f} % of the radius off the centre of "
            "the picture: lamps and the other methods show that, but diffusion blurs about the "
            "centre of the picture."
        ),
    )


def _luminance(path: Path) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Return the light (H, W) of a picture, and the notes on it."""
    parts = color_file_parts(path, PlateOptions())
    chosen = choose_color(path, [header for header, _ in parts], None)
    red, green, blue = (pixels_of(parts, ref).astype(np.float32) for ref in chosen.rgb)
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and infinity are reported elsewhere
        luminance = _RED * red + _GREEN * green + _BLUE * blue
        spread = np.maximum(abs(red - green), abs(blue - green)).max()
        is_colored = bool(spread > _COLORED * np.maximum(np.max(luminance), 1e-30))
    note = f"{path}: the aperture image is coloured; its luminance is the light that passes."
    return np.asarray(luminance, np.float32), (note,) if is_colored else ()


def _in_square(light: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the picture centred in a square, averaged into IMAGE_SIDE cells on a side."""
    height, width = light.shape
    side = max(height, width)
    top, left = (side - height) // 2, (side - width) // 2
    square = np.zeros((side, side), np.float32)
    square[top : top + height, left : left + width] = light / max(float(light.max()), 1e-30)
    way = Image.Resampling.BOX if side >= IMAGE_SIDE else Image.Resampling.BILINEAR
    return np.array(Image.fromarray(square).resize((IMAGE_SIDE, IMAGE_SIDE), way), np.float32)


def path_beside(path: str, folder: str | os.PathLike[str]) -> str:
    """Return the path relative to the folder of a file, or absolute where they share none."""
    absolute = os.path.abspath(path)
    try:
        shared = os.path.commonpath([absolute, os.path.abspath(folder)])
    except ValueError:  # on two drives
        return absolute
    if shared == os.path.dirname(shared):
        return absolute
    return Path(os.path.relpath(absolute, folder)).as_posix()


def path_from(path: str, folder: str | os.PathLike[str]) -> str:
    """Return a path that a file in `folder` names as an absolute one."""
    return os.path.abspath(os.path.join(folder, path))


Turned = Callable[[OpeningImage], OpeningImage]


def image_beside(image: OpeningImage, folder: str | os.PathLike[str]) -> OpeningImage:
    """Read an image whose path is relative to `folder`.

    Raises InputError if the file cannot be read or shows no opening.
    """
    return read_opening_image(Path(path_from(image.path, folder)))


def named_beside(image: OpeningImage, folder: str | os.PathLike[str]) -> OpeningImage:
    """Return the image with its path relative to `folder`."""
    return replace(image, path=path_beside(image.path, folder))


def shot_with_images(shot: Shot, turned: Turned) -> Shot:
    """Return the shot with `turned` applied to the images of its lens, looks and kit."""
    looks = tuple(replace(look, lens=_lens_with_image(look.lens, turned)) for look in shot.looks)
    kit = None if shot.kit is None else kit_with_image(shot.kit, turned)
    return replace(shot, lens=_lens_with_image(shot.lens, turned), looks=looks, kit=kit)


def kit_with_image(kit: LensKit, turned: Turned) -> LensKit:
    """Return the kit with `turned` applied to the image of its character."""
    image = kit.character.aperture_image
    if image is None:
        return kit
    return replace(kit, character=replace(kit.character, aperture_image=turned(image)))


def _lens_with_image(lens: Lens, turned: Turned) -> Lens:
    image = lens.aperture_image
    return lens if image is None else replace(lens, aperture_image=turned(image))
