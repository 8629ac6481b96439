"""Test that a failed save loses nothing, and that a save removes the autosave file."""

import os

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_autosave, write_shot
from support.shot_files import FIFTY, FULL, write_shot_in


def test_write_shot_keeps_old_file_if_disk_is_full(tmp_path, monkeypatch):
    path = write_shot_in(FULL, tmp_path)
    before = path.read_bytes()

    def full_disk(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(InputError, match="No space left on device"):
        write_shot(path, Shot(FIFTY))
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [path.name]


def test_write_shot_into_missing_folder_raises_input_error(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        write_shot(tmp_path / "none" / "s.heatlens.json", FULL)


def test_write_shot_removes_autosave_of_its_file(tmp_path):
    path = tmp_path / "s.heatlens.json"
    write_autosave(path, FULL)
    assert autosave_path(path).exists()  # never saved, yet not lost
    write_shot(path, Shot(FIFTY))
    assert not autosave_path(path).exists()
    write_autosave(path, FULL)
    assert read_shot(autosave_path(path)) == FULL
    assert read_shot(path) == Shot(FIFTY)
