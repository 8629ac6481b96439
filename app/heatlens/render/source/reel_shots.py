"""Make shots of a reel from the names of shot files, plates, movies and scenes."""

import os
from collections.abc import Sequence as Items
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.reel import ReelShot, shot_name, with_unique_names
from heatlens.media.documents.reel_file import is_reel
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.files.picture_formats import parse_movie_name
from heatlens.media.plate.parts.header_read import read_color_header
from heatlens.media.scene.scene_read import check_scene_files_exist
from heatlens.media.sequence.sequence_search import find_sequence
from heatlens.render.source.named import has_camera, source_named


def reel_shots(texts: Items[str]) -> tuple[ReelShot, ...]:
    """Return a shot for each name, with a name of its own.

    Raises InputError unless each is an existing shot file, scene, movie, plate or sequence.
    """
    for text in texts:
        _check_source(text)
    names = (shot_name(Path(text).name.split(".")[0]) for text in texts)
    return with_unique_names(tuple(map(ReelShot, names, texts)))


def join_frames(texts: Items[str]) -> tuple[str, ...]:
    """Return the names with one pattern in the place of the frames of a sequence."""
    return tuple(dict.fromkeys(map(_pattern_or_name, texts)))


def _pattern_or_name(text: str) -> str:
    """Return the pattern of the sequence that a file is a frame of; else its name."""
    is_picture_file = os.path.isfile(text) and not (is_shot_file(text) or has_camera(text))
    if not is_picture_file or is_reel(text) or parse_movie_name(Path(text)) is not None:
        return text
    sequence = find_sequence(text)
    return text if len(sequence.present) == 1 else sequence.pattern


def _check_source(text: str) -> None:
    """Raise InputError unless `text` names an existing shot file, scene or plate."""
    if is_reel(text):
        raise InputError(f"{text} is a reel or an edit itself: name it alone, or name shots.")
    if is_shot_file(text):
        read_shot(Path(text))
    elif has_camera(text):
        check_scene_files_exist(text)
    elif (first_file := source_named(text).first_file) is not None:
        read_color_header(first_file)
