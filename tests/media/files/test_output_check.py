"""An output that cannot be written is found before the work."""

import os
import shutil
from collections import namedtuple
from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.export import movie as movies
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels, refused, render
from support.exports import exported
from support.exports import refused as export_refused
from support.exr_files import write_file

Usage = namedtuple("Usage", "total used free")


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "p.exr", channels(), **CAMERA)


@pytest.fixture
def barred(monkeypatch, tmp_path) -> Path:
    """Return a folder that is there and may not be written in, whoever runs the tests."""
    folder = tmp_path / "barred"
    folder.mkdir()
    access = os.access

    def may(path, mode, **options):
        return Path(path) != folder and access(path, mode, **options)

    monkeypatch.setattr(os, "access", may)
    return folder


def free(monkeypatch, count: int) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**9, 10**9 - count, count))


def test_a_folder_that_is_barred_is_said_before_opengl_is_begun(capsys, monkeypatch, plate, barred):
    monkeypatch.setattr(
        "heatlens.render.frame_renderer.headless_context", lambda: pytest.fail("too late")
    )
    for name in ("o.exr", "o.png"):
        assert "is not writable" in refused(capsys, plate, barred / name)


def test_an_export_into_a_barred_folder_renders_nothing(capsys, monkeypatch, shot_file, barred):
    monkeypatch.setattr(
        "heatlens.render.frame_renderer.headless_context", lambda: pytest.fail("late")
    )
    said = export_refused(capsys, shot_file, barred / "n.####.exr")
    assert "is not writable" in said


def test_a_disk_without_room_for_the_picture(capsys, monkeypatch, plate, tmp_path):
    free(monkeypatch, 100)
    assert main(["render", str(plate), "-o", str(tmp_path / "o.exr")]) == 2
    said = capsys.readouterr().err
    assert "are free on that disk" in said and str(tmp_path) in said
    assert not (tmp_path / "o.exr").exists()
    free(monkeypatch, 10**8)
    render(capsys, plate, tmp_path / "o.exr")


def test_a_disk_without_room_for_the_other_frames(capsys, monkeypatch, shot_file, out):
    free(monkeypatch, 2000)
    said = export_refused(capsys, shot_file, out)
    assert "5 more frames" in said
    assert len(os.listdir(out.parent)) <= 3  # the first, and what was under way
    assert all(name.endswith(".exr") and name[0] != "." for name in os.listdir(out.parent))


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
def test_a_disk_without_room_for_a_movie(capsys, monkeypatch, shot_file, tmp_path, suffix):
    """Six frames of 32x18: less than the codec can do with is told at the first of them."""
    out = tmp_path / f"m{suffix}"
    free(monkeypatch, 10)
    said = export_refused(capsys, shot_file, out)
    assert "movie of 6" in said and "are free on that disk" in said
    assert not out.exists()
    free(monkeypatch, 10**6)
    exported(capsys, shot_file, out)


def test_a_movie_that_grows_faster_than_was_thought(capsys, monkeypatch, shot_file, tmp_path):
    """By what the frames have needed so far, as soon as there are enough of them."""
    monkeypatch.setattr(movies, "_JUDGED_FRAMES", 2)
    unknown = replace(movies._CODECS[".mov"], least_bits_px=0.0)
    monkeypatch.setitem(movies._CODECS, ".mov", unknown)
    free(monkeypatch, 100)  # less than a frame takes
    said = export_refused(capsys, shot_file, tmp_path / "m.mov")
    assert "more frames as those before" in said
    assert not (tmp_path / "m.mov").exists()


def test_a_temporary_folder_goes_however_its_block_ends():
    with temporary_folder() as folder:
        (folder / "a").write_text("a")
    assert not folder.exists()
    with pytest.raises(ZeroDivisionError), temporary_folder() as folder:
        raise ZeroDivisionError
    assert not folder.exists()
