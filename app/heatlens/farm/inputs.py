"""List every file that an export reads, so that another machine can be given them."""

import os
from pathlib import Path

from heatlens.color.color_config import files_of_config
from heatlens.documents.opening_images import shot_with_images
from heatlens.export.plan import ExportPlan
from heatlens.model.opening_image import OpeningImage
from heatlens.model.shot import Shot


def files_beside(plan: ExportPlan) -> tuple[Path, ...]:
    """Return the files of all frames and the aperture images: all but the shot and its config."""
    stamped = (file for frame in plan.frames for file in frame.origin.files)
    read = (plain_path(file.path) for file in stamped if file.stamp is not None)
    return tuple(dict.fromkeys((*read, *images_of(plan.job.shot))))


def images_of(shot: Shot) -> tuple[Path, ...]:
    """Return the aperture images of a shot's lens, looks and kit."""
    found: list[Path] = []

    def take(image: OpeningImage) -> OpeningImage:
        found.append(Path(image.path))
        return image

    shot_with_images(shot, take)
    return tuple(found)


def config_files(text: str | None) -> tuple[Path, ...]:
    """Return the files of the OpenColorIO config called `text`; a built-in one has none."""
    if text is None or not Path(text).is_file():
        return ()
    return tuple(map(plain_path, files_of_config(plain_path(text))))


def plain_path(path: str | os.PathLike[str]) -> Path:
    """Return the absolute path without `..` and `~`."""
    return Path(os.path.abspath(os.path.expanduser(path)))
