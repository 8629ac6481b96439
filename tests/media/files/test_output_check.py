"""Test that an output that cannot be written is found before the work."""

import os
import shutil
from collections import namedtuple
from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.core.base.stopping import temporary_folder
from heatlens.deliver.export import movie as movies
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels, refused_render_message, render
from support.exports import export_shot
from support.exports import refused_export_message as export_refused
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


def set_free_bytes(monkeypatch, count: int) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**9, 10**9 - count, count))


def test_render_reports_unwritable_folder_before_opengl_starts(capsys, monkeypatch, plate, barred):
    monkeypatch.setattr(
        "heatlens.render.frame_renderer.headless_context", lambda: pytest.fail("too late")
    )
    for name in ("o.exr", "o.png"):
        assert "is not writable" in refused_render_message(capsys, plate, barred / name)


def test_export_into_unwritable_folder_renders_nothing(capsys, monkeypatch, shot_file, barred):
    monkeypatch.setattr(
        "heatlens.render.frame_renderer.headless_context", lambda: pytest.fail("late")
    )
    message = export_refused(capsys, shot_file, barred / "n.####.exr")
    assert "is not writable" in message


def test_render_reports_disk_too_full_for_the_image(capsys, monkeypatch, plate, tmp_path):
    set_free_bytes(monkeypatch, 100)
    assert main(["render", str(plate), "-o", str(tmp_path / "o.exr")]) == 2
    message = capsys.readouterr().err
    assert "are free on that disk" in message and str(tmp_path) in message
    assert not (tmp_path / "o.exr").exists()
    set_free_bytes(monkeypatch, 10**8)
    render(capsys, plate, tmp_path / "o.exr")


def test_export_reports_disk_too_full_for_remaining_frames(capsys, monkeypatch, shot_file, out):
    set_free_bytes(monkeypatch, 2000)
    message = export_refused(capsys, shot_file, out)
    assert "5 more frames" in message
    assert len(os.listdir(out.parent)) <= 3  # the first, and what was under way
    assert all(name.endswith(".exr") and name[0] != "." for name in os.listdir(out.parent))


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
def test_export_reports_disk_too_full_for_movie(capsys, monkeypatch, shot_file, tmp_path, suffix):
    """For six frames of 32x18, less space than the codec needs is reported at the first frame."""
    out = tmp_path / f"m{suffix}"
    set_free_bytes(monkeypatch, 10)
    message = export_refused(capsys, shot_file, out)
    assert "movie of 6" in message and "are free on that disk" in message
    assert not out.exists()
    set_free_bytes(monkeypatch, 10**6)
    export_shot(capsys, shot_file, out)


def test_export_estimates_movie_size_from_frames_so_far(capsys, monkeypatch, shot_file, tmp_path):
    """The estimate is used as soon as there are enough frames."""
    monkeypatch.setattr(movies, "_FRAMES_BEFORE_PREDICTION", 2)
    unknown = replace(movies._CODECS[".mov"], least_bits_px=0.0)
    monkeypatch.setitem(movies._CODECS, ".mov", unknown)
    set_free_bytes(monkeypatch, 100)  # less than a frame takes
    message = export_refused(capsys, shot_file, tmp_path / "m.mov")
    assert "more frames as those before" in message
    assert not (tmp_path / "m.mov").exists()


def test_temporary_folder_is_removed_however_its_block_ends():
    with temporary_folder() as folder:
        (folder / "a").write_text("a")
    assert not folder.exists()
    with pytest.raises(ZeroDivisionError), temporary_folder() as folder:
        raise ZeroDivisionError
    assert not folder.exists()
