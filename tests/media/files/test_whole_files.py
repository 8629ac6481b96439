"""Files are written whole or not at all, and an export that is resumed knows one from the other."""

import errno
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.deliver.export.finished import is_whole
from heatlens.media.files import atomic_file
from heatlens.media.files.atomic_file import replacing, write_whole
from heatlens.media.plate.exr.exr_write import COMPRESSIONS, write_exr
from heatlens.media.plate.picture.picture_write import write_png
from support.command_line import started
from support.exports import FRAMES, exported, files_in, names_of, write_shot_file, written

SHOWN = ("--view", "sRGB curve")


@pytest.fixture(scope="module")
def shot_file(tmp_path_factory) -> Path:
    return write_shot_file(tmp_path_factory.mktemp("shot"))


def parts_in(folder: Path) -> list[str]:
    return [name for name in os.listdir(folder) if name.endswith(".part")]


# Whole or not


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("rows", [1, 16, 33, 300])
def test_an_exr_is_whole_up_to_its_last_byte(tmp_path, compression, rows):
    path = tmp_path / "a.exr"
    box = Box(-3, 7, 2, 7 + rows)
    values = np.random.default_rng(rows).random((rows, 5)).astype(np.float32)
    write_exr(path, {"R": values, "Z": values}, box, box, compression=compression)
    data = path.read_bytes()
    assert is_whole(path)
    for length in (*range(0, len(data), 1 + len(data) // 50), len(data) - 1):
        path.write_bytes(data[:length])
        assert not is_whole(path), length
    path.write_bytes(data + b"x")
    assert not is_whole(path)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_a_picture_is_whole_up_to_its_last_byte(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    write_png(path, np.random.default_rng(0).random((20, 30, 3)).astype(np.float32))
    data = path.read_bytes()
    assert is_whole(path)
    for length in range(len(data)):
        path.write_bytes(data[:length])
        assert not is_whole(path), length


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_a_frame_that_was_cut_is_made_again(capsys, tmp_path, shot_file, suffix):
    """The fingerprint stands in the header, and is there in the stump as well."""
    out = tmp_path / f"n.####{suffix}"
    words = () if suffix == ".exr" else SHOWN
    exported(capsys, shot_file, out, *words)
    whole = files_in(tmp_path)
    cut = tmp_path / names_of(suffix)[2]
    cut.write_bytes(cut.read_bytes()[:-20])
    assert written(capsys, shot_file, out, *words) == [FRAMES[2]]
    assert files_in(tmp_path) == whole


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
def test_a_movie_that_was_cut_is_made_again(capsys, tmp_path, shot_file, suffix):
    out = tmp_path / f"m{suffix}"
    exported(capsys, shot_file, out, *SHOWN)
    data = out.read_bytes()
    assert is_whole(out)
    for length in range(0, len(data), 1 + len(data) // 60):
        out.write_bytes(data[:length])
        assert not is_whole(out), length
    out.write_bytes(data[:-20])
    exported(capsys, shot_file, out, *SHOWN)
    assert out.read_bytes() == data


# A disk that takes no more


@pytest.fixture
def small_disk(tmp_path):
    """Return a file system of a few hundred kilobytes, where the test may mount one."""
    folder = tmp_path / "small"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=160k", "tmpfs", str(folder)]
    try:
        done = subprocess.run(mount, capture_output=True)
    except OSError:
        pytest.skip("there is no mount")
    if done.returncode:
        pytest.skip("mounting is not allowed here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".exr", ".mov", ".mp4"])
@pytest.mark.parametrize("left_kb", [0, 2])
def test_a_full_disk_is_said_and_leaves_no_stump(capsys, small_disk, shot_file, suffix, left_kb):
    """In a process of its own: a movie on a full disk used to end it by a signal."""
    room = os.statvfs(small_disk)
    (small_disk / "filler").write_bytes(b"x" * (room.f_bavail * room.f_frsize - left_kb * 1024))
    name = f"n{suffix}" if suffix in (".mov", ".mp4") else f"n.####{suffix}"
    words = () if suffix == ".exr" else SHOWN
    process = started("export", shot_file, "-o", small_disk / name, *words)
    said = process.communicate(timeout=60)[1].splitlines()[-1]
    assert process.returncode == 2 and ".part" not in said
    assert "could not be written" in said or "are free on that disk" in said
    assert parts_in(small_disk) == []
    (small_disk / "filler").unlink()
    for left in small_disk.iterdir():
        assert is_whole(left)
    exported(capsys, shot_file, small_disk / name, *words)
    assert all(is_whole(path) for path in small_disk.iterdir())


def test_what_arrives_short_is_an_error(tmp_path, monkeypatch):
    """As some network disks end a file that their quota cuts."""
    real = os.fstat

    def short(handle):
        found = real(handle)
        return os.stat_result((*found[:6], max(found.st_size - 1, 0), *found[7:10]))

    monkeypatch.setattr(atomic_file.os, "fstat", short)
    (tmp_path / "a").write_bytes(b"before")
    with pytest.raises(InputError, match="only 3 of 4 bytes are on the disk"):
        write_whole(tmp_path / "a", b"four")
    assert files_in(tmp_path) == {"a": b"before"}


# Where nothing can be written


@pytest.mark.parametrize("code", [errno.EROFS, errno.EIO, errno.ESTALE])
def test_what_cannot_be_removed_hides_no_reason(tmp_path, monkeypatch, code):
    def refuses(self, missing_ok=False):
        raise OSError(code, os.strerror(code), str(self))

    monkeypatch.setattr(Path, "unlink", refuses)
    with (
        pytest.raises(InputError, match="disk on fire") as told,
        replacing(tmp_path / "a.exr"),
    ):
        raise OSError("disk on fire")
    assert ".part" not in str(told.value)


@pytest.mark.parametrize("letters", [200, 233, 251, 255])
def test_every_name_that_the_disk_takes_can_be_written(tmp_path, letters):
    path = tmp_path / ("n" * (letters - 4) + ".png")
    write_png(path, np.ones((2, 2, 3), np.float32))
    assert is_whole(path)


def test_a_name_that_the_disk_does_not_take_is_told(tmp_path):
    with pytest.raises(InputError, match="could not be written: File name too long"):
        write_png(tmp_path / ("n" * 300 + ".png"), np.ones((2, 2, 3), np.float32))
    assert files_in(tmp_path) == {}


def test_nobody_can_lay_a_link_where_the_part_will_be(tmp_path, monkeypatch):
    """Even one who knew the name: what is there already is not opened, a link not followed."""
    monkeypatch.setattr(atomic_file.secrets, "token_hex", lambda count: "0" * 2 * count)
    precious = tmp_path / "precious"
    precious.write_bytes(b"precious")
    with replacing(tmp_path / "a") as beside:
        beside.write_bytes(b"a")
    beside.symlink_to(precious)
    with pytest.raises(InputError, match="File exists"), replacing(tmp_path / "a"):
        pass
    assert precious.read_bytes() == b"precious"


def test_names_of_parts_are_short_and_no_two_alike(tmp_path):
    with replacing(tmp_path / ("a" * 200)) as first, replacing(tmp_path / "a") as second:
        assert first.name != second.name and max(len(first.name), len(second.name)) < 60
        assert re.fullmatch(r"\.heatlens-[0-9a-f]{16}\.[0-9a-f]{8}\.\d+\.part", first.name)
        first.write_bytes(b"1")
        second.write_bytes(b"2")


def test_a_picture_to_a_disk_that_cannot_be_written_is_a_sentence(tmp_path, shot_file):
    folder = tmp_path / "readonly"
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", folder]).returncode:
        pytest.skip("mounting is not allowed here")
    try:
        process = started("export", shot_file, "-o", folder / "n.####.exr")
        said = process.communicate(timeout=60)[1]
    finally:
        subprocess.run(["umount", folder], check=True)
    assert process.returncode == 2
    (sentence,) = said.splitlines()
    assert sentence.startswith(f"heatlens: {folder}/n.")
    assert sentence.endswith(f"{folder} is not writable. Choose another folder.")


def test_a_jpeg_of_the_window_and_of_the_export_is_no_stump(tmp_path):
    path = tmp_path / "a.jpg"
    write_png(path, np.random.default_rng(0).random((40, 60, 3)).astype(np.float32))
    with Image.open(path) as image:
        image.load()
