"""Test `export --part`: several processes make one export, which equals that of one process."""

import subprocess

import pytest

from heatlens.media.documents.shot_file import write_shot
from support.dask_cluster import HEATLENS
from support.exports import (
    export_shot,
    files_in,
    names_of,
    refused_export_message,
    shot_of,
    write_plate,
)
from support.patience import PATIENCE_S

MOVIES = (".mov", ".mp4")


def test_export_in_parts_gives_files_of_whole_export(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    for part in ("1004-1006", "1001,1003", "1002"):
        export_shot(capsys, shot_file, tmp_path / "parts" / "n.####.exr", "--part", part)
    assert files_in(tmp_path / "parts") == files_in(tmp_path / "whole")
    assert list(files_in(tmp_path / "parts")) == names_of(".exr")


@pytest.mark.parametrize("suffix", MOVIES)
def test_movie_from_parts_equals_movie_of_one_process(capsys, shot_file, tmp_path, suffix):
    words = ("--burn-in", "--fps", "25")
    whole, joined = tmp_path / f"whole{suffix}", tmp_path / f"m{suffix}"
    export_shot(capsys, shot_file, whole, *words)
    export_shot(capsys, shot_file, joined, *words, "--part", "1004-1006")
    assert not joined.exists()
    message = export_shot(capsys, shot_file, joined, *words, "--part", "1001-1004")
    assert "3 frames written, 1 was finished before" in message
    part_files = files_in(tmp_path / f"m{suffix}.frames")
    last_message = export_shot(capsys, shot_file, joined, *words)
    assert "0 frames written, 6 were finished before" in last_message
    assert joined.read_bytes() == whole.read_bytes()
    assert len(part_files) == 6 and not (tmp_path / f"m{suffix}.frames").exists()
    second_message = export_shot(capsys, shot_file, joined, *words, "--part", "1001-1004")
    assert "0 frames written, 4 were finished before" in second_message  # the movie has them
    assert not (tmp_path / f"m{suffix}.frames").exists()


def test_movie_renders_missing_or_damaged_part_frames(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "whole.mov")
    export_shot(capsys, shot_file, tmp_path / "m.mov", "--part", "1002-1004")
    frames_folder = tmp_path / "m.mov.frames"
    frames_folder.joinpath("frame.1003.exr").write_bytes(
        frames_folder.joinpath("frame.1003.exr").read_bytes()[:-9]
    )
    message = export_shot(capsys, shot_file, tmp_path / "m.mov")
    assert "4 frames written, 2 were finished before" in message
    assert (tmp_path / "m.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()


def test_movie_ignores_part_frames_of_other_exposure(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "whole.mov")
    export_shot(capsys, shot_file, tmp_path / "m.mov", "--part", "1001-1006", "--exposure", "1")
    export_shot(capsys, shot_file, tmp_path / "m.mov")
    assert (tmp_path / "m.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()


def test_export_in_parts_keeps_timecode_and_pixel_aspect(capsys, tmp_path):
    """The plate is a still with a pixel aspect of 2; its timecode counts from the first frame."""
    write_plate(tmp_path / "hero.exr", pixelAspectRatio=2.0)
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(str(tmp_path / "hero.exr")))
    words = ("--frames", "1001-1006", "--start-timecode", "10:00:00:00")
    for suffix in (".mov", ".####.exr"):
        export_shot(capsys, shot, tmp_path / "whole" / f"m{suffix}", *words)
        for part in ("1004-1006", "1001-1003"):
            export_shot(capsys, shot, tmp_path / "out" / f"m{suffix}", *words, "--part", part)
    export_shot(capsys, shot, tmp_path / "out" / "m.mov", *words)
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


def test_export_refuses_part_outside_of_frames(capsys, shot_file, tmp_path):
    message = refused_export_message(
        capsys, shot_file, tmp_path / "n.####.exr", "--part", "1006-1008"
    )
    assert "1007-1008" in message and not list(tmp_path.glob("n.*"))


@pytest.mark.parametrize("output", ["n.####.exr", "m.mov"])
def test_two_tasks_exporting_same_frames_give_valid_files(capsys, shot_file, tmp_path, output):
    """A farm may start a task again that it believes to be lost."""
    export_shot(capsys, shot_file, tmp_path / "whole" / output)
    line = [*HEATLENS, "export", str(shot_file), "-o", str(tmp_path / "out" / output)]
    (tmp_path / "out").mkdir()
    processes = [
        subprocess.Popen([*line, "--part", "1001-1006"], stderr=subprocess.PIPE) for _ in "ab"
    ]
    for task in processes:
        assert task.communicate(timeout=PATIENCE_S)[1] and task.returncode == 0
    export_shot(capsys, shot_file, tmp_path / "out" / output)
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")
    assert [path.name for path in (tmp_path / "out").iterdir() if path.is_dir()] == []
