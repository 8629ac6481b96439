"""Read the aperture images that a shot or a lens kit names, and convert their paths."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.model.lens.lens import Lens
from heatlens.model.lens.lens_kit import LensKit
from heatlens.model.lens.opening_image import OpeningImage
from heatlens.model.shot.shot import Shot
from heatlens.plate.opening_picture import read_opening_image


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
