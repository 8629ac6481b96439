"""Test paths of Windows on this system, URLs of files, and paths too long for Windows."""

import json
from pathlib import Path, PurePosixPath, PureWindowsPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.named_paths import path_in_folder, path_note, path_of_url
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.exports import shot_of, write_plate

names = st.text(st.sampled_from("ab Zé#%&;=+,'0"), min_size=1, max_size=6).filter(
    lambda name: name == name.strip()
)
roots = st.sampled_from(["C:/", "z:\\", "\\\\server\\share\\", "\\\\10.0.0.7\\plates$\\"])
folders = st.lists(names, min_size=1, max_size=3)


@given(roots, folders)
def test_path_of_windows_keeps_drive_or_server(root, parts):
    path = PureWindowsPath(root, *parts)
    for text in (str(path), path.as_posix()):
        assert path_in_folder(text, "/somewhere") == path.as_posix()


@given(folders)
def test_path_of_this_system_begins_at_folder(parts):
    path = PurePosixPath(*parts)
    assert path_in_folder(str(path), "/a/b") == f"/a/b/{path}"
    assert path_in_folder(f"/{path}", "/a/b") == f"/{path}"


@given(roots, folders)
def test_path_of_url_inverts_urls_of_python(root, parts):
    windows_path, posix_path = PureWindowsPath(root, *parts), PurePosixPath("/", *parts)
    assert path_of_url(windows_path.as_uri()) == windows_path.as_posix()
    assert path_of_url(posix_path.as_uri()) == str(posix_path)
    assert path_of_url(posix_path.as_uri().replace("//", "//localhost", 1)) == str(posix_path)
    assert path_of_url("file:///a/shot.####.exr") == "/a/shot.####.exr"


@pytest.mark.parametrize("folder", ["C:/plates", "//server/share"])
@pytest.mark.parametrize("is_backslashed", [False, True])
def test_shot_of_windows_is_found_where_moved_says(tmp_path, capsys, folder, is_backslashed):
    (tmp_path / "here").mkdir()
    write_plate(tmp_path / "here" / "a.exr")
    source, shot = f"{folder}/a.exr", tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(source))
    typed = folder.replace("/", "\\") if is_backslashed else folder
    written = json.dumps(source.replace(folder + "/", f"{typed}\\") if is_backslashed else source)
    shot.write_text(shot.read_text().replace(json.dumps(source), written))
    assert read_shot(shot).source == source
    words = ["export", str(shot), "--frames", "1", "-o", str(tmp_path / "out.exr")]
    assert main(words) == 2
    assert "--moved" in capsys.readouterr().err or folder.startswith("//")
    assert main([*words, "--moved", typed, str(tmp_path / "here")]) == 0


def test_long_path_is_told_on_windows_alone(monkeypatch):
    path = Path("/a", *["folder"] * 40, "a.exr")
    assert path_note(path) == ""
    monkeypatch.setattr("sys.platform", "win32")
    assert str(len(str(path))) in path_note(path) and "LongPathsEnabled" in path_note(path)
    assert path_note(Path("/a/b.exr")) == ""
