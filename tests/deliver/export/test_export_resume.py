"""An export that is run again renders what is not there yet as it should be, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.exports import FRAMES, exported, files_in, refused, with_focus, write_plate, written
from support.exr_files import rgb, write_file
from support.picture_files import save_dpx


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_what_is_finished_is_left(capsys, shot_file, tmp_path, suffix):
    out = tmp_path / "out" / f"n.####{suffix}"
    assert written(capsys, shot_file, out) == list(FRAMES)
    assert written(capsys, shot_file, out) == []
    assert written(capsys, shot_file, out, "--force", "--frames", "1002-1003") == [1002, 1003]


def test_nothing_left_to_do_needs_no_opengl(capsys, shot_file, out, monkeypatch):
    exported(capsys, shot_file, out)

    def none_here():
        raise AssertionError("a context was made")

    monkeypatch.setattr("heatlens.render.frame_renderer.headless_context", none_here)
    assert "6 were finished before" in exported(capsys, shot_file, out)


def test_another_key_renders_the_frames_whose_lens_it_changes(capsys, shot_file, out):
    exported(capsys, shot_file, out)
    shot = read_shot(shot_file)
    changed = with_focus(shot, 1003, 1.5)
    write_shot(shot_file, changed)
    assert written(capsys, shot_file, out) == [1002, 1003, 1004, 1005]
    further = with_focus(changed, 1002, 1.1)
    write_shot(shot_file, further)
    differ = [f for f in FRAMES if changed.lens_at(f) != further.lens_at(f)]
    assert written(capsys, shot_file, out) == differ == [1002]


def test_a_plate_that_was_rendered_again_is_exported_again(capsys, shot_file, out, tmp_path):
    exported(capsys, shot_file, out)
    write_plate(tmp_path / "plates" / "plate.1005.exr", 3, owner="again")
    assert written(capsys, shot_file, out) == [1005]


def test_marks_close_focus_and_the_place_of_the_plates_change_no_pixel(
    capsys, shot_file, out, tmp_path
):
    exported(capsys, shot_file, out)
    shot = read_shot(shot_file)
    (tmp_path / "plates").rename(tmp_path / "elsewhere")
    moved = str(tmp_path / "elsewhere" / "plate.####.exr")
    lens = replace(shot.lens, close_focus_m=0.5, acceptable_coc_mm=0.02)
    write_shot(shot_file, replace(shot, lens=lens, source=moved))
    assert written(capsys, shot_file, out) == []


def test_a_frame_of_somebody_else_is_not_taken_for_ours(capsys, shot_file, out, tmp_path):
    exported(capsys, shot_file, out)
    frame = out.parent / "n.1003.exr"
    ours, theirs = frame.read_bytes(), (tmp_path / "plates" / "plate.1003.exr").read_bytes()
    frame.unlink()
    frame.write_bytes(theirs)
    assert "n.1003.exr" in refused(capsys, shot_file, out)
    assert frame.read_bytes() == theirs
    assert written(capsys, shot_file, out, "--overwrite") == [1003]
    assert frame.read_bytes() == ours


def test_what_is_left_of_a_frame_is_replaced_without_a_question(capsys, shot_file, out):
    exported(capsys, shot_file, out)
    frame = out.parent / "n.1003.exr"
    ours = frame.read_bytes()
    for left in (b"", ours[:40], ours[: len(ours) * 3 // 4]):
        frame.unlink()
        frame.write_bytes(left)
        assert written(capsys, shot_file, out) == [1003]
        assert frame.read_bytes() == ours


def test_what_is_made_of_an_exported_frame_is_no_exported_frame(capsys, shot_file, out, tmp_path):
    """The fingerprint goes into the header, and must not go on from there."""
    exported(capsys, shot_file, out, "--with-depth")
    copy = tmp_path / "graded.exr"
    words = ["--bokeh", "heat", "--quality", "draft"]
    assert main(["render", str(out.parent / "n.1003.exr"), "-o", str(copy), *words]) == 0
    capsys.readouterr()
    copy.replace(out.parent / "n.1003.exr")
    assert written(capsys, shot_file, out, "--with-depth", "--overwrite") == [1003]


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_pictures_of_others_are_counted_before_the_first_frame_and_stay(
    capsys, shot_file, tmp_path, suffix
):
    out = tmp_path / "out" / f"n.####{suffix}"
    out.parent.mkdir()
    for frame in (1002, 1004):
        write_picture_of_others(out.parent / f"n.{frame}{suffix}")
    before = files_in(out.parent)
    said = refused(capsys, shot_file, out, "--force")  # which is about frames of our own
    assert "2 of the 6 files" in said and f"n.1002{suffix} is the first" in said
    assert "--overwrite" in said and files_in(out.parent) == before
    assert written(capsys, shot_file, out, "--frames", "1005-1006") == [1005, 1006]
    assert written(capsys, shot_file, out, "--overwrite") == [1001, 1002, 1003, 1004]
    assert written(capsys, shot_file, out) == []


def write_picture_of_others(path):
    """Write a small picture as any program would, with a comment where the format has one."""
    if path.suffix == ".exr":
        write_file(path, rgb(4, 4), comments="a matte painting")
    elif path.suffix == ".dpx":
        save_dpx(path, np.zeros((4, 4, 3)), Version="V2.0")
    else:
        Image.new("RGB", (4, 4)).save(path, comment=b"a matte painting")
