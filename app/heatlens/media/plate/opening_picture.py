"""Read a picture file as the aperture image of a lens.

Shots and lens kits name such files by paths that are relative to their own folders.
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

from heatlens.core.base.errors import InputError
from heatlens.core.base.named_paths import path_in_folder
from heatlens.core.base.paths import unreadable_error
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import LensKit
from heatlens.core.model.lens.opening_image import IMAGE_SIDE, OpeningImage, light_in_circle
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.header.channels import pixels_of

_RED, _GREEN, _BLUE = 0.2126, 0.7152, 0.0722  # weights of the luminance of Rec. 709
_COLORED = 0.02  # share of the brightest value: JPEG leaves gray slightly colored
_NEAR_AXIS = 0.03  # in radii; a smaller distance from the axis is invisible
_DIGEST_BYTES = 16


def read_opening_image(path: str | os.PathLike[str]) -> OpeningImage:
    """Read the light that an opening lets through; `path` becomes absolute.

    The picture is centerd in a square and scaled to IMAGE_SIDE cells on a side. Colors count by
    their luminance; transparent pixels are dark. A file that has not changed is not read again.

    Raises InputError that names the file if it cannot be read, has pixels that are not finite, or
    lets no light through.
    """
    path = Path(os.path.abspath(path))
    try:
        status = path.stat()
    except OSError as error:
        raise unreadable_error(path, error) from error
    except ValueError:  # NUL, or what no file system can encode
        raise unreadable_error(path) from None
    return _read_cached(path, (status.st_mtime_ns, status.st_size))


def opening_notes(image: OpeningImage, has_blades: bool) -> tuple[str, ...]:
    """Return the notes on an aperture image; `has_blades` if the lens has blades set."""
    blades_note = "The aperture image replaces the blades, which have no effect."
    return (blades_note, *image.notes) if has_blades else image.notes


@lru_cache(maxsize=8)
def _read_cached(path: Path, stamp: tuple[int, int]) -> OpeningImage:
    """Read an aperture image; the cache reads it again if `stamp`, its time and size, changes."""
    luminance, notes = _read_luminance(path)
    if not np.isfinite(luminance).all():
        raise InputError(
            f"{path} cannot be an aperture image: some of its pixels are not finite numbers (NaN "
            "or infinity). Write it again."
        )
    light = _fit_in_square(np.maximum(luminance, 0.0))
    if light_in_circle(light).max() <= 0.0:
        raise InputError(
            f"{path} cannot be an aperture image: it is black inside the circle of the lens, so "
            "no light passes; the opening is the bright part of the picture."
        )
    light /= light.max()
    notes = (*notes, *_off_axis_notes(path, light))
    digest = hashlib.blake2b(light.tobytes(), digest_size=_DIGEST_BYTES).hexdigest()
    return OpeningImage(str(path), digest, light, notes)


def _off_axis_notes(path: Path, light: NDArray[np.float32]) -> tuple[str, ...]:
    """Return a note if the centroid of the light is off the axis of the lens."""
    inner_light = light_in_circle(light)
    position = (np.arange(IMAGE_SIDE) + 0.5) * 2 / IMAGE_SIDE - 1
    x, y = (
        float((inner_light.sum(axis=axis) * position).sum() / inner_light.sum()) for axis in (0, 1)
    )
    offset = math.hypot(x, y)
    if offset < _NEAR_AXIS:
        return ()
    return (
        (
            f"{path}: the centre of its light is {100 * offset:.0f} % of the radius off the "
            "centre of "
            "the picture: lamps and the other methods show that, but diffusion blurs about the "
            "centre of the picture."
        ),
    )


def _read_luminance(path: Path) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Return the light (H, W) of a picture, and the notes on it."""
    from heatlens.media.plate.header.channel_choice import choose_color
    from heatlens.media.plate.read import color_file_parts

    parts = color_file_parts(path, PlateOptions())
    choice = choose_color(path, [header for header, _ in parts], layer=None)
    red, green, blue = (pixels_of(parts, ref).astype(np.float32) for ref in choice.rgb)
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and infinity are reported elsewhere
        luminance = _RED * red + _GREEN * green + _BLUE * blue
        color_difference = np.maximum(abs(red - green), abs(blue - green)).max()
        is_colored = bool(color_difference > _COLORED * np.maximum(np.max(luminance), 1e-30))
    note = f"{path}: the aperture image is coloured; its luminance is the light that passes."
    return np.asarray(luminance, np.float32), (note,) if is_colored else ()


def _fit_in_square(light: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the picture centerd in a square, averaged into IMAGE_SIDE cells on a side."""
    from PIL import Image

    height, width = light.shape
    side = max(height, width)
    top, left = (side - height) // 2, (side - width) // 2
    square = np.zeros((side, side), np.float32)
    square[top : top + height, left : left + width] = light / max(float(light.max()), 1e-30)
    resampling = Image.Resampling.BOX if side >= IMAGE_SIDE else Image.Resampling.BILINEAR
    return np.array(
        Image.fromarray(square).resize((IMAGE_SIDE, IMAGE_SIDE), resampling), np.float32
    )


def relative_path(path: str, folder: str | os.PathLike[str]) -> str:
    """Return the path relative to `folder`; absolute if the two share only the root of the disk."""
    absolute = path_in_folder(path, os.curdir)
    try:
        common_folder = os.path.commonpath([absolute, os.path.abspath(folder)])
    except ValueError:  # on two drives, or on one of another system
        return absolute
    if common_folder == os.path.dirname(common_folder):
        return absolute
    return Path(os.path.relpath(absolute, folder)).as_posix()


ConvertImage = Callable[[OpeningImage], OpeningImage]


def read_relative_image(image: OpeningImage, folder: str | os.PathLike[str]) -> OpeningImage:
    """Read an image whose path is relative to `folder`.

    Raises InputError if the file cannot be read or shows no opening.
    """
    return read_opening_image(Path(path_in_folder(image.path, folder)))


def with_relative_path(image: OpeningImage, folder: str | os.PathLike[str]) -> OpeningImage:
    """Return the image with its path relative to `folder`."""
    return replace(image, path=relative_path(image.path, folder))


def convert_shot_images(shot: Shot, convert: ConvertImage) -> Shot:
    """Return the shot with `convert` applied to the images of its lens, looks and kit."""
    looks = tuple(
        replace(look, lens=_convert_lens_image(look.lens, convert)) for look in shot.looks
    )
    kit = None if shot.kit is None else convert_kit_image(shot.kit, convert)
    return replace(shot, lens=_convert_lens_image(shot.lens, convert), looks=looks, kit=kit)


def convert_kit_image(kit: LensKit, convert: ConvertImage) -> LensKit:
    """Return the kit with `convert` applied to the image of its character."""
    image = kit.character.aperture_image
    if image is None:
        return kit
    return replace(kit, character=replace(kit.character, aperture_image=convert(image)))


def _convert_lens_image(lens: Lens, convert: ConvertImage) -> Lens:
    """Return the lens with `convert` applied to its aperture image, if it has one."""
    image = lens.aperture_image
    return lens if image is None else replace(lens, aperture_image=convert(image))
