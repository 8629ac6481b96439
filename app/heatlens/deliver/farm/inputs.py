"""List every file that an export reads, so that another machine can be given them."""

import os
from pathlib import Path

from heatlens.core.base.paths import absolute
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.plan import ExportPlan
from heatlens.media.color.color_config import list_config_files
from heatlens.media.files.picture_formats import file_on_disk
from heatlens.media.plate.opening_picture import convert_shot_images


def input_files(plan: ExportPlan) -> tuple[Path, ...]:
    """Return every input file of an export except the shot file and the color config.

    They are the files of all frames, those of the source, and the aperture images.
    """
    stamped = dict.fromkeys(file for frame in plan.frames for file in frame.origin.files)
    frame_files = (
        absolute_path(file_on_disk(file.path)) for file in stamped if file.stamp is not None
    )
    source_files = (absolute_path(path) for path in plan.source.all_files if path.exists())
    return tuple(dict.fromkeys((*frame_files, *source_files, *aperture_images(plan.job.shot))))


def folder_of_source(plan: ExportPlan) -> Path | None:
    """Return the folder of the plates, or one that holds all files of a scene; None for neither."""
    source = plan.source
    if source.files is None:
        return None
    folder = absolute_path(source.files).parent
    if not source.has_many_views:
        return folder
    common = Path(
        os.path.commonpath([folder, *(absolute_path(it).parent for it in source.all_files)])
    )
    return folder if common == common.parent else common


def aperture_images(shot: Shot) -> tuple[Path, ...]:
    """Return the aperture images of a shot's lens, looks and kit."""
    paths: list[Path] = []

    def note_path(image: OpeningImage) -> OpeningImage:
        paths.append(Path(image.path))
        return image

    convert_shot_images(shot, note_path)
    return tuple(paths)


def config_files(text: str | None) -> tuple[Path, ...]:
    """Return the files of the OpenColorIO config called `text`; a built-in one has none."""
    if text is None or not Path(text).is_file():
        return ()
    return tuple(map(absolute_path, list_config_files(absolute_path(text))))


def absolute_path(path: str | os.PathLike[str]) -> Path:
    """Return the absolute path without `..` and `~`."""
    return Path(absolute(path))
