"""`export --part`: several processes make one export, and it is the same as that of one."""

import subprocess

import pytest

from heatlens.media.documents.shot_file import write_shot
from support.dask_cluster import HEATLENS
from support.exports import exported, files_in, names_of, refused, shot_of, write_plate

MOVIES = (".mov", ".mp4")


def test_parts_of_frames_are_those_of_the_whole(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    for part in ("1004-1006", "1001,1003", "1002"):
        exported(capsys, shot_file, tmp_path / "parts" / "n.####.exr", "--part", part)
    assert files_in(tmp_path / "parts") == files_in(tmp_path / "whole")
    assert list(files_in(tmp_path / "parts")) == names_of(".exr")


@pytest.mark.parametrize("suffix", MOVIES)
def test_a_movie_of_parts_is_that_of_one_process(capsys, shot_file, tmp_path, suffix):
    words = ("--burn-in", "--fps", "25")
    whole, joined = tmp_path / f"whole{suffix}", tmp_path / f"m{suffix}"
    exported(capsys, shot_file, whole, *words)
    exported(capsys, shot_file, joined, *words, "--part", "1004-1006")
    assert not joined.exists()
    said = exported(capsys, shot_file, joined, *words, "--part", "1001-1004")
    assert "3 frames written, 1 was finished before" in said
    made = files_in(tmp_path / f"m{suffix}.frames")
    exported(capsys, shot_file, joined, *words)
    assert joined.read_bytes() == whole.read_bytes()
    assert len(made) == 6 and not (tmp_path / f"m{suffix}.frames").exists()
    again = exported(capsys, shot_file, joined, *words, "--part", "1001-1004")
    assert "0 frames written, 4 were finished before" in again  # the movie has them
    assert not (tmp_path / f"m{suffix}.frames").exists()


def test_a_movie_renders_the_frames_that_no_part_has_made(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "whole.mov")
    exported(capsys, shot_file, tmp_path / "m.mov", "--part", "1002-1004")
    kept = tmp_path / "m.mov.frames"
    kept.joinpath("frame.1003.exr").write_bytes(kept.joinpath("frame.1003.exr").read_bytes()[:-9])
    exported(capsys, shot_file, tmp_path / "m.mov")
    assert (tmp_path / "m.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()


def test_kept_frames_of_another_look_are_not_taken(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "whole.mov")
    exported(capsys, shot_file, tmp_path / "m.mov", "--part", "1001-1006", "--exposure", "1")
    exported(capsys, shot_file, tmp_path / "m.mov")
    assert (tmp_path / "m.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()


def test_a_movie_keeps_the_timecode_and_the_shape_of_its_plates(capsys, tmp_path):
    """Pixels that are not square, and the timecode of a still, which counts from the first."""
    write_plate(tmp_path / "hero.exr", pixelAspectRatio=2.0)
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(str(tmp_path / "hero.exr")))
    words = ("--frames", "1001-1006", "--start-timecode", "10:00:00:00")
    for suffix in (".mov", ".####.exr"):
        exported(capsys, shot, tmp_path / "whole" / f"m{suffix}", *words)
        for part in ("1004-1006", "1001-1003"):
            exported(capsys, shot, tmp_path / "out" / f"m{suffix}", *words, "--part", part)
    exported(capsys, shot, tmp_path / "out" / "m.mov", *words)
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


def test_a_part_beyond_the_export_is_refused(capsys, shot_file, tmp_path):
    said = refused(capsys, shot_file, tmp_path / "n.####.exr", "--part", "1006-1008")
    assert "1007-1008" in said and not list(tmp_path.glob("n.*"))


@pytest.mark.parametrize("output", ["n.####.exr", "m.mov"])
def test_two_tasks_at_the_same_frames_do_no_harm(capsys, shot_file, tmp_path, output):
    """As a farm may start one again that it believes to be lost."""
    exported(capsys, shot_file, tmp_path / "whole" / output)
    line = [*HEATLENS, "export", str(shot_file), "-o", str(tmp_path / "out" / output)]
    (tmp_path / "out").mkdir()
    both = [subprocess.Popen([*line, "--part", "1001-1006"], stderr=subprocess.PIPE) for _ in "ab"]
    for task in both:
        assert task.communicate(timeout=60)[1] and task.returncode == 0
    exported(capsys, shot_file, tmp_path / "out" / output)
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    assert [path.name for path in (tmp_path / "out").iterdir() if path.is_dir()] == []
