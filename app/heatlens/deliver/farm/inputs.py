"""List every file that an export reads, so that another machine can be given them."""

import os
from pathlib import Path

from heatlens.core.base.paths import absolute
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.plan import ExportPlan
from heatlens.media.color.color_config import files_of_config
from heatlens.media.files.picture_formats import file_on_disk
from heatlens.media.plate.opening_picture import shot_with_images


def files_beside(plan: ExportPlan) -> tuple[Path, ...]:
    """Return the files of all frames and the aperture images: all but the shot and its config."""
    stamped = dict.fromkeys(file for frame in plan.frames for file in frame.origin.files)
    read = (plain_path(file_on_disk(file.path)) for file in stamped if file.stamp is not None)
    deciding = (plain_path(path) for path in plan.source.all_files if path.exists())
    return tuple(dict.fromkeys((*read, *deciding, *images_of(plan.job.shot))))


def folder_of_source(plan: ExportPlan) -> Path | None:
    """Return the folder of the plates, or one that holds all files of a scene."""
    source = plan.source
    if source.files is None:
        return None
    folder = plain_path(source.files).parent
    if not source.has_many_views:
        return folder
    common = Path(os.path.commonpath([folder, *(plain_path(it).parent for it in source.all_files)]))
    return folder if common == common.parent else common


def images_of(shot: Shot) -> tuple[Path, ...]:
    """Return the aperture images of a shot's lens, looks and kit."""
    paths: list[Path] = []

    def take(image: OpeningImage) -> OpeningImage:
        paths.append(Path(image.path))
        return image

    shot_with_images(shot, take)
    return tuple(paths)


def config_files(text: str | None) -> tuple[Path, ...]:
    """Return the files of the OpenColorIO config called `text`; a built-in one has none."""
    if text is None or not Path(text).is_file():
        return ()
    return tuple(map(plain_path, files_of_config(plain_path(text))))


def plain_path(path: str | os.PathLike[str]) -> Path:
    """Return the absolute path without `..` and `~`."""
    return Path(absolute(path))
