"""Test that files are written whole or not at all, and that a resumed export checks them."""

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
from heatlens.deliver.export.finished import is_complete
from heatlens.media.files import atomic_file
from heatlens.media.files.atomic_file import replace_atomically, write_atomically
from heatlens.media.plate.exr.exr_write import COMPRESSIONS, write_exr
from heatlens.media.plate.picture.picture_write import write_png
from support.command_line import start_heatlens
from support.exports import (
    FRAMES,
    export_and_list_new_frames,
    export_shot,
    files_in,
    names_of,
    write_shot_file,
)
from support.patience import PATIENCE_S

SHOWN = ("--view", "sRGB curve")


@pytest.fixture(scope="module")
def shot_file(tmp_path_factory) -> Path:
    return write_shot_file(tmp_path_factory.mktemp("shot"))


def parts_in(folder: Path) -> list[str]:
    return [name for name in os.listdir(folder) if name.endswith(".part")]


# Whole or not


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("rows", [1, 16, 33, 300])
def test_is_complete_of_exr_needs_every_byte(tmp_path, compression, rows):
    path = tmp_path / "a.exr"
    box = Box(-3, 7, 2, 7 + rows)
    values = np.random.default_rng(rows).random((rows, 5)).astype(np.float32)
    write_exr(path, {"R": values, "Z": values}, box, box, compression=compression)
    data = path.read_bytes()
    assert is_complete(path)
    for length in (*range(0, len(data), 1 + len(data) // 50), len(data) - 1):
        path.write_bytes(data[:length])
        assert not is_complete(path), length
    path.write_bytes(data + b"x")
    assert not is_complete(path)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_is_complete_of_picture_needs_every_byte(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    write_png(path, np.random.default_rng(0).random((6, 10, 3)).astype(np.float32))
    data = path.read_bytes()
    assert is_complete(path)
    for length in range(len(data)):
        path.write_bytes(data[:length])
        assert not is_complete(path), length


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg", ".tif", ".webp", ".dpx"])
def test_export_renders_truncated_frame_again(capsys, tmp_path, shot_file, suffix):
    """The fingerprint is in the header, so a truncated file has it as well."""
    out = tmp_path / f"n.####{suffix}"
    words = () if suffix == ".exr" else SHOWN
    export_shot(capsys, shot_file, out, *words)
    exported_files = files_in(tmp_path)
    cut = tmp_path / names_of(suffix)[2]
    cut.write_bytes(cut.read_bytes()[:-20])
    assert export_and_list_new_frames(capsys, shot_file, out, *words) == [FRAMES[2]]
    assert files_in(tmp_path) == exported_files


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
def test_export_renders_truncated_movie_again(capsys, tmp_path, shot_file, suffix):
    out = tmp_path / f"m{suffix}"
    export_shot(capsys, shot_file, out, *SHOWN)
    data = out.read_bytes()
    assert is_complete(out)
    for length in range(0, len(data), 1 + len(data) // 60):
        out.write_bytes(data[:length])
        assert not is_complete(out), length
    out.write_bytes(data[:-20])
    export_shot(capsys, shot_file, out, *SHOWN)
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


@pytest.mark.draws_in_process
@pytest.mark.parametrize(
    ("suffix", "left_kb"), [(".jpg", 2), (".png", 0), (".exr", 2), (".mov", 0)]
)
def test_export_to_full_disk_reports_it_and_leaves_no_partial_file(
    capsys, small_disk, shot_file, suffix, left_kb
):
    """The export runs in its own process, because a movie on a full disk may end it by a signal."""
    disk_stat = os.statvfs(small_disk)
    (small_disk / "filler").write_bytes(
        b"x" * (disk_stat.f_bavail * disk_stat.f_frsize - left_kb * 1024)
    )
    name = f"n{suffix}" if suffix in (".mov", ".mp4") else f"n.####{suffix}"
    words = () if suffix == ".exr" else SHOWN
    process = start_heatlens("export", shot_file, "-o", small_disk / name, *words)
    message = process.communicate(timeout=PATIENCE_S)[1].splitlines()[-1]
    assert process.returncode == 2 and ".part" not in message
    assert "could not be written" in message or "are free on that disk" in message
    assert parts_in(small_disk) == []
    (small_disk / "filler").unlink()
    for left in small_disk.iterdir():
        assert is_complete(left)
    export_shot(capsys, shot_file, small_disk / name, *words)
    assert all(is_complete(path) for path in small_disk.iterdir())


def test_write_atomically_detects_missing_bytes(tmp_path, monkeypatch):
    """Some network disks end a file where their quota cuts it."""
    real = os.fstat

    def short(handle):
        found = real(handle)
        return os.stat_result((*found[:6], max(found.st_size - 1, 0), *found[7:10]))

    monkeypatch.setattr(atomic_file.os, "fstat", short)
    (tmp_path / "a").write_bytes(b"before")
    with pytest.raises(InputError, match="only 3 of 4 bytes are on the disk"):
        write_atomically(tmp_path / "a", b"four")
    assert files_in(tmp_path) == {"a": b"before"}


# Where nothing can be written


@pytest.mark.parametrize("code", [errno.EROFS, errno.EIO, errno.ESTALE])
def test_replacing_reports_write_error_although_removal_fails(tmp_path, monkeypatch, code):
    def refuses(self, missing_ok=False):
        raise OSError(code, os.strerror(code), str(self))

    monkeypatch.setattr(Path, "unlink", refuses)
    with (
        pytest.raises(InputError, match="disk on fire") as caught,
        replace_atomically(tmp_path / "a.exr"),
    ):
        raise OSError("disk on fire")
    assert ".part" not in str(caught.value)


@pytest.mark.parametrize("letters", [200, 233, 251, 255])
def test_write_png_accepts_every_name_that_the_disk_takes(tmp_path, letters):
    path = tmp_path / ("n" * (letters - 4) + ".png")
    write_png(path, np.ones((2, 2, 3), np.float32))
    assert is_complete(path)


def test_write_png_reports_name_too_long_for_the_disk(tmp_path):
    with pytest.raises(InputError, match="could not be written: File name too long"):
        write_png(tmp_path / ("n" * 300 + ".png"), np.ones((2, 2, 3), np.float32))
    assert files_in(tmp_path) == {}


def test_replacing_does_not_open_existing_file_or_link(tmp_path, monkeypatch):
    """A known name of the temporary file does no harm: existing files are refused."""
    monkeypatch.setattr(atomic_file.secrets, "token_hex", lambda count: "0" * 2 * count)
    precious = tmp_path / "precious"
    precious.write_bytes(b"precious")
    with replace_atomically(tmp_path / "a") as temporary_path:
        temporary_path.write_bytes(b"a")
    temporary_path.symlink_to(precious)
    with pytest.raises(InputError, match="File exists"), replace_atomically(tmp_path / "a"):
        pass
    assert precious.read_bytes() == b"precious"


def test_replacing_uses_short_and_unique_temporary_names(tmp_path):
    with (
        replace_atomically(tmp_path / ("a" * 200)) as first,
        replace_atomically(tmp_path / "a") as second,
    ):
        assert first.name != second.name and max(len(first.name), len(second.name)) < 60
        assert re.fullmatch(r"\.heatlens-[0-9a-f]{16}\.[0-9a-f]{8}\.\d+\.part", first.name)
        first.write_bytes(b"1")
        second.write_bytes(b"2")


def test_export_to_read_only_disk_reports_it_in_one_sentence(tmp_path, shot_file):
    folder = tmp_path / "readonly"
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", folder]).returncode:
        pytest.skip("mounting is not allowed here")
    try:
        process = start_heatlens("export", shot_file, "-o", folder / "n.####.exr")
        message = process.communicate(timeout=PATIENCE_S)[1]
    finally:
        subprocess.run(["umount", folder], check=True)
    assert process.returncode == 2
    (sentence,) = message.splitlines()
    assert sentence.startswith(f"heatlens: {folder}/n.")
    assert sentence.endswith(f"{folder} is not writable. Choose another folder.")


def test_written_jpeg_loads_completely(tmp_path):
    path = tmp_path / "a.jpg"
    write_png(path, np.random.default_rng(0).random((40, 60, 3)).astype(np.float32))
    with Image.open(path) as image:
        image.load()
