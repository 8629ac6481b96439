"""Test that an export that is run again renders only missing or outdated frames."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.exports import (
    FRAMES,
    export_and_list_new_frames,
    export_shot,
    files_in,
    refused_export_message,
    with_focus,
    write_plate,
)
from support.exr_files import rgb, write_file
from support.picture_files import save_dpx


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_export_again_skips_finished_frames_unless_forced(capsys, shot_file, tmp_path, suffix):
    out = tmp_path / "out" / f"n.####{suffix}"
    assert export_and_list_new_frames(capsys, shot_file, out) == list(FRAMES)
    assert export_and_list_new_frames(capsys, shot_file, out) == []
    assert export_and_list_new_frames(
        capsys, shot_file, out, "--force", "--frames", "1002-1003"
    ) == [1002, 1003]


def test_finished_export_creates_no_opengl_context(capsys, shot_file, out, monkeypatch):
    export_shot(capsys, shot_file, out)

    def none_here():
        raise AssertionError("a context was made")

    monkeypatch.setattr("heatlens.render.frame_renderer.headless_context", none_here)
    assert "6 were finished before" in export_shot(capsys, shot_file, out)


def test_changed_key_renders_only_frames_whose_lens_changes(capsys, shot_file, out):
    export_shot(capsys, shot_file, out)
    shot = read_shot(shot_file)
    changed = with_focus(shot, 1003, 1.5)
    write_shot(shot_file, changed)
    assert export_and_list_new_frames(capsys, shot_file, out) == [1002, 1003, 1004, 1005]
    further = with_focus(changed, 1002, 1.1)
    write_shot(shot_file, further)
    changed_frames = [f for f in FRAMES if changed.lens_at(f) != further.lens_at(f)]
    assert export_and_list_new_frames(capsys, shot_file, out) == changed_frames == [1002]


def test_changed_plate_is_exported_again(capsys, shot_file, out, tmp_path):
    export_shot(capsys, shot_file, out)
    write_plate(tmp_path / "plates" / "plate.1005.exr", 3, owner="again")
    assert export_and_list_new_frames(capsys, shot_file, out) == [1005]


def test_close_focus_coc_limit_and_moved_plates_render_nothing_again(
    capsys, shot_file, out, tmp_path
):
    export_shot(capsys, shot_file, out)
    shot = read_shot(shot_file)
    (tmp_path / "plates").rename(tmp_path / "elsewhere")
    moved = str(tmp_path / "elsewhere" / "plate.####.exr")
    lens = replace(shot.lens, close_focus_m=0.5, acceptable_coc_mm=0.02)
    write_shot(shot_file, replace(shot, lens=lens, source=moved))
    assert export_and_list_new_frames(capsys, shot_file, out) == []


def test_export_refuses_foreign_frame_unless_overwrite(capsys, shot_file, out, tmp_path):
    export_shot(capsys, shot_file, out)
    frame = out.parent / "n.1003.exr"
    own_bytes = frame.read_bytes()
    foreign_bytes = (tmp_path / "plates" / "plate.1003.exr").read_bytes()
    frame.unlink()
    frame.write_bytes(foreign_bytes)
    assert "n.1003.exr" in refused_export_message(capsys, shot_file, out)
    assert frame.read_bytes() == foreign_bytes
    assert export_and_list_new_frames(capsys, shot_file, out, "--overwrite") == [1003]
    assert frame.read_bytes() == own_bytes


def test_truncated_frame_is_rendered_again(capsys, shot_file, out):
    export_shot(capsys, shot_file, out)
    frame = out.parent / "n.1003.exr"
    frame_bytes = frame.read_bytes()
    for leftover in (b"", frame_bytes[:40], frame_bytes[: len(frame_bytes) * 3 // 4]):
        frame.unlink()
        frame.write_bytes(leftover)
        assert export_and_list_new_frames(capsys, shot_file, out) == [1003]
        assert frame.read_bytes() == frame_bytes


def test_render_of_exported_frame_drops_its_fingerprint(capsys, shot_file, out, tmp_path):
    """The fingerprint in the header of a frame must not be copied into a render of that frame."""
    export_shot(capsys, shot_file, out, "--with-depth")
    copy = tmp_path / "graded.exr"
    words = ["--bokeh", "heat", "--quality", "draft"]
    assert main(["render", str(out.parent / "n.1003.exr"), "-o", str(copy), *words]) == 0
    capsys.readouterr()
    copy.replace(out.parent / "n.1003.exr")
    assert export_and_list_new_frames(capsys, shot_file, out, "--with-depth", "--overwrite") == [
        1003
    ]


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_export_counts_foreign_pictures_and_keeps_them(capsys, shot_file, tmp_path, suffix):
    out = tmp_path / "out" / f"n.####{suffix}"
    out.parent.mkdir()
    for frame in (1002, 1004):
        write_picture_of_others(out.parent / f"n.{frame}{suffix}")
    files_before = files_in(out.parent)
    message = refused_export_message(
        capsys, shot_file, out, "--force"
    )  # which is about frames of our own
    assert "2 of the 6 files" in message and f"n.1002{suffix} is the first" in message
    assert "--overwrite" in message and files_in(out.parent) == files_before
    assert export_and_list_new_frames(capsys, shot_file, out, "--frames", "1005-1006") == [
        1005,
        1006,
    ]
    assert export_and_list_new_frames(capsys, shot_file, out, "--overwrite") == [
        1001,
        1002,
        1003,
        1004,
    ]
    assert export_and_list_new_frames(capsys, shot_file, out) == []


def write_picture_of_others(path):
    """Write a small picture as another program would, with a comment if the format has one."""
    if path.suffix == ".exr":
        write_file(path, rgb(4, 4), comments="a matte painting")
    elif path.suffix == ".dpx":
        save_dpx(path, np.zeros((4, 4, 3)), Version="V2.0")
    else:
        Image.new("RGB", (4, 4)).save(path, comment=b"a matte painting")
